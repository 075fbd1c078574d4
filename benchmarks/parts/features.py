"""Sharp edges and corners of a shape, from the normals of its faces along their edges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
from OCP.GCPnts import GCPnts_AbscissaPoint, GCPnts_UniformAbscissa
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.gp import gp_Pnt, gp_Vec
from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS

from crispline import occt
from crispline.surface import unit
from crispline.surface.base import Array
from parts.truth import Features

SHARP_DEG = 10.0
"""An edge is sharp where the outward normals of its faces differ by more than this."""
KINK_DEG = 30.0
"""Two sharp edges that meet at a larger turn make a corner."""
_STEP = 0.001
"""Distance between the points at which edges are looked at, over the diagonal."""


class FaceNormals:
    """Points and outward normals of a face at given parameters."""

    def __init__(self, face: Any) -> None:
        self.face = face
        self._surface = BRepAdaptor_Surface(face, True)
        is_reversed = face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED
        self._sign = -1.0 if is_reversed else 1.0

    @property
    def is_cone(self) -> bool:
        """Whether the surface is a cone."""
        return bool(self._surface.GetType() == GeomAbs_SurfaceType.GeomAbs_Cone)

    def at(self, parameters: Array) -> tuple[Array, Array]:
        """Points and normals, both ``(n, 3)``, at ``(n, 2)`` parameters; NaN at a pole."""
        rows = np.empty((len(parameters), 9))
        point, along_u, along_v = gp_Pnt(), gp_Vec(), gp_Vec()
        for row, (u, v) in zip(rows, parameters.tolist(), strict=True):
            self._surface.D1(u, v, point, along_u, along_v)
            row[:] = [f() for q in (point, along_u, along_v) for f in (q.X, q.Y, q.Z)]
        d_u, d_v = rows[:, 3:6], rows[:, 6:9]
        normals = np.cross(d_u, d_v)
        sizes = np.linalg.norm(normals, axis=1)
        scale = np.linalg.norm(d_u, axis=1) * np.linalg.norm(d_v, axis=1)
        sizes[sizes <= 1e-12 * np.maximum(1.0, scale)] = np.nan
        return rows[:, :3], self._sign * normals / sizes[:, None]


def shape_features(shape: Any, diagonal: float) -> Features:
    """Sharp edges and corners of a shape.

    Each edge is looked at in points ``0.001 * diagonal`` apart; the runs where its two
    faces meet at more than ``SHARP_DEG`` are polylines. A seam counts where the surface
    itself has a crease there; an edge of one face only is a ``boundary``.
    """
    faces = [FaceNormals(face) for face in occt.subshapes(shape, occt.FACE)]
    vertices = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, occt.VERTEX, vertices)
    polylines: list[Array] = []
    kinds: list[str] = []
    ends: dict[object, list[_End]] = {}
    apexes: dict[int, Array] = {}
    for uses in _uses(shape, faces).values():
        edge = uses[0][1]
        tips = [vertices.FindIndex(v) for v in _tips(edge)]
        if BRep_Tool.Degenerated_s(edge):
            if any(faces[index].is_cone for index, _ in uses):
                tip = BRep_Tool.Pnt_s(TopoDS.Vertex(vertices.FindKey(tips[0])))
                apexes[tips[0]] = np.array([tip.X(), tip.Y(), tip.Z()])
            continue
        parameters, points = _along(edge, _STEP * diagonal)
        kind = "boundary" if len(uses) == 1 else "sharp"
        keep = np.ones(len(points), dtype=bool)
        if kind == "sharp":
            keep = _angles(uses, faces, parameters) > np.radians(SHARP_DEG)
        for first, last in _runs(keep):
            line = points[first : last + 1]
            polylines.append(line)
            kinds.append(kind)
            for tip_index, is_tip, end in (
                (tips[0], first == 0, _End(line[0], unit(line[1] - line[0]), kind)),
                (tips[1], last == len(points) - 1, _End(line[-1], unit(line[-2] - line[-1]), kind)),
            ):
                # A run that stops within its edge ends there alone.
                key = tip_index if is_tip else (len(polylines), tip_index, first)
                ends.setdefault(key, []).append(end)
    corners = [*_corners(ends), *((place, "apex") for place in apexes.values())]
    return Features(
        tuple(polylines),
        tuple(kinds),
        np.array([place for place, _ in corners]).reshape(-1, 3),
        tuple(kind for _, kind in corners),
    )


@dataclass(frozen=True)
class _End:
    """An end of a polyline: where, the unit vector along it from there, and of what kind."""

    place: Array
    inward: Array
    kind: str


def _uses(shape: Any, faces: list[FaceNormals]) -> dict[int, list[tuple[int, Any]]]:
    """Edge index to the faces that use it, each with the edge as that face orients it."""
    edges = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, occt.EDGE, edges)
    uses: dict[int, list[tuple[int, Any]]] = {}
    for index, normals in enumerate(faces):
        explorer = TopExp_Explorer(normals.face, TopAbs_ShapeEnum.TopAbs_EDGE)
        while explorer.More():
            edge = occt.as_edge(explorer.Current())
            uses.setdefault(edges.FindIndex(edge), []).append((index, edge))
            explorer.Next()
    return uses


def _tips(edge: Any) -> tuple[Any, Any]:
    """The vertices at the low and the high parameter."""
    return TopExp.FirstVertex_s(edge, False), TopExp.LastVertex_s(edge, False)


def _along(edge: Any, step: float) -> tuple[Array, Array]:
    """Parameters ``(n,)`` and points ``(n, 3)`` about ``step`` apart along an edge."""
    curve = BRepAdaptor_Curve(edge)
    length = GCPnts_AbscissaPoint.Length_s(curve)
    count = int(np.clip(np.ceil(length / step), 8, 5000)) + 1
    even = GCPnts_UniformAbscissa(curve, count, 1e-7)
    if even.IsDone() and even.NbPoints() > 1:
        parameters = np.array([even.Parameter(i) for i in range(1, even.NbPoints() + 1)])
    else:
        parameters = np.linspace(curve.FirstParameter(), curve.LastParameter(), count)
    places = (curve.Value(t) for t in parameters.tolist())
    return parameters, np.array([(p.X(), p.Y(), p.Z()) for p in places])


def _angles(uses: list[tuple[int, Any]], faces: list[FaceNormals], parameters: Array) -> Array:
    """Angle between the outward normals of the first two sides of an edge, shape ``(n,)``."""
    indices = sorted({index for index, _ in uses})
    sides = uses[:2]
    if len(indices) > 1:
        sides = [next(use for use in uses if use[0] == index) for index in indices[:2]]
    normals = []
    for index, edge in sides:
        curve = BRep_Tool.CurveOnSurface_s(edge, faces[index].face, 0.0, 0.0)
        places = (curve.Value(t) for t in parameters.tolist())
        _, normal = faces[index].at(np.array([(p.X(), p.Y()) for p in places]))
        normals.append(_filled(normal))
    return np.asarray(np.arccos(np.clip((normals[0] * normals[1]).sum(axis=1), -1.0, 1.0)))


def _filled(normals: Array) -> Array:
    """Unknown normals taken from the nearest known ones; all unknown: zero."""
    known = np.flatnonzero(np.isfinite(normals[:, 0]))
    if len(known) == 0:
        return np.zeros_like(normals)
    nearest = np.abs(np.arange(len(normals))[:, None] - known).argmin(axis=1)
    return np.asarray(normals[known[nearest]])


def _runs(keep: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last index of every run of at least two."""
    steps = np.diff(np.concatenate([[0], keep.astype(np.int8), [0]]))
    starts, stops = np.flatnonzero(steps == 1), np.flatnonzero(steps == -1)
    for first, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        if stop - first > 1:
            yield first, stop - 1


def _corners(ends: dict[object, list[_End]]) -> Iterator[tuple[Array, str]]:
    for meeting in ends.values():
        place = np.mean([end.place for end in meeting], axis=0)
        if len(meeting) > 2:
            yield place, "corner"
        elif len(meeting) == 2:
            turn = np.pi - np.arccos(np.clip(meeting[0].inward @ meeting[1].inward, -1.0, 1.0))
            if np.degrees(turn) > KINK_DEG:
                yield place, "kink"
        elif meeting[0].kind != "boundary":
            yield place, "end"
