"""A shape as the tables of an openNURBS solid."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher
from OCP.Geom import Geom_TrimmedCurve
from OCP.Geom2d import Geom2d_TrimmedCurve
from OCP.Geom2dConvert import Geom2dConvert
from OCP.GeomConvert import GeomConvert
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS

from crispline import occt
from crispline.cadfile.opennurbs import Brep, Edge, Face, Iso, Loop, Nurbs, Trim, TrimKind, Vertex
from crispline.surface.base import Array

_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
_REVERSED = TopAbs_Orientation.TopAbs_REVERSED
_SAME = 8.0 * np.sqrt(np.finfo(float).eps)
"""openNURBS takes parameters nearer than this share of their range for the same."""


def brep_tables(shape: Any) -> Brep:
    """The tables of a solid or shell, every surface and curve a NURBS.

    Parameters
    ----------
    shape : ``TopoDS_Shape``; it is not changed.
    """
    return _Tables(BRepBuilderAPI_NurbsConvert(shape, True).Shape()).brep()


class _Tables:
    """The tables while they are filled, face by face."""

    def __init__(self, shape: Any) -> None:
        self._shape = shape
        self._vertex_numbers = _numbers(shape, occt.VERTEX)
        edges = [e for e in occt.subshapes(shape, occt.EDGE) if not BRep_Tool.Degenerated_s(e)]
        self._edge_numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
        for edge in edges:
            self._edge_numbers.Add(edge)
        self._vertices = [_vertex(v) for v in occt.subshapes(shape, occt.VERTEX)]
        self._edges = [self._edge(number, edge) for number, edge in enumerate(edges)]
        self._trims: list[Trim] = []
        self._loops: list[Loop] = []
        self._faces: list[Face] = []

    def brep(self) -> Brep:
        for face in occt.subshapes(self._shape, occt.FACE):
            self._add_face(face)
        is_closed = True
        for edge in self._edges:
            if len(edge.trims) == 1:
                (lone,) = edge.trims
                self._trims[lone] = replace(self._trims[lone], kind=TrimKind.BOUNDARY)
                is_closed = False
        tables = (self._vertices, self._edges, self._trims, self._loops, self._faces)
        return Brep(*tables, is_solid=is_closed)

    def _edge(self, number: int, edge: Any) -> Edge:
        edge = occt.as_edge(edge.Oriented(_FORWARD))
        first, last = BRep_Tool.Range_s(edge)
        curve = BRep_Tool.Curve_s(edge, first, last)
        spline = GeomConvert.CurveToBSplineCurve_s(Geom_TrimmedCurve(curve, first, last))
        ends = [
            self._vertex_numbers.FindIndex(end) - 1
            for end in (TopExp.FirstVertex_s(edge), TopExp.LastVertex_s(edge))
        ]
        for end in ends:
            self._vertices[end].edges.append(number)
        return Edge(_curve(spline), ends[0], ends[1], float(BRep_Tool.Tolerance_s(edge)))

    def _add_face(self, face: Any) -> None:
        is_reversed = face.Orientation() == _REVERSED
        face = TopoDS.Face(face.Oriented(_FORWARD))
        self._surface = _surface(BRep_Tool.Surface_s(face))
        outer = BRepTools.OuterWire_s(face)
        wires = occt.subshapes(face, occt.WIRE)
        wires.sort(key=lambda wire: not wire.IsSame(outer))
        first = len(self._loops)
        for wire in wires:
            self._add_loop(wire, face, wire.IsSame(outer))
        loops = tuple(range(first, len(self._loops)))
        self._faces.append(Face(self._surface, loops, is_reversed))

    def _add_loop(self, wire: Any, face: Any, is_outer: bool) -> None:
        uses = _uses(wire, face)
        curves = [_pcurve(edge, face) for edge in uses]
        # Neighbours must meet in the parameter plane to the last digit.
        for curve, following in zip(curves, curves[1:] + curves[:1], strict=True):
            following.SetPole(1, curve.Pole(curve.NbPoles()))
        first = len(self._trims)
        for edge, curve in zip(uses, curves, strict=True):
            self._add_trim(edge, face, _curve_2d(curve))
        trims = tuple(range(first, len(self._trims)))
        self._loops.append(Loop(trims, is_outer, len(self._faces)))

    def _add_trim(self, edge: Any, face: Any, curve: Nurbs) -> None:
        is_reversed = edge.Orientation() == _REVERSED
        if BRep_Tool.Degenerated_s(edge):
            number, kind = -1, TrimKind.SINGULAR
            pole = self._vertex_numbers.FindIndex(TopExp.FirstVertex_s(edge)) - 1
            ends = [pole, pole]
        else:
            number = self._edge_numbers.FindIndex(edge) - 1
            kind = TrimKind.SEAM if BRep_Tool.IsClosed_s(edge, face) else TrimKind.MATED
            ends = [self._edges[number].start, self._edges[number].end]
            self._edges[number].trims.append(len(self._trims))
        start, end = reversed(ends) if is_reversed else ends
        iso = _iso(curve, self._surface)
        loop = len(self._loops)
        self._trims.append(Trim(curve, number, start, end, is_reversed, kind, iso, loop))


def _numbers(shape: Any, kind: Any) -> Any:
    numbers = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, kind, numbers)
    return numbers


def _vertex(vertex: Any) -> Vertex:
    place = BRep_Tool.Pnt_s(vertex)
    return Vertex((place.X(), place.Y(), place.Z()), float(BRep_Tool.Tolerance_s(vertex)))


def _uses(wire: Any, face: Any) -> list[Any]:
    """The edges of a wire in order, each in its direction."""
    uses = []
    explorer = BRepTools_WireExplorer(wire, face)
    while explorer.More():
        uses.append(explorer.Current())
        explorer.Next()
    return uses


def _pcurve(edge: Any, face: Any) -> Any:
    """``Geom2d_BSplineCurve`` of an edge in the parameter plane, along the wire."""
    first, last = BRep_Tool.Range_s(edge)
    curve = BRep_Tool.CurveOnSurface_s(edge, face, first, last)
    spline = Geom2dConvert.CurveToBSplineCurve_s(Geom2d_TrimmedCurve(curve, first, last))
    if spline.IsPeriodic():
        spline.SetNotPeriodic()
    if edge.Orientation() == _REVERSED:
        spline.Reverse()
    return spline


def _curve(spline: Any) -> Nurbs:
    if spline.IsPeriodic():
        spline.SetNotPeriodic()
    poles = [spline.Pole(i) for i in range(1, spline.NbPoles() + 1)]
    points = np.array([(pole.X(), pole.Y(), pole.Z()) for pole in poles])
    return Nurbs((spline.Degree(),), (_knots(spline),), points, _weights(spline))


def _curve_2d(spline: Any) -> Nurbs:
    poles = [spline.Pole(i) for i in range(1, spline.NbPoles() + 1)]
    points = np.array([(pole.X(), pole.Y()) for pole in poles])
    return Nurbs((spline.Degree(),), (_knots(spline),), points, _weights(spline))


def _knots(spline: Any) -> Array:
    places = range(1, spline.NbKnots() + 1)
    return np.repeat([spline.Knot(i) for i in places], [spline.Multiplicity(i) for i in places])


def _weights(spline: Any) -> Array | None:
    if not spline.IsRational():
        return None
    return np.array([spline.Weight(i) for i in range(1, spline.NbPoles() + 1)])


def _surface(surface: Any) -> Nurbs:
    if surface.IsUPeriodic():
        surface.SetUNotPeriodic()
    if surface.IsVPeriodic():
        surface.SetVNotPeriodic()
    n_u, n_v = surface.NbUPoles(), surface.NbVPoles()
    places = [(i, j) for i in range(1, n_u + 1) for j in range(1, n_v + 1)]
    poles = [surface.Pole(i, j) for i, j in places]
    points = np.array([(pole.X(), pole.Y(), pole.Z()) for pole in poles]).reshape(n_u, n_v, 3)
    weights = None
    if surface.IsURational() or surface.IsVRational():
        weights = np.array([surface.Weight(i, j) for i, j in places]).reshape(n_u, n_v)
    knots_u = np.repeat(
        [surface.UKnot(i) for i in range(1, surface.NbUKnots() + 1)],
        [surface.UMultiplicity(i) for i in range(1, surface.NbUKnots() + 1)],
    )
    knots_v = np.repeat(
        [surface.VKnot(i) for i in range(1, surface.NbVKnots() + 1)],
        [surface.VMultiplicity(i) for i in range(1, surface.NbVKnots() + 1)],
    )
    return Nurbs((surface.UDegree(), surface.VDegree()), (knots_u, knots_v), points, weights)


def _iso(curve: Nurbs, surface: Nurbs) -> Iso:
    """What openNURBS finds in the box round a trim, and compares."""
    low, high = np.array(surface.domains).T
    first, last = curve.control_points.min(axis=0), curve.control_points.max(axis=0)
    axis = int(np.argmin((last - first) / (high - low)))
    at_low, at_high, inside = ((Iso.WEST, Iso.EAST, Iso.U), (Iso.SOUTH, Iso.NORTH, Iso.V))[axis]
    knots, begin, end = surface.knots[axis], float(first[axis]), float(last[axis])
    for place, name in ((low[axis], at_low), (high[axis], at_high), (0.5 * (begin + end), inside)):
        room = _room(knots, surface.domains[axis], float(place))
        if place - room <= begin and end <= place + room:
            return name
    return Iso.NONE


def _room(knots: Array, domain: tuple[float, float], place: float) -> float:
    """How near parameters count as the same: less in the first and the last span."""
    low, high = domain
    inner = knots[(knots > low) & (knots < high)]
    if len(inner) and place < inner[0]:
        high = inner[0]
    elif len(inner) and place > inner[-1]:
        low = inner[-1]
    return float(_SAME * (high - low))
