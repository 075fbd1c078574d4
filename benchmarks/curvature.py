"""Speed of curvature and detection on a grid, beside a plain stencil and beside geomdl.

    python benchmarks/curvature.py [--patches 1000000] [--geomdl-patches 400] [--json FILE]

Set OMP_NUM_THREADS=1 for one thread throughout. The plain stencil adds up 16 shifted
arrays for each of the five derivatives at the patch centres and computes the same
curvature from them; geomdl evaluates the same derivatives patch by patch. Memory is the
peak above the input.
"""

from __future__ import annotations

import argparse
import json
import time
import tracemalloc
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crispline.grid import curvature, detect
from crispline.spline.tensor import spline_over_grid
from crispline.surface.base import Array

POSITION = np.array([1.0, 23.0, 23.0, 1.0]) / 48.0
FIRST = np.array([-1.0, -5.0, 5.0, 1.0]) / 8.0
SECOND = np.array([1.0, -1.0, -1.0, 1.0]) / 2.0
N_REPEATS = 3


def plain_curvature(points: Array) -> Array:
    """Mean curvature at the patch centres by sums of 16 terms, shape ``(m - 1, n - 1)``."""
    net = np.pad(points, ((1, 1), (1, 1), (0, 0)))
    net[0], net[-1] = 2.0 * net[1] - net[2], 2.0 * net[-2] - net[-3]
    net[:, 0], net[:, -1] = 2.0 * net[:, 1] - net[:, 2], 2.0 * net[:, -2] - net[:, -3]
    m, n = points.shape[0] - 1, points.shape[1] - 1

    def derivative(along_u: Array, along_v: Array) -> Array:
        total = np.zeros((m, n, 3))
        for a in range(4):
            for b in range(4):
                total += along_u[a] * along_v[b] * net[a : a + m, b : b + n]
        return total

    du, dv = derivative(FIRST, POSITION), derivative(POSITION, FIRST)
    duu, duv = derivative(SECOND, POSITION), derivative(FIRST, FIRST)
    dvv = derivative(POSITION, SECOND)
    return curvature_of(du, dv, duu, duv, dvv)


def curvature_of(du: Array, dv: Array, duu: Array, duv: Array, dvv: Array) -> Array:
    """The paper's formula, term by term."""
    across = np.cross(du, dv)
    normal = across / np.linalg.norm(across, axis=-1, keepdims=True)
    e, f, g = (np.sum(a * b, axis=-1) for a, b in ((du, du), (du, dv), (dv, dv)))
    second_l, second_m, second_n = (np.sum(d * normal, axis=-1) for d in (duu, duv, dvv))
    top = e * second_n - 2.0 * f * second_m + g * second_l
    return np.asarray(top / (2.0 * (e * g - f * f)))


def geomdl_seconds(points: Array, n_patches: int) -> float:
    """Seconds that geomdl takes for one patch centre's curvature."""
    from geomdl import BSpline

    spline = spline_over_grid(points)
    surface = BSpline.Surface(normalize_kv=False)
    surface.degree_u = surface.degree_v = 3
    n_u, n_v = spline.control_points.shape[:2]
    surface.set_ctrlpts(spline.control_points.reshape(-1, 3).tolist(), n_u, n_v)
    surface.knotvector_u, surface.knotvector_v = spline.knots_u.tolist(), spline.knots_v.tolist()
    rng = np.random.default_rng(0)
    cells = rng.integers(0, min(points.shape[:2]) - 1, (n_patches, 2)) + 0.5
    start = time.perf_counter()
    for u, v in cells.tolist():
        ders = surface.derivatives(u, v, 2)
        parts = (ders[1][0], ders[0][1], ders[2][0], ders[1][1], ders[0][2])
        curvature_of(*(np.array(part) for part in parts))
    return (time.perf_counter() - start) / n_patches


def wavy(n: int) -> Array:
    """A folded sheet of ``n x n`` points with waves and a little noise."""
    i, j = np.mgrid[:n, :n].astype(float)
    height = -np.abs((j % 100.0) - 50.3) + 8.0 * np.sin(i / 90.0)
    grid = np.stack([i, j, height], axis=2)
    return grid + 0.01 * np.random.default_rng(0).normal(size=grid.shape)


def best_time(run: Callable[[], object]) -> float:
    """Least seconds of a few runs."""
    seconds = []
    for _ in range(N_REPEATS):
        start = time.perf_counter()
        run()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def peak_megabytes(run: Callable[[], object]) -> float:
    """Largest memory that a run holds at once above what there was."""
    tracemalloc.start()
    run()
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak / 1e6


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--patches", type=int, default=1_000_000)
    parser.add_argument("--geomdl-patches", type=int, default=400)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args(arguments)
    points = wavy(round(options.patches**0.5) + 1)

    def both() -> None:
        detect(points, curvature(points))

    plain = plain_curvature(points)
    worst = float(np.abs(curvature(points).mean - plain).max())
    small = wavy(185)
    rows: dict[str, Any] = {
        "patches": plain.size,
        "plain 16 terms, s": best_time(lambda: plain_curvature(points)),
        "curvature, s": best_time(lambda: curvature(points)),
        "curvature and detection, s": best_time(both),
        "largest difference": worst,
        "memory, MB": peak_megabytes(both),
        "plain memory, MB": peak_megabytes(lambda: plain_curvature(points)),
        "geomdl at 34,000 patches, us a patch": 1e6 * geomdl_seconds(small, options.geomdl_patches),
        "curvature at 34,000 patches, us a patch": 1e6
        * best_time(lambda: curvature(small))
        / 184**2,
    }
    rows["over plain"] = rows["curvature and detection, s"] / rows["plain 16 terms, s"]
    rows["times faster than geomdl"] = (
        rows["geomdl at 34,000 patches, us a patch"]
        / rows["curvature at 34,000 patches, us a patch"]
    )
    for name, value in rows.items():
        print(f"{name:45s} {value:12.4g}")
    if options.json is not None:
        options.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
