"""Closed wires of a face in its parameter rectangle.

The loops of a face on a closed surface need not close in the parameter plane.
Here every arc is moved by whole periods into the chart's rectangle; where two
arcs then no longer meet, the loop leaves the rectangle on one side and comes back
on another, and the wire follows the rectangle's border in between: along a seam,
round a pole. Any cylinder band, apex, cap, pierced tube or torus is this one case.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from crispline.brep.arcs import Arc, is_inside, trace_loops
from crispline.brep.chart import SAME, TURN, Chart
from crispline.model import Face, Model
from crispline.surface.base import Array

BOTTOM, RIGHT, TOP, LEFT = range(4)
"""Sides of the rectangle, anticlockwise: v lowest, u highest, v highest, u lowest."""


class WireError(ValueError):
    """The loops of a face do not bound a finite part of its surface."""


class EdgeUse(NamedTuple):
    """An arc of the face's border: edge index, direction, (u, v) along its curve."""

    edge: int
    sign: int
    uv: Array


class SideUse(NamedTuple):
    """A piece of the rectangle's border, run anticlockwise between two parameters.

    On the right and left side the parameters are ``v``, else ``u``. ``first`` and
    ``last`` are model vertices, or -1 for a corner of the rectangle (or a pole)
    that is no model vertex.
    """

    side: int
    start: float
    end: float
    first: int
    last: int


Wire = list[EdgeUse | SideUse]


@dataclass(frozen=True)
class _Stop:
    """A place on the rectangle's border where a loop leaves or enters.

    ``key`` grows anticlockwise within the side.
    """

    side: int
    key: float
    vertex: int
    arc: int


def face_wires(model: Model, face: Face, chart: Chart) -> list[Wire]:
    """Wires of a face, interior on the left in (u, v) with the surface normal up.

    Parameters
    ----------
    model : cut by :func:`crispline.brep.split.split_model` where the seam of
        ``chart`` crosses the loops of ``face``.

    Raises
    ------
    WireError
        If the loops do not bound a finite part of the surface, as when one runs
        the wrong way or is missing.
    """
    arcs: list[Arc] = []
    following: list[int] = []
    for loop in trace_loops(model, face, chart):
        first = len(arcs)
        arcs += [_moved_in(arc, chart) for arc in loop]
        following += [*range(first + 1, len(arcs)), first]

    exits: dict[int, _Stop] = {}
    entries: list[_Stop] = []
    for i, j in enumerate(following):
        end, start = arcs[i].uv[-1], arcs[j].uv[0]
        if _is_break(end, start, chart):
            vertex = _end_vertex(model, arcs[i])
            exits[i] = _stop(end, start, chart, vertex, i)
            entries.append(_stop(start, end, chart, vertex, j))
    entries.sort(key=lambda stop: (stop.side, stop.key))

    wires: list[Wire] = []
    unused = dict.fromkeys(range(len(arcs)))
    while unused:
        i = first = next(iter(unused))
        wire: Wire = []
        while True:
            if i not in unused:
                raise WireError("two loops lead into the same edge")
            del unused[i]
            wire.append(EdgeUse(arcs[i].edge, arcs[i].sign, arcs[i].uv[:: arcs[i].sign]))
            if i in exits:
                entry = _next_entry(exits[i], entries)
                wire += _along_border(exits[i], entry, chart, entries)
                i = entry.arc
            else:
                i = following[i]
            if i == first:
                break
        wires.append(wire)
    if not exits and _has_whole_border(arcs, chart):
        corner = _Stop(BOTTOM, chart.u_range[0], -1, -1)
        wires.insert(0, _along_border(corner, corner, chart, []))
    _require_twins(wires, chart)
    return wires


def _moved_in(arc: Arc, chart: Chart) -> Arc:
    """The arc moved by whole periods into the rectangle, by its innermost sample."""
    uv = arc.uv.copy()
    for axis, (low, _) in enumerate((chart.u_range, chart.v_range)):
        if chart.is_periodic[axis]:
            depth = np.mod(uv[:, axis] - low, TURN)
            inner = int(np.abs(depth - np.pi).argmin())
            uv[:, axis] += low + depth[inner] - uv[inner, axis]
    return Arc(arc.edge, arc.sign, arc.t, uv)


def _is_break(end: Array, start: Array, chart: Chart) -> bool:
    jump = np.abs(start - end)
    if any(chart.is_periodic[axis] and jump[axis] > np.pi for axis in (0, 1)):
        return True
    return chart.is_pole(end) and bool(jump[0] > SAME)


