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
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.gp import gp_Pnt
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_ShapeEnum,
    TopAbs_VERTEX,
)
from OCP.TopExp import TopExp_Explorer
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS, TopoDS_Shape

import crispline
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
        return float(distance_to_model(points, model).mean() / scan.spacing)

    feature = {
        kind: np.concatenate([edge.points for edge in scan.shape.edges if edge.kind == kind])
        for kind in ("straight", "lower circle", "upper circle")
    }
    n_edges, n_corners = count_edges_and_corners(model)
    return Score(
        straight=error(feature["straight"]),
        lower=error(feature["lower circle"]),
        upper=error(feature["upper circle"]),
        corners=error(scan.shape.corners),
        reverse=reverse_error(model, scan),
        n_faces=len(list(parts(model, TopAbs_FACE))),
        n_edges=n_edges,
        n_corners=n_corners,
        is_valid=BRepCheck_Analyzer(model).IsValid(),
        seconds=seconds,
    )


def read_step(path: Path) -> TopoDS_Shape:
    """Shape of a STEP file, as another program would read it."""
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        raise RuntimeError(f"{path} is not a readable STEP file")
    reader.TransferRoots()
    return reader.OneShape()


def parts(shape: TopoDS_Shape, kind: TopAbs_ShapeEnum) -> Iterator[TopoDS_Shape]:
    """Yield the sub-shapes of a kind, once for every use."""
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def count_edges_and_corners(model: TopoDS_Shape) -> tuple[int, int]:
    """Count edges between two different faces (no seams) and vertices where three or more meet."""
    # The bindings compare shapes by their wrappers; the hash tells which are the same.
    faces_at: dict[int, set[int]] = {}
    ends_of: dict[int, set[int]] = {}
    for face in parts(model, TopAbs_FACE):
        for edge in parts(face, TopAbs_EDGE):
            faces_at.setdefault(hash(edge), set()).add(hash(face))
            ends_of[hash(edge)] = {hash(vertex) for vertex in parts(edge, TopAbs_VERTEX)}
    edges = [edge for edge, faces in faces_at.items() if len(faces) == 2]
    degree = Counter(vertex for edge in edges for vertex in ends_of[edge])
    return len(edges), sum(n >= 3 for n in degree.values())


def distance_to_model(points: Array, model: TopoDS_Shape) -> Array:
    """Exact distance of points ``(n, 3)`` to the nearest face, shape ``(n,)``."""
    faces = list(parts(model, TopAbs_FACE))
    distances = []
    for x, y, z in points.tolist():
        vertex = BRepBuilderAPI_MakeVertex(gp_Pnt(x, y, z)).Vertex()
        distances.append(min(BRepExtrema_DistShapeShape(vertex, face).Value() for face in faces))
    return np.array(distances)


def reverse_error(model: TopoDS_Shape, scan: Sample) -> float:
    """99 % quantile of the distance of points on the model to the true surface, in spacings."""
    BRepMesh_IncrementalMesh(model, 0.002 * scan.spacing, False, 0.05, True)
    corners = np.concatenate([triangles(face) for face in parts(model, TopAbs_FACE)])
    a, b, c = corners.transpose(1, 0, 2)
    areas = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    stream = np.random.default_rng(0)
    chosen = stream.choice(len(areas), N_REVERSE, p=areas / areas.sum())
    u, v = stream.random((2, N_REVERSE, 1))
    u, v = np.where(u + v > 1.0, (1.0 - u, 1.0 - v), (u, v))
    points = a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]
    return float(np.quantile(distance_to_box_cylinder(points), 0.99) / scan.spacing)


def triangles(face: TopoDS_Shape) -> Array:
    """Triangles of a meshed face, shape ``(m, 3, 3)``."""
    location = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(TopoDS.Face(face), location)
    nodes = [mesh.Node(i + 1).Transformed(location.Transformation()) for i in range(mesh.NbNodes())]
    vertices = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
    indices = np.array([mesh.Triangle(i + 1).Get() for i in range(mesh.NbTriangles())]) - 1
    return np.asarray(vertices[indices])


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
