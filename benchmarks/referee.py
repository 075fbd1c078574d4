"""Score a STEP model against the truth that its scan was made from.

    python benchmarks/referee.py MODEL.step TRUTH.npz [--json]

Lengths are in spacings of the cloud, ``sqrt(area / n_points)``. Truths are what
``parts_scan.py`` writes; see ``docs/benchmark.md`` for every figure.
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRepCheck import BRepCheck_Analyzer
from scipy.spatial import cKDTree

from crispline import occt
from crispline.cadfile.step import read_step
from crispline.gauge.deviation import point_triangle_distance, sample_triangles
from crispline.occt.measure import Tessellation, tessellate
from crispline.surface.base import Array
from parts.faces import by_inradius, recovered, true_faces
from parts.features import shape_features
from parts.truth import Truth, read_truth

MATCH = 1.0
"""A feature is found if it has its like within this, in spacings."""
_DEFLECTION = 0.002
"""Distance of the model's triangles from the model, in spacings."""
_MODEL_SAMPLES = 60_000
_CANDIDATES = 24
"""How many of the nearest samples name the triangles that a point is measured to."""


@dataclass(frozen=True)
class Score:
    """What a model is worth; lengths in spacings.

    Attributes
    ----------
    is_valid : OCCT finds no fault. is_closed : a solid without free edges.
    n_solids, n_faces : of the model.
    n_true_faces, n_cut_faces : of the truth, neighbours on one smooth surface as one face, and
        as the CAD system has cut them; None if the truth has no faces.
    tolerance : the largest of an edge or vertex; a big one hides a gap.
    edge_precision, edge_recall, edge_f1 : share of the length of the sharp edges of the model
        that lies within ``MATCH`` of a true one, the other way, their harmonic mean.
    edge_error : mean distance of the true sharp edges found from the model's.
    corner_precision, corner_recall : the same for corners and kinks.
    feature_to_surface : mean distance of the true sharp edges from the model, the paper's
        measure; NaN without any.
    surface_mean, surface_p99, surface_max : clean points to the model.
    reverse_mean, reverse_p99, reverse_max : points of the model to the true surface, which
        is the tangent plane in the nearest clean points; NaN without normals.
    recovered : true faces found one to one and all of them, with an inradius under 3
        spacings, 3 to 5, and over 5; None if the truth has no faces.
    """

    is_valid: bool
    is_closed: bool
    n_solids: int
    n_faces: int
    n_true_faces: int | None
    n_cut_faces: int | None
    tolerance: float
    edge_precision: float
    edge_recall: float
    edge_f1: float
    edge_error: float
    corner_precision: float
    corner_recall: float
    feature_to_surface: float
    surface_mean: float
    surface_p99: float
    surface_max: float
    reverse_mean: float
    reverse_p99: float
    reverse_max: float
    recovered: list[tuple[int, int]] | None


def score(shape: Any, truth: Truth) -> Score:
    """Score a shape, in the unit of the truth."""
    spacing = truth.spacing
    mesh = tessellate(shape, _DEFLECTION * spacing, 0.1)
    is_real = mesh.areas() > 0.0
    mesh = Tessellation(mesh.vertices, mesh.triangles[is_real], mesh.faces[is_real])
    reverse = _to_truth(_samples(mesh), truth)
    found = shape_features(shape, float(np.linalg.norm(np.ptp(mesh.vertices, axis=0))))
    want_edges, edges = truth.features.sharp(0.1 * spacing), found.sharp(0.1 * spacing)
    edge_distance = nearest(want_edges, edges) / spacing
    # Edges and clean points are measured at once, to sample the model once.
    both, owners = _to_model(np.concatenate([want_edges, truth.clean]), mesh, spacing)
    feature, surface = both[: len(want_edges)], both[len(want_edges) :]
    edge_precision = _share(nearest(edges, want_edges) / spacing, if_none=len(want_edges) == 0)
    edge_recall = _share(edge_distance, if_none=True)
    is_found = edge_distance < MATCH
    want_corners, corners = truth.features.scored_corners(), found.scored_corners()
    n_solids = len(occt.subshapes(shape, occt.SOLID))
    n_true, n_cut, groups = None, None, None
    if truth.n_faces is not None:
        faces = true_faces(truth)
        n_true, n_cut = len(faces.inradius), int(faces.given.max()) + 1
        groups = by_inradius(faces, recovered(faces, owners[len(want_edges) :]))
    return Score(
        is_valid=bool(BRepCheck_Analyzer(shape).IsValid()),
        is_closed=n_solids > 0 and "boundary" not in found.kinds,
        n_solids=n_solids,
        n_faces=len(occt.subshapes(shape, occt.FACE)),
        n_true_faces=n_true,
        n_cut_faces=n_cut,
        tolerance=max(occt.largest_tolerance(shape, kind) for kind in (occt.EDGE, occt.VERTEX))
        / spacing,
        edge_precision=edge_precision,
        edge_recall=edge_recall,
        edge_f1=2 * edge_precision * edge_recall / max(edge_precision + edge_recall, 1e-12),
        edge_error=float(edge_distance[is_found].mean()) if is_found.any() else float("nan"),
        corner_precision=_share(
            nearest(corners, want_corners) / spacing, if_none=len(want_corners) == 0
        ),
        corner_recall=_share(nearest(want_corners, corners) / spacing, if_none=True),
        feature_to_surface=float(feature.mean() / spacing) if len(feature) else float("nan"),
        **_spread("surface", surface / spacing),
        **_spread("reverse", reverse / spacing),
        recovered=groups,
    )


