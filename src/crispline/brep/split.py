"""Cutting edges of a model at curve parameters, so that seams can start and end there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline

from crispline.curve import BSplineCurve, Circle, Curve, Line
from crispline.model import Edge, Model


def split_model(model: Model, cuts: Mapping[int, Sequence[float]]) -> Model:
    """The same model with vertices at the given places of its edges.

    Parameters
    ----------
    model : any model.
    cuts : for edge indices, curve parameters strictly inside the edge; a closed edge
        that no other meets may also be cut at its start, which keeps it there.

    Returns
    -------
    Model
        Its edges are the uncut ones and the pieces, its loops the same loops. The
        vertex of a closed edge that no other edge uses marks nothing: it moves to
        the first cut instead of staying as a second vertex.
    """
    vertices = list(np.asarray(model.vertices))
    gaps = list(np.asarray(model.vertex_gaps))
    edges: list[Edge] = []
    pieces: list[list[int]] = []
    free = corner_free_edges(model)
    for index, edge in enumerate(model.edges):
        places = sorted(cuts.get(index, ()))
        if places and index in free:
            if places[0] > edge.curve.start:
                vertices[edge.start] = edge.curve.evaluate(np.array(places[:1]))[0]
                gaps[edge.start] = edge.gap
                edge = replace(edge, curve=recut(edge.curve, places[0]))
            places = places[1:]
        ends = [edge.start]
        for place in places:
            ends.append(len(vertices))
            vertices.append(edge.curve.evaluate(np.array([place]))[0])
            gaps.append(edge.gap)
        ends.append(edge.end)
        pieces.append(list(range(len(edges), len(edges) + len(ends) - 1)))
        for curve, start, end in zip(
            split_curve(edge.curve, places), ends[:-1], ends[1:], strict=True
        ):
            edges.append(replace(edge, curve=curve, start=start, end=end))
    faces = tuple(
        replace(
            face,
            loops=tuple(
                tuple((piece, sign) for e, sign in loop for piece in pieces[e][::sign])
                for loop in face.loops
            ),
        )
        for face in model.faces
    )
    return Model(np.array(vertices).reshape(-1, 3), np.array(gaps), tuple(edges), faces)


def settle_rims(model: Model) -> Model:
    """The model with the vertices of corner-free closed edges exactly on their curves."""
    vertices = np.array(model.vertices)
    for index in corner_free_edges(model):
        edge = model.edges[index]
        vertices[edge.start] = edge.curve.evaluate(np.array([edge.curve.start]))[0]
    return replace(model, vertices=vertices)


def corner_free_edges(model: Model) -> frozenset[int]:
    """Closed edges whose vertex belongs to no other edge: it may lie anywhere on them."""
    ends = [vertex for edge in model.edges for vertex in {edge.start, edge.end}]
    n_uses = np.bincount(np.array(ends, dtype=np.intp), minlength=len(model.vertices))
    return frozenset(
        index
        for index, edge in enumerate(model.edges)
        if edge.start == edge.end and n_uses[edge.start] == 1
    )


def split_curve(curve: Curve, parameters: Sequence[float]) -> list[Curve]:
    """Consecutive pieces of a curve, cut at ascending parameters inside its range."""
    pieces: list[Curve] = []
    for parameter in parameters:
        first, curve = _halves(curve, parameter)
        pieces.append(first)
    return [*pieces, curve]


def recut(curve: Curve, parameter: float) -> Curve:
    """A closed curve that starts and ends at another of its points.

    Parameters beyond the new start keep their value, those before it grow by the period.

    Raises
    ------
    ValueError
        For a curve that cannot be closed.
    """
    match curve:
        case Circle():
            return replace(curve, start=parameter, end=parameter + 2.0 * np.pi)
        case BSplineCurve():
            head, tail = _split_bspline(curve, parameter)
            period = curve.end - curve.start
            # Multiplicity 3 where the old ends meet: exact for any closed curve.
            knots = np.concatenate([tail.knots[:-1], head.knots[4:] + period])
            return BSplineCurve(knots, np.vstack([tail.control_points, head.control_points[1:]]))
    raise ValueError(f"a {curve.kind} cannot be closed")


def _halves(curve: Curve, parameter: float) -> tuple[Curve, Curve]:
    match curve:
        case Line() | Circle():
            return replace(curve, end=parameter), replace(curve, start=parameter)
        case BSplineCurve():
            return _split_bspline(curve, parameter)
    raise TypeError(f"cannot split a {type(curve).__name__}")


def _split_bspline(curve: BSplineCurve, parameter: float) -> tuple[BSplineCurve, BSplineCurve]:
    knots = np.asarray(curve.knots, dtype=np.float64)
    nearest = float(knots[np.abs(knots - parameter).argmin()])
    if abs(nearest - parameter) < 1e-9 * (curve.end - curve.start):
        parameter = nearest
    spline = BSpline(knots, curve.control_points, 3)
    n_missing = 3 - int(np.count_nonzero(knots == parameter))
    if n_missing > 0:
        spline = spline.insert_knot(parameter, m=n_missing)
    full, control_points = np.asarray(spline.t), np.asarray(spline.c)
    n_head = int(np.count_nonzero(full < parameter))
    clamp = np.full(4, parameter)
    head = BSplineCurve(np.concatenate([full[:n_head], clamp]), control_points[:n_head])
    tail_knots = np.concatenate([clamp, full[full > parameter]])
    tail = BSplineCurve(tail_knots, control_points[n_head - 1 : n_head - 1 + len(tail_knots) - 4])
    return head, tail
