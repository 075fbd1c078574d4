"""Accuracy on the paper's model: a table of feature errors over samplings, noise levels, seeds.

    python benchmarks/box_cylinder.py [--seeds 5] [--points 34000] [--json FILE]

Every model is written as STEP and read back; what is measured is the file. Lengths
are in point spacings, so 1 is the mean distance between neighbouring points:

straight, lower, upper, corners : mean distance of the true features (100 points an
    edge) to the model, the paper's measure
reverse : 99 % quantile of the distance of the model to the true surface
"""

from __future__ import annotations

import argparse
import json
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np

import crispline
from crispline.brep.check import check_shape
from crispline.cadfile.step import read_step
from crispline.gauge.accuracy import feature_counts, shape_distances, surface_samples
from crispline.shapes import (
    SAMPLINGS,
    Sample,
    Sampling,
    box_cylinder,
    distance_to_box_cylinder,
    sample,
)
from crispline.surface.base import Array

NOISE_LEVELS = (0.0, 0.01, 0.02, 0.05)
OUTLIER_CASES = ((0.02, 0.1),)
N_REVERSE = 50_000


@dataclass(frozen=True)
class Case:
    """One simulated scan."""

    sampling: Sampling
    noise: float
    outliers: float
    seed: int


@dataclass(frozen=True)
class Score:
    """What came of it; lengths in spacings, NaN where there is no model."""

    straight: float = np.nan
    lower: float = np.nan
    upper: float = np.nan
    corners: float = np.nan
    reverse: float = np.nan
    n_faces: int = 0
    n_edges: int = 0
    n_corners: int = 0
    is_valid: bool = False
    seconds: float = np.nan
    message: str = ""


def cases(n_seeds: int) -> Iterator[Case]:
    """All noise levels without outliers, then the cases with outliers."""
    scans = [(noise, 0.0) for noise in NOISE_LEVELS] + list(OUTLIER_CASES)
    for (noise, outliers), sampling, seed in product(scans, SAMPLINGS, range(n_seeds)):
        yield Case(sampling, noise, outliers, seed)


def run(case: Case, n_points: int) -> Score:
    """Reconstruct one scan and score the STEP file."""
    scan = sample(
        box_cylinder(),
        n_points,
        sampling=case.sampling,
        noise=case.noise,
        outliers=case.outliers,
        seed=case.seed,
    )
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.step"
        try:
            crispline.reconstruct(scan.points).write(path)
        except crispline.CrisplineError as failure:
            return Score(seconds=time.perf_counter() - start, message=str(failure))
        seconds = time.perf_counter() - start
        model = read_step(path)

    def error(points: Array) -> float:
        return float(shape_distances(points, model).mean() / scan.spacing)

    feature = {
        kind: np.concatenate([edge.points for edge in scan.shape.edges if edge.kind == kind])
        for kind in ("straight", "lower circle", "upper circle")
    }
    n_faces, n_edges, n_corners = feature_counts(model)
    return Score(
        straight=error(feature["straight"]),
        lower=error(feature["lower circle"]),
        upper=error(feature["upper circle"]),
        corners=error(scan.shape.corners),
        reverse=reverse_error(model, scan),
        n_faces=n_faces,
        n_edges=n_edges,
        n_corners=n_corners,
        is_valid=check_shape(model).is_valid,
        seconds=seconds,
    )


def reverse_error(model: object, scan: Sample) -> float:
    """99 % quantile of the distance of points on the model to the true surface, in spacings."""
    points = surface_samples(model, N_REVERSE, 0.002 * scan.spacing)
    return float(np.quantile(distance_to_box_cylinder(points), 0.99) / scan.spacing)


def table(results: Sequence[tuple[Case, Score]]) -> Iterator[str]:
    """Lines of a Markdown table: the mean over the seeds, the worst for reverse and time."""
    yield (
        "| noise | outliers | sampling | straight | lower | upper | corners | reverse p99 "
        "| 8 / 14 / 8 | valid | seconds |"
    )
    yield "|---|---|---|---|---|---|---|---|---|---|---|"
    groups: dict[tuple[float, float, str], list[Score]] = {}
    for case, score in results:
        groups.setdefault((case.noise, case.outliers, case.sampling), []).append(score)
    for (noise, outliers, sampling), scores in groups.items():
        means = " | ".join(
            f"{np.mean([getattr(score, name) for score in scores]):.4f}"
            for name in ("straight", "lower", "upper", "corners")
        )
        n_right = sum((s.n_faces, s.n_edges, s.n_corners) == (8, 14, 8) for s in scores)
        yield (
            f"| {noise:.1%} | {outliers:.0%} | {sampling} | {means} "
            f"| {max(s.reverse for s in scores):.4f} | {n_right} of {len(scores)} "
            f"| {sum(s.is_valid for s in scores)} of {len(scores)} "
            f"| {max(s.seconds for s in scores):.1f} |"
        )


def main() -> None:
    """Run all cases and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--points", type=int, default=34_000)
    parser.add_argument("--json", type=Path, help="also write every single score")
    arguments = parser.parse_args()
    results = []
    for case in cases(arguments.seeds):
        score = run(case, arguments.points)
        results.append((case, score))
        print(f"{case} {score.seconds:.1f} s {score.message}", flush=True)
    print(*table(results), sep="\n")
    if arguments.json:
        rows = [asdict(case) | asdict(score) for case, score in results]
        arguments.json.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