def _stop(here: Array, there: Array, chart: Chart, vertex: int, arc: int) -> _Stop:
    """The place ``here`` on the border, which the loop shares with ``there``."""
    u, v = float(here[0]), float(here[1])
    for k, side in enumerate((BOTTOM, TOP)):
        is_pole = chart.has_pole[k] and abs(v - chart.v_range[k]) < SAME
        is_seam = chart.is_periodic[1] and (there[1] - v) * (1 - 2 * k) > np.pi
        if is_pole or is_seam:
            return _Stop(side, u if side == BOTTOM else -u, vertex, arc)
    side = LEFT if there[0] > u else RIGHT
    return _Stop(side, -v if side == LEFT else v, vertex, arc)


def _next_entry(stop: _Stop, entries: Sequence[_Stop]) -> _Stop:
    """The first entry anticlockwise from an exit."""
    here = (stop.side, stop.key)
    return next((entry for entry in entries if (entry.side, entry.key) > here), entries[0])


def _along_border(start: _Stop, end: _Stop, chart: Chart, stops: Sequence[_Stop]) -> Wire:
    """Anticlockwise border pieces; from a stop to itself is all the way round."""
    (u0, u1), (v0, v1) = chart.u_range, chart.v_range
    corner_keys = {BOTTOM: (u0, u1), RIGHT: (v0, v1), TOP: (-u1, -u0), LEFT: (-v1, -v0)}
    pieces: Wire = []
    side, key, vertex = start.side, start.key, start.vertex
    while True:
        is_last = side == end.side and (end.key > key or (bool(pieces) and end.key >= key))
        stop_key, stop_vertex = (end.key, end.vertex) if is_last else (corner_keys[side][1], -1)
        if not np.isfinite(stop_key):
            raise WireError("the loops bound an infinite part of the surface")
        if stop_key - key > SAME:
            sign = 1.0 if side in (BOTTOM, RIGHT) else -1.0
            pieces.append(SideUse(side, sign * key, sign * stop_key, vertex, stop_vertex))
        if is_last:
            return _with_pole_vertices(pieces, chart, stops)
        side = (side + 1) % 4
        key, vertex = corner_keys[side][0], -1
        if not np.isfinite(key):
            raise WireError("the loops bound an infinite part of the surface")


def _with_pole_vertices(pieces: Wire, chart: Chart, stops: Sequence[_Stop]) -> Wire:
    """The pieces with a pole's model vertex, if it has one, at their ends there."""
    at_pole = {
        chart.v_range[k]: stop.vertex
        for stop in stops
        for k, side in enumerate((BOTTOM, TOP))
        if chart.has_pole[k] and stop.side == side
    }
    named: Wire = []
    for piece in pieces:
        if isinstance(piece, SideUse) and at_pole:
            is_vertical = piece.side in (RIGHT, LEFT)
            v_first = piece.start if is_vertical else chart.v_range[piece.side == TOP]
            v_last = piece.end if is_vertical else v_first
            first = at_pole.get(v_first, -1) if piece.first < 0 else piece.first
            last = at_pole.get(v_last, -1) if piece.last < 0 else piece.last
            piece = piece._replace(first=first, last=last)
        named.append(piece)
    return named


def _has_whole_border(arcs: Sequence[Arc], chart: Chart) -> bool:
    if not any(chart.is_periodic):
        return False
    loops = [[arc] for arc in arcs]
    return is_inside(loops, chart, 0, chart.u_range[0])


def _require_twins(wires: Sequence[Wire], chart: Chart) -> None:
    """Every seam piece on one side must come back on the other."""
    balance: dict[tuple[int, float, float], int] = {}
    for use in (use for wire in wires for use in wire):
        if isinstance(use, SideUse) and is_seam(use, chart):
            low, high = sorted((use.start, use.end))
            key = (use.side % 2, round(low, 6), round(high, 6))
            balance[key] = balance.get(key, 0) + (1 if use.side in (BOTTOM, RIGHT) else -1)
    if any(balance.values()):
        raise WireError("the loops cross the seam of the surface an odd number of times")


def is_seam(use: SideUse, chart: Chart) -> bool:
    """Whether a border piece is part of a seam (else it goes round a pole)."""
    return use.side in (RIGHT, LEFT) or chart.is_periodic[1]


def _end_vertex(model: Model, arc: Arc) -> int:
    edge = model.edges[arc.edge]
    return edge.end if arc.sign > 0 else edge.start
