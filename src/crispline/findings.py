"""What a result reports of its edges, corners and faces, in the user's units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crispline.brep.check import Check
from crispline.curve import Curve
from crispline.gauge.certificate import Residuals
from crispline.model import Edge, Model
from crispline.surface.base import Array

_KINK_DEG = 30.0  # two sharp edges that meet at a larger turn form a corner


@dataclass(frozen=True)
class EdgeReport:
    """One edge of the model, in the user's units.

    Attributes
    ----------
    curve : its exact geometry.
    points : polyline along the edge, shape ``(k, 3)``; a closed edge ends where it starts.
    kind : ``line``, ``circle`` or ``bspline``.
    angle_deg : angle between the outward normals of its two faces.
    length : arc length.
    is_sharp : False where the two faces are tangent.
    faces : the faces on its left and right, -1 for none.
    gap : largest distance of the curve from the two surfaces.
    """

    curve: Curve
    points: Array
    kind: str
    angle_deg: float
    length: float
    is_sharp: bool
    faces: tuple[int, int]
    gap: float


@dataclass(frozen=True)
class FaceReport:
    """One face of the model with its residuals, in the user's units.

    Attributes
    ----------
    kind, parameters : the surface; lengths, points and unit directions, angles in degrees.
    area : of the trimmed face; NaN if no solid was built.
    n_points : points of the cloud, without outliers, that are nearest to the face; those that
        it was fitted to if no valid model was built.
    rms, p95, max, mean : of their signed distances to it (p95 and max of the size); NaN for none.
    explained : share of them within 3 sigma of the noise, see `Certificate`.
    """

    kind: str
    parameters: Mapping[str, float | list[float]]
    area: float
    n_points: int
    rms: float
    p95: float
    max: float
    mean: float
    explained: float


def numbers(found: Residuals | FaceReport) -> dict[str, float | int | None]:
    """Residuals in JSON-ready form."""
    names = ("n_points", "rms", "p95", "max", "mean", "explained")
    values = {name: getattr(found, name) for name in names}
    return {name: None if np.isnan(value) else value for name, value in values.items()}


def edge_report(edge: Edge, spacing: float) -> EdgeReport:
    """What is told of an edge; its polyline has about two points a spacing."""
    dense = edge.curve.samples(2 if edge.curve.kind == "line" else 201)
    length = float(np.linalg.norm(np.diff(dense, axis=0), axis=1).sum())
    n_points = 2 if edge.curve.kind == "line" else int(np.clip(2.0 * length / spacing, 8, 2000))
    points = edge.curve.samples(n_points)
    if edge.start == edge.end:
        points[-1] = points[0]
    return EdgeReport(
        curve=edge.curve,
        points=points,
        kind=edge.curve.kind,
        angle_deg=float(np.degrees(edge.angle)),
        length=length,
        is_sharp=edge.is_sharp,
        faces=(edge.left, edge.right),
        gap=edge.gap,
    )


def corner_vertices(model: Model) -> list[int]:
    """Vertices with three or more sharp edge ends, or two that turn."""
    ends: dict[int, list[Array]] = {}
    for edge in model.edges:
        if not edge.is_sharp:
            continue
        tips = edge.curve.samples(201)
        for vertex, tip, inward in ((edge.start, tips[0], tips[1]), (edge.end, tips[-1], tips[-2])):
            ends.setdefault(vertex, []).append((inward - tip) / np.linalg.norm(inward - tip))
    limit = -np.cos(np.radians(_KINK_DEG))
    return [
        vertex
        for vertex, tangents in sorted(ends.items())
        if len(tangents) > 2 or (len(tangents) == 2 and float(tangents[0] @ tangents[1]) > limit)
    ]


def faults(model: Model, check: Check) -> str:
    """What a check found wrong with the shape of a model, in one sentence."""
    found: dict[int, list[str]] = {}
    for fault in check.bad_faces:
        found.setdefault(fault.index, []).append(fault.reason)
    reasons = [
        f"face {index}{_place(model, index)}: {', '.join(reasons_of)}"
        for index, reasons_of in list(found.items())[:3]
    ]
    if len(found) > len(reasons):
        reasons.append(f"{len(found) - len(reasons)} more faces")
    reasons += check.problems
    if not (check.is_closed or check.may_be_open):
        reasons.append("the shell has free edges")
    if check.n_uncovered:
        reasons.append(f"{check.n_uncovered} points lie off the model")
    return (
        f"no valid model could be made: {'; '.join(reasons) or 'the shape is faulty'}; "
        "scan these places more densely"
    )


def _place(model: Model, index: int) -> str:
    """Where a face lies, for a message: the middle of its border, in the user's unit."""
    if index < 0:
        return ""
    uses = {edge for loop in model.faces[index].loops for edge, _ in loop}
    places = [model.edges[edge].curve.samples(9) for edge in sorted(uses)]
    points = np.concatenate([*places, model.faces[index].points])
    if len(points) == 0:
        return ""
    return " near ({:.4g}, {:.4g}, {:.4g})".format(*np.median(points, axis=0))
