"""A model as an OCCT shape.

Vertices and edges are shared between faces. Every edge gets its curve in space
and its curve in the parameter plane of each face, both over the same parameter;
tolerances are measured, so that they cover exactly the gaps that the model has.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Edge, TopoDS_Face, TopoDS_Vertex, TopoDS_Wire

from crispline import occt
from crispline.brep.chart import Chart, PlaneChart
from crispline.brep.meet import meet_at_vertices
from crispline.brep.pcurve import PCurve, pcurve
from crispline.brep.seam import choose_seams
from crispline.brep.solids import assemble
from crispline.brep.split import settle_rims, split_model
from crispline.brep.wires import (
    BOTTOM,
    RIGHT,
    TOP,
    EdgeUse,
    SideUse,
    Wire,
    WireError,
    face_wires,
    is_seam,
)
from crispline.errors import ReconstructionError
from crispline.model import Edge, Model
from crispline.surface.base import Array

_MARGIN = 1.05
"""Tolerances exceed the measured gap by this factor, as gaps are measured at samples."""
_REFUSALS: tuple[type[Exception], ...] = (WireError, *occt.FAILURES)
_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
_REVERSED = TopAbs_Orientation.TopAbs_REVERSED


@dataclass(frozen=True)
class Built:
    """A shape and where its faces come from.

    Attributes
    ----------
    shape : ``TopoDS_Shape``: a solid, a shell, or a compound of several.
    face_order : for the faces of ``shape`` in exploration order, the model's face index.
    failures : faces that could not be built, with the reason.
    """

    shape: Any
    face_order: tuple[int, ...]
    failures: tuple[tuple[int, str], ...]


def build_shape(model: Model) -> Built:
    """Build the solid (or the open shell) that a model describes.

    Parameters
    ----------
    model : in a unit where the point spacing is about 1; see :func:`occt.transform`.

    Returns
    -------
    Built
        Not checked: see :func:`crispline.brep.check.check_shape`.
    """
    model = meet_at_vertices(settle_rims(model))
    seams = choose_seams(model)
    cut = split_model(model, seams.cuts)
    workshop = _Workshop(cut)
    faces: dict[int, Any] = {}
    failures: list[tuple[int, str]] = []
    for index, (face, chart) in enumerate(zip(cut.faces, seams.charts, strict=True)):
        try:
            built = workshop.face(chart, face_wires(cut, face, chart))
        except _REFUSALS as error:
            failures.append((index, str(error) or type(error).__name__))
            continue
        faces[index] = built if face.orientation > 0 else built.Reversed()
    workshop.set_tolerances()
    shape, order = assemble(cut, faces)
    return Built(shape, order, tuple(failures))


@dataclass
class _Workshop:
    """Shared vertices and edges of one shape, and the gaps measured while building."""

    model: Model
    builder: Any = field(default_factory=BRep_Builder)
    vertices: list[Any] = field(init=False)
    vertex_gaps: Array = field(init=False)
    edges: list[Any] = field(init=False)
    edge_gaps: Array = field(init=False)

    def __post_init__(self) -> None:
        self.vertices = [self._vertex(position) for position in self.model.vertices]
        self.vertex_gaps = np.array(self.model.vertex_gaps, dtype=np.float64)
        self.edge_gaps = np.zeros(len(self.model.edges))
        self.edges = [self._edge(edge) for edge in self.model.edges]

    def _vertex(self, position: Array) -> Any:
        vertex = TopoDS_Vertex()
        self.builder.MakeVertex(vertex, occt.point(position), occt.CONFUSION)
        return vertex

    def _edge(self, edge: Edge) -> Any:
        curve = edge.curve
        positions = curve.evaluate(np.array([curve.start, curve.end]))
        for vertex, position in zip((edge.start, edge.end), positions, strict=True):
            self._widen(vertex, position)
        interval = (curve.start, curve.end)
        try:
            geometry = occt.curve_to_occt(curve)
        except occt.FAILURES as error:
            raise ReconstructionError(
                f"the {curve.kind} between faces {edge.left} and {edge.right} is no curve: {error}"
            ) from error
        ends = (self.vertices[edge.start], self.vertices[edge.end])
        return self._bounded_edge(geometry, interval, ends)

    def _bounded_edge(
        self, curve: Any, interval: tuple[float, float], ends: tuple[Any, Any]
    ) -> Any:
        edge = TopoDS_Edge()
        if curve is None:
            self.builder.MakeEdge(edge)
        else:
            self.builder.MakeEdge(edge, curve, occt.CONFUSION)
        self.builder.Add(edge, ends[0].Oriented(_FORWARD))
        self.builder.Add(edge, ends[1].Oriented(_REVERSED))
        if curve is not None:
            self.builder.Range(edge, *interval)
        return edge

    def _widen(self, vertex: int, position: Array) -> None:
        """Let a vertex reach a place that an edge starts or ends at."""
        distance = float(np.linalg.norm(self.model.vertices[vertex] - position))
        self.vertex_gaps[vertex] = max(self.vertex_gaps[vertex], distance)

    def face(self, chart: Chart, wires: list[Wire]) -> Any:
        """A face, forward with respect to its surface."""
        face = TopoDS_Face()
        self.builder.MakeFace(face, chart.geometry, occt.CONFUSION)
        corners: dict[tuple[float, ...], Any] = {}
        seams: dict[tuple[float, ...], Any] = {}
        for wire in wires:
            built = TopoDS_Wire()
            self.builder.MakeWire(built)
            for use in wire:
                if isinstance(use, EdgeUse):
                    edge = self._use_edge(face, chart, use)
                elif is_seam(use, chart):
                    edge = self._seam(face, chart, use, corners, seams)
                else:
                    edge = self._pole(face, chart, use, corners)
                self.builder.Add(built, edge)
            built.Closed(True)
            self.builder.Add(face, built)
        return face

    def _use_edge(self, face: Any, chart: Chart, use: EdgeUse) -> Any:
        edge, occt_edge = self.model.edges[use.edge], self.edges[use.edge]
        projected = pcurve(edge.curve, chart, use.uv)
        # OCCT projects on planes by itself, more exactly than a stored curve.
        if not isinstance(chart, PlaneChart):
            self.builder.UpdateEdge(occt_edge, projected.geometry, face, occt.CONFUSION)
        self._record(use.edge, edge, projected)
        return occt_edge.Oriented(_FORWARD if use.sign > 0 else _REVERSED)

    def _record(self, index: int, edge: Edge, projected: PCurve) -> None:
        self.edge_gaps[index] = max(self.edge_gaps[index], projected.deviation)
        self._widen(edge.start, projected.start)
        self._widen(edge.end, projected.end)

    def _corner(self, chart: Chart, uv: Array, vertex: int, corners: dict[Any, Any]) -> Any:
        """The model vertex, or one of the face's own at a pole or a seam crossing."""
        position = chart.points(uv[None, :])[0]
        if vertex >= 0:
            self._widen(vertex, position)
            return self.vertices[vertex]
        key = tuple(np.round(position, 6).tolist())
        if key not in corners:
            corners[key] = self._vertex(position)
        return corners[key]

    def _seam(
        self,
        face: Any,
        chart: Chart,
        use: SideUse,
        corners: dict[Any, Any],
        seams: dict[Any, Any],
    ) -> Any:
        """The seam edge of a border piece; the piece on the other side uses the same."""
        is_u_seam = use.side % 2 == RIGHT
        is_forward = use.side in (BOTTOM, RIGHT)
        low, high = (use.start, use.end) if is_forward else (use.end, use.start)
        key = (float(is_u_seam), round(low, 6), round(high, 6))
        if key not in seams:
            across = chart.u_range if is_u_seam else chart.v_range
            surface = chart.geometry
            curve = occt.untrimmed(
                surface.UIso(across[0]) if is_u_seam else surface.VIso(across[0])
            )
            first, last = (use.first, use.last) if is_forward else (use.last, use.first)
            ends = []
            for along, vertex in ((low, first), (high, last)):
                uv = np.array([across[0], along] if is_u_seam else [along, across[0]])
                ends.append(self._corner(chart, uv, vertex, corners))
            edge = self._bounded_edge(curve, (low, high), (ends[0], ends[1]))
            heading = np.array([0.0, 1.0] if is_u_seam else [1.0, 0.0])
            sides = [
                occt.line_2d(np.array([c, 0.0] if is_u_seam else [0.0, c]), heading) for c in across
            ]
            # The forward use lies on the right side (u) or at the bottom (v).
            forward, backward = (sides[1], sides[0]) if is_u_seam else (sides[0], sides[1])
            self.builder.UpdateEdge(edge, forward, backward, face, occt.CONFUSION)
            self.builder.Range(edge, low, high)
            seams[key] = edge
        return seams[key].Oriented(_FORWARD if is_forward else _REVERSED)

    def _pole(self, face: Any, chart: Chart, use: SideUse, corners: dict[Any, Any]) -> Any:
        """The degenerated edge that goes round a pole."""
        v = chart.v_range[int(use.side == TOP)]
        position = np.array([use.start, v])
        vertex = self._corner(chart, position, use.first, corners)
        edge = self._bounded_edge(None, (0.0, 0.0), (vertex, vertex))
        low, high = sorted((use.start, use.end))
        line = occt.line_2d(np.array([0.0, v]), np.array([1.0, 0.0]))
        self.builder.UpdateEdge(edge, line, face, occt.CONFUSION)
        self.builder.Range(edge, low, high)
        self.builder.Degenerated(edge, True)
        return edge.Oriented(_FORWARD if use.side == BOTTOM else _REVERSED)

    def set_tolerances(self) -> None:
        """Give every edge and vertex the smallest tolerance that covers its gaps."""
        for edge, occt_edge, gap in zip(self.model.edges, self.edges, self.edge_gaps, strict=True):
            gap = max(occt.CONFUSION, _MARGIN * float(gap))
            self.builder.UpdateEdge(occt_edge, gap)
            for vertex in (edge.start, edge.end):
                self.vertex_gaps[vertex] = max(self.vertex_gaps[vertex], gap)
        for vertex, gap in zip(self.vertices, self.vertex_gaps, strict=True):
            self.builder.UpdateVertex(vertex, max(occt.CONFUSION, _MARGIN * float(gap)))