def nearest(points: Array, others: Array) -> Array:
    """Distance of each point to the nearest of the others; infinite if there are none."""
    if len(points) == 0 or len(others) == 0:
        return np.full(len(points), np.inf)
    return np.asarray(cKDTree(others).query(points)[0])


def _share(distances: Array, if_none: bool) -> float:
    """Share within ``MATCH``; of nothing, whether that is right."""
    return float((distances < MATCH).mean()) if len(distances) else float(if_none)


def _spread(name: str, distances: Array) -> dict[str, Any]:
    return {
        f"{name}_mean": float(distances.mean()),
        f"{name}_p99": float(np.quantile(distances, 0.99)),
        f"{name}_max": float(distances.max()),
    }


def _to_model(points: Array, mesh: Tessellation, spacing: float) -> tuple[Array, NDArray[np.int64]]:
    """Distance of points to the triangles and the face of the nearest one, both ``(n,)``."""
    samples, owners = _spread_samples(mesh, 0.25 * spacing)
    near = cKDTree(samples).query(points, k=min(_CANDIDATES, len(samples)))[1]
    best = np.full(len(points), np.inf)
    face = np.zeros(len(points), dtype=np.int64)
    for candidate in owners[near].T:
        distance = point_triangle_distance(points, mesh.vertices[mesh.triangles[candidate]])
        closer = distance < best
        best[closer], face[closer] = distance[closer], mesh.faces[candidate[closer]]
    return best, face


def _spread_samples(mesh: Tessellation, step: float) -> tuple[Array, NDArray[np.int64]]:
    """Points about ``step`` apart in the triangles and along their sides, ``(m, 3)``, and the
    triangle of each: the inside of a sliver alone would not tell of it.
    """
    inner, owners = sample_triangles(mesh, step)
    corners = mesh.vertices[mesh.triangles]
    points, triangles = [inner], [owners]
    for start, end in ((0, 1), (1, 2), (2, 0)):
        side = corners[:, end] - corners[:, start]
        count = np.ceil(np.linalg.norm(side, axis=1) / step).astype(np.int64)
        owner = np.repeat(np.arange(len(side)), count)
        place = np.arange(len(owner)) - np.repeat(np.cumsum(count) - count, count)
        points.append(corners[owner, start] + (place / count[owner])[:, None] * side[owner])
        triangles.append(owner)
    return np.concatenate(points), np.concatenate(triangles)


def _samples(mesh: Tessellation) -> Array:
    """Points of the model, uniform by area."""
    stream, areas = np.random.default_rng(0), mesh.areas()
    chosen = stream.choice(len(areas), _MODEL_SAMPLES, p=areas / areas.sum())
    a, b = stream.random((2, _MODEL_SAMPLES, 1))
    a, b = np.where(a + b > 1.0, (1.0 - a, 1.0 - b), (a, b))
    p, q, r = mesh.vertices[mesh.triangles[chosen]].transpose(1, 0, 2)
    return np.asarray(p + a * (q - p) + b * (r - p))


def _to_truth(points: Array, truth: Truth) -> Array:
    """Distance to the true surface: to the tangent planes in the clean points within two
    spacings, else to the points themselves; the least of six.
    """
    distance, near = cKDTree(truth.clean).query(points, k=6)
    offsets = points[:, None] - truth.clean[near]
    height = np.abs(np.einsum("nkd,nkd->nk", offsets, truth.normals[near]))
    return np.asarray(np.where(distance < 2.0 * truth.spacing, height, distance).min(axis=1))


def main() -> None:
    """Score one file."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("model", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    result = asdict(score(read_step(arguments.model), read_truth(arguments.truth)))
    if arguments.json:
        print(json.dumps(result))
        return
    for name, value in result.items():
        print(f"{name:18} {value:.4f}" if isinstance(value, float) else f"{name:18} {value}")


if __name__ == "__main__":
    main()
