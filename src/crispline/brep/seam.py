"""Where the closed surfaces of a model are cut open.

A cylinder, cone, sphere or torus meets itself along a seam. A seam outside the
face costs nothing, so one is looked for first. Where the face goes all the way
round, the seam has to cross it: it starts and ends in vertices, and preferably
in those that are there already or may be moved (on a rim without corners).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from crispline.brep.arcs import Arc, is_inside, trace_loops, wrapped
from crispline.brep.chart import TURN, BSplineChart, Chart, PatchChart, PlaneChart
from crispline.brep.revolved import (
    ConeChart,
    CylinderChart,
    ProfileChart,
    RevolutionChart,
    SphereChart,
    TorusChart,
)
from crispline.brep.sphere import sphere_axis
from crispline.brep.split import corner_free_edges
from crispline.model import Face, Model
from crispline.surface import (
    BSplineSurface,
    Cone,
    Cylinder,
    Plane,
    RevolvedSurface,
    Sphere,
    Torus,
    perpendicular_frame,
    unit,
)
from crispline.surface.base import Array

_ON_LINE = 1e-9
"""Angles closer than this are the same, radians."""
_N_DIRECTIONS = 24
"""Arbitrary seam directions that are tried beside those of vertices."""


@dataclass(frozen=True)
class Seams:
    """Result of :func:`choose_seams`.

    Attributes
    ----------
    charts : one per face, with its seam in place.
    cuts : for edge indices, the curve parameters where seams cross them; for a closed
        edge without a corner also its start, if the seam goes through it.
    """

    charts: tuple[Chart, ...]
    cuts: Mapping[int, tuple[float, ...]]


@dataclass(frozen=True)
class _Candidate:
    """A possible seam: its cost, its distance from the borders it does not cross, its cuts."""

    value: float
    cost: float
    clearance: float
    cuts: tuple[tuple[int, float], ...]


def choose_seams(model: Model) -> Seams:
    """Choose a chart for every face, and the edge cuts that their seams need."""
    charts: dict[int, Chart] = {}
    cuts: dict[int, list[float]] = {}
    free = corner_free_edges(model)

    def is_unbound(index: int) -> bool:
        return all(e in free for loop in model.faces[index].loops for e, _ in loop)

    # Faces with corners first: rims without corners then follow their neighbours' seams.
    for index in sorted(range(len(model.faces)), key=lambda i: (is_unbound(i), i)):
        face = model.faces[index]
        chart = _first_chart(model, face)
        if isinstance(chart, RevolutionChart):
            loops = trace_loops(model, face, chart)
            chart, new_cuts = _Search(model, chart, loops, cuts, free).place()
            for edge, parameter in new_cuts:
                if _known_cut(model, cuts, edge, parameter) is None:
                    cuts.setdefault(edge, []).append(parameter)
        charts[index] = chart
    ordered = tuple(charts[i] for i in range(len(model.faces)))
    return Seams(ordered, {edge: tuple(sorted(places)) for edge, places in cuts.items()})


def _first_chart(model: Model, face: Face) -> Chart:
    """A chart with an arbitrary seam, and its origin beside the face."""
    border = [model.edges[e].curve.samples(33) for loop in face.loops for e, _ in loop]
    middle = np.concatenate(border).mean(axis=0) if border else None
    match surface := face.surface:
        case Plane(origin=origin, normal=normal):
            near = origin if middle is None else surface.project(middle[None, :])[0][0]
            return PlaneChart(near, normal, perpendicular_frame(normal)[0])
        case BSplineSurface():
            return PatchChart(surface) if face.is_patch else BSplineChart(surface)
        case Cylinder(origin=origin, axis=axis, radius=radius):
            near = origin if middle is None else origin + ((middle - origin) @ axis) * axis
            return CylinderChart(near, axis, perpendicular_frame(axis)[0], radius)
        case Cone(apex=apex, axis=axis, half_angle=half_angle):
            height = 1.0 if middle is None else float((middle - apex) @ axis)
            radius = height * np.tan(half_angle)
            origin = apex + height * axis
            return ConeChart(origin, axis, perpendicular_frame(axis)[0], radius, half_angle)
        case Sphere(centre=centre, radius=radius):
            axis = sphere_axis(model, face, surface)
            return SphereChart(centre, axis, perpendicular_frame(axis)[0], radius)
        case Torus(centre=centre, axis=axis, major_radius=major, minor_radius=minor):
            return TorusChart(centre, axis, perpendicular_frame(axis)[0], major, minor)
        case RevolvedSurface(origin=origin, axis=axis, profile=profile):
            return ProfileChart(origin, axis, perpendicular_frame(axis)[0], profile)
    raise TypeError(f"no chart for a {type(surface).__name__}")


@dataclass(frozen=True)
class _Search:
    """Everything that the choice of one face's seams depends on.

    Attributes
    ----------
    model, chart, loops : the face, with an arbitrary seam.
    cuts : the cuts that other faces' seams have made so far.
    free : closed edges without a corner, see :func:`corner_free_edges`.
    """

    model: Model
    chart: RevolutionChart
    loops: Sequence[Sequence[Arc]]
    cuts: Mapping[int, Sequence[float]]
    free: frozenset[int]

    def place(self) -> tuple[RevolutionChart, list[tuple[int, float]]]:
        """The chart with its seams in place, and the cuts that they make."""
        chart = self.chart
        if not self.loops:
            return chart, []
        u = self.best(0)
        y_axis = np.cross(chart.axis, chart.x_axis)
        x_axis = unit(np.cos(u.value) * chart.x_axis + np.sin(u.value) * y_axis)
        new_cuts = list(u.cuts)
        if isinstance(chart, TorusChart):
            v = self.best(1)
            chart = replace(chart, v_start=float(wrapped(np.array(v.value))))
            new_cuts += v.cuts
        return replace(chart, x_axis=x_axis), new_cuts

    def best(self, axis: int) -> _Candidate:
        """The best line ``u = const`` (axis 0) or ``v = const`` (axis 1) for a seam."""
        arcs = [arc for loop in self.loops for arc in loop]
        gaps = _gaps([arc.uv[:, axis] for arc in arcs])
        for middle in gaps:
            if not is_inside(self.loops, self.chart, axis, middle):
                return _Candidate(middle, 0.0, 0.0, ())
        cut_points = [
            self.model.edges[arc.edge].curve.evaluate(np.array([place]))
            for arc in arcs
            for place in self.cuts.get(arc.edge, ())
        ]
        values = [
            *(float(arc.uv[0, axis]) for arc in arcs if arc.edge not in self.free),
            *(float(self.chart.parameters(point)[0, axis]) for point in cut_points),
            *gaps,
            *(TURN * np.arange(_N_DIRECTIONS) / _N_DIRECTIONS),
        ]
        candidates = [self.rate(axis, value) for value in values]
        return min(candidates, key=lambda c: (c.cost, -round(c.clearance, 6)))

    def rate(self, axis: int, value: float) -> _Candidate:
        """Rate a seam: each new vertex costs 1, a moved one little, an old one nothing."""
        impossible = _Candidate(value, np.inf, 0.0, ())
        found: list[tuple[int, float]] = []
        cost, clearance = 0.0, np.pi
        for loop in self.loops:
            offsets = [wrapped(arc.uv[:, axis] - value) for arc in loop]
            places: list[tuple[int, float]] = []
            is_crossed = False
            for i, (arc, offset) in enumerate(zip(loop, offsets, strict=True)):
                is_on = np.abs(offset) < _ON_LINE
                if (is_on[:-1] & is_on[1:]).any():  # the edge runs along the seam
                    return impossible
                for k in _sign_changes(offset, is_on):
                    place = self.crossing(arc, axis, value, k)
                    if place is None:
                        return impossible
                    places.append((arc.edge, place))
                if is_on[0]:
                    if offsets[i - 1][-2] * offset[1] > 0.0:  # the loop touches it and turns
                        return impossible
                    is_crossed = True
                    if arc.edge in self.free:  # hold the vertex where it is
                        places.append((arc.edge, self.model.edges[arc.edge].curve.start))
            for edge, place in places:
                known = _known_cut(self.model, self.cuts, edge, place)
                found.append((edge, place if known is None else known))
                is_movable = edge in self.free and not self.cuts.get(edge)
                cost += 0.0 if known is not None else 0.01 if is_movable else 1.0
            if not places and not is_crossed:
                clearance = min(clearance, min(float(np.abs(offset).min()) for offset in offsets))
        return _Candidate(value, cost, clearance, tuple(found))

    def crossing(self, arc: Arc, axis: int, value: float, interval: int) -> float | None:
        """Curve parameter where an arc meets the line, within one sample interval.

        None if the line passes between the end of the curve and its vertex.
        """
        curve = self.model.edges[arc.edge].curve

        def offset(t: float) -> float:
            uv = self.chart.parameters(curve.evaluate(np.array([t])))
            return float(wrapped(uv[0, axis] - value))

        low, high = float(arc.t[interval]), float(arc.t[interval + 1])
        at_low, at_high = offset(low), offset(high)
        if at_low * at_high > 0.0:  # a sample on the line, or a vertex off its curve
            nearest = low if abs(at_low) < abs(at_high) else high
            return nearest if curve.start < nearest < curve.end else None
        return float(brentq(offset, low, high, xtol=1e-14 * (1.0 + abs(high))))


def _gaps(angles: Sequence[Array]) -> list[float]:
    """Middles of the angles that no border passes over, widest gap first."""
    step = max(float(np.abs(np.diff(run)).max(initial=0.0)) for run in angles)
    taken = np.sort(np.mod(np.concatenate(angles), TURN))
    width = np.diff(np.append(taken, taken[0] + TURN))
    order = np.argsort(-width, kind="stable")
    return [float(taken[i] + 0.5 * width[i]) for i in order if width[i] > max(3.0 * step, 0.02)]


def _sign_changes(offset: Array, is_on: NDArray[np.bool_]) -> list[int]:
    """Sample intervals in whose inside the offset passes through zero."""
    is_positive = offset > 0.0
    is_near = np.abs(offset[:-1]) + np.abs(offset[1:]) < np.pi
    changes = (is_positive[:-1] != is_positive[1:]) & is_near
    changes[0] &= not is_on[0]
    changes[-1] &= not is_on[-1]
    return [int(i) for i in np.flatnonzero(changes)]


def _known_cut(
    model: Model, cuts: Mapping[int, Sequence[float]], edge: int, parameter: float
) -> float | None:
    """The cut that is there already, if any."""
    curve = model.edges[edge].curve
    slack = 1e-7 * (curve.end - curve.start)
    return next((t for t in cuts.get(edge, ()) if abs(t - parameter) < slack), None)
