"""What a reconstruction returns."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np

from crispline.brep.compose import Solid
from crispline.brep.measure import face_areas
from crispline.brep.step import write_step
from crispline.errors import ReconstructionError
from crispline.model import Edge, Face, Model
from crispline.spline.creased import CreasedNet
from crispline.surface.base import Array

_KINK_DEG = 30.0  # two sharp edges that meet at a larger turn form a corner


@dataclass(frozen=True)
class EdgeReport:
    """One edge of the model, in the user's units.

    Attributes
    ----------
    points : polyline along the edge, shape ``(k, 3)``; a closed edge ends where it starts.
    kind : ``line``, ``circle`` or ``bspline``.
    angle_deg : angle between the outward normals of its two faces.
    length : arc length.
    is_sharp : False where the two faces are tangent.
    faces : the faces on its left and right, -1 for none.
    gap : largest distance of the curve from the two surfaces.
    """

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
    n_points : raw points that the face was fitted to.
    rms, p95, max, mean : of their signed distances to the surface (p95 and max of the size).
    """

    kind: str
    parameters: Mapping[str, float | list[float]]
    area: float
    n_points: int
    rms: float
    p95: float
    max: float
    mean: float


@dataclass(frozen=True)
class Reconstruction:
    """A model with what is known about it; lengths in the user's unit.

    Attributes
    ----------
    model : the boundary representation as plain values.
    patches : control net of the sharpened bicubic surface, one patch per quad.
    spacing : mean distance between neighbouring points.
    noise : standard deviation of the points along the surface normal.
    solid : the shape and the evidence for it, or None if none was built.
    timings : seconds per stage.
    warnings : sentences for the user.
    """

    model: Model
    patches: CreasedNet
    spacing: float
    noise: float
    solid: Solid | None = None
    timings: Mapping[str, float] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    @property
    def valid(self) -> bool:
        """Whether a shape was built that OCCT finds no fault in and that follows the cloud."""
        return self.solid is not None and self.solid.check.is_good

    @property
    def closed(self) -> bool:
        """Whether the shape is a solid without free edges."""
        return self.solid is not None and self.solid.check.is_closed

    @property
    def edges(self) -> tuple[EdgeReport, ...]:
        """Every edge, sharp and tangent."""
        return tuple(_edge_report(edge, self.spacing) for edge in self.model.edges)

    @property
    def faces(self) -> tuple[FaceReport, ...]:
        """Every face."""
        areas = np.full(len(self.model.faces), np.nan)
        if self.solid is not None and -1 not in self.solid.face_order:
            areas[list(self.solid.face_order)] = face_areas(self.solid.shape)
        return tuple(
            _face_report(face, float(area))
            for face, area in zip(self.model.faces, areas, strict=True)
        )

    @property
    def corners(self) -> Array:
        """Points where three sharp edges meet, or two at an angle, shape ``(c, 3)``."""
        return self.model.vertices[_corner_vertices(self.model)]

    def write(self, path: str | PathLike[str]) -> None:
        """Write the model as STEP, whole or not at all.

        Raises
        ------
        ReconstructionError
            If there is no valid model.
        """
        if self.solid is None or not self.valid:
            raise ReconstructionError("there is no valid model to write", self)
        write_step(self.solid.shape, path)

    def summary(self) -> dict[str, Any]:
        """Everything above in JSON-ready form; unknown numbers are None."""
        faces = [
            {
                "kind": face.kind,
                "parameters": dict(face.parameters),
                "area": None if np.isnan(face.area) else face.area,
                "n_points": face.n_points,
                "rms": face.rms,
                "p95": face.p95,
                "max": face.max,
                "mean": face.mean,
            }
            for face in self.faces
        ]
        edges = [
            {
                "kind": edge.kind,
                "length": edge.length,
                "angle_deg": edge.angle_deg,
                "is_sharp": edge.is_sharp,
                "faces": list(edge.faces),
                "gap": edge.gap,
            }
            for edge in self.edges
        ]
        check = None if self.solid is None else self.solid.check
        tolerance = None
        if check is not None:
            tolerance = max(check.edge_tolerance, check.vertex_tolerance)
        return {
            "valid": self.valid,
            "closed": self.closed,
            "n_faces": len(faces),
            "n_sharp_edges": sum(edge["is_sharp"] is True for edge in edges),
            "spacing": self.spacing,
            "noise": self.noise,
            "volume": None if check is None else check.volume,
            "largest_tolerance": tolerance,
            "faces": faces,
            "edges": edges,
            "corners": self.corners.tolist(),
            "timings": dict(self.timings),
            "warnings": list(self.warnings),
        }


def failure(result: Reconstruction) -> str:
    """Why a result is no valid model, in one sentence that names the regions."""
    if result.solid is None:
        return "no solid was built"
    check = result.solid.check
    found: dict[int, list[str]] = {}
    for fault in check.bad_faces:
        found.setdefault(fault.index, []).append(fault.reason)
    reasons = [
        f"face {index}{_place(result.model, index)}: {', '.join(faults)}"
        for index, faults in list(found.items())[:3]
    ]
    if len(found) > len(reasons):
        reasons.append(f"{len(found) - len(reasons)} more faces")
    reasons += check.problems
    if not check.is_closed:
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


def _edge_report(edge: Edge, spacing: float) -> EdgeReport:
    dense = edge.curve.samples(2 if edge.curve.kind == "line" else 201)
    length = float(np.linalg.norm(np.diff(dense, axis=0), axis=1).sum())
    n_points = 2 if edge.curve.kind == "line" else int(np.clip(2.0 * length / spacing, 8, 2000))
    points = edge.curve.samples(n_points)
    if edge.start == edge.end:
        points[-1] = points[0]
    return EdgeReport(
        points=points,
        kind=edge.curve.kind,
        angle_deg=float(np.degrees(edge.angle)),
        length=length,
        is_sharp=edge.is_sharp,
        faces=(edge.left, edge.right),
        gap=edge.gap,
    )


def _face_report(face: Face, area: float) -> FaceReport:
    size = np.abs(face.residuals) if len(face.residuals) else np.zeros(1)
    return FaceReport(
        kind=face.surface.kind,
        parameters=face.surface.parameters(),
        area=area,
        n_points=len(face.points),
        rms=float(np.sqrt(np.mean(size**2))),
        p95=float(np.quantile(size, 0.95)),
        max=float(size.max()),
        mean=float(np.mean(face.residuals)) if len(face.residuals) else 0.0,
    )


def _corner_vertices(model: Model) -> list[int]:
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
