"""Sectors of a creased net: the corners of the quads round a vertex, between sharp sides."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.spline.creased import CreasedNet, Index, Sides, net_sides, side_places


class Kind(IntEnum):
    """What the surface does at a vertex, within one sector.

    ``SMOOTH`` and ``CONE`` sectors are whole rings, without and with the vertex
    tagged as a corner; a ``DART`` goes from the one sharp side all the way round
    to it; ``CREASE`` and ``CORNER`` lie between two sharp sides.
    """

    SMOOTH = 0
    DART = 1
    CREASE = 2
    CORNER = 3
    CONE = 4

    @property
    def is_ring(self) -> bool:
        """Whether a sector closes on itself without a sharp side."""
        return self in (Kind.SMOOTH, Kind.CONE)


@dataclass(frozen=True)
class Sectors:
    """Sectors of a net with ``m`` quads; corner ``4 f + i`` is corner ``i`` of quad ``f``.

    Corners of a sector run anticlockwise seen from outside. A ring starts at its
    lowest corner.

    Attributes
    ----------
    vertex, kind, size : vertex, kind and number of corners of each sector, shape ``(s,)``.
    corners : the corners of all sectors in order, shape ``(4 m,)``.
    first : place of each sector's first corner in ``corners``, shape ``(s,)``.
    of_corner : sector of each corner, shape ``(4 m,)``.
    sides : the sides of the net.
    twin : opposite half-edge, -1 on an open border, shape ``(4 m,)``.
    """

    vertex: Index
    kind: Index
    size: Index
    corners: Index
    first: Index
    of_corner: Index
    sides: Sides
    twin: Index

    @property
    def is_regular(self) -> NDArray[np.bool_]:
        """Whether the surface is a tensor product of B-splines in the sector, shape ``(s,)``."""
        regular_size = np.array([4, 0, 2, 1, 0])
        return np.asarray(self.size == regular_size[self.kind])


def next_corner(corner: Index) -> Index:
    """The corner that follows in the same quad."""
    return corner - corner % 4 + (corner + 1) % 4


def previous_corner(corner: Index) -> Index:
    """The corner before in the same quad."""
    return corner - corner % 4 + (corner + 3) % 4


def net_sectors(net: CreasedNet) -> Sectors:
    """Order the corners round every vertex.

    Raises
    ------
    InputError
        If the net has other than quads, an index out of range, a vertex that is not
        finite, a side with more than two quads or with opposite sides up, or a crease
        that is no side.
    """
    n, m = len(net.vertices), len(net.quads)
    _require_indices(net)
    tail, head = net.quads.ravel(), np.roll(net.quads, -1, axis=1).ravel()
    sides = net_sides(tail, head, net.creases, n)
    twin = _twins(net, sides, tail)
    _require_sides(net, sides)
    is_open = sides.is_sharp[sides.of_half_edge]
    incoming = previous_corner(np.arange(4 * m))
    after = np.where(is_open[incoming], -1, twin[incoming])
    start, place = _walked(after, np.flatnonzero(is_open))
    ring = np.flatnonzero(start < 0)
    ring_start, ring_place = _walked(after, _lowest_of_cycles(after, ring))
    start[ring], place[ring] = ring_start[ring], ring_place[ring]

    starts, of_corner, size = np.unique(start, return_inverse=True, return_counts=True)
    vertex = tail[starts]
    n_sharp = np.bincount(sides.ends[sides.is_sharp].ravel(), minlength=n)
    is_fixed = n_sharp > 2
    is_fixed[net.corners] = True
    kind = np.array([Kind.SMOOTH, Kind.DART, Kind.CREASE])[np.minimum(n_sharp[vertex], 2)]
    kind[is_fixed[vertex]] = Kind.CORNER
    kind[is_fixed[vertex] & ~is_open[starts]] = Kind.CONE
    corners = np.lexsort([place, of_corner])
    return Sectors(vertex, kind, size, corners, np.cumsum(size) - size, of_corner, sides, twin)


def _walked(after: Index, starts: Index) -> tuple[Index, Index]:
    """For every corner the start that leads to it and the steps from there; -1 for none."""
    start, place = np.full(len(after), -1), np.full(len(after), -1)
    origin, front, step = starts, starts, 0
    while len(front):
        start[front], place[front] = origin, step
        front, step = after[front], step + 1
        is_new = front >= 0
        is_new[is_new] = start[front[is_new]] < 0
        front, origin = front[is_new], origin[is_new]
    return start, place


def _lowest_of_cycles(after: Index, members: Index) -> Index:
    """The lowest member of each cycle of ``after``, by pointer doubling."""
    lowest, jump = np.arange(len(after)), after
    while True:
        lower = np.minimum(lowest[members], lowest[jump[members]])
        if np.array_equal(lower, lowest[members]):
            return np.asarray(members[lower == members])
        lowest[members] = lower
        jump = np.where(jump >= 0, jump[jump], -1)


def _twins(net: CreasedNet, sides: Sides, tail: Index) -> Index:
    """The opposite of every half-edge, or -1."""
    if (sides.n_uses > 2).any():
        a, b = sides.ends[int(np.argmax(sides.n_uses))]
        raise _not_a_surface(net, f"{sides.n_uses.max()} quads meet at one side", (a, b))
    order = np.argsort(sides.of_half_edge, kind="stable")
    first = np.cumsum(sides.n_uses) - sides.n_uses
    paired = first[sides.n_uses == 2]
    one, other = order[paired], order[paired + 1]
    is_turned = tail[one] == tail[other]
    if is_turned.any():
        a, b = sides.ends[sides.n_uses == 2][int(np.argmax(is_turned))]
        raise _not_a_surface(net, "two quads that share a side have opposite sides up", (a, b))
    twin = np.full(len(tail), -1)
    twin[one], twin[other] = other, one
    return twin


def _require_indices(net: CreasedNet) -> None:
    if net.quads.ndim != 2 or net.quads.shape[1] != 4 or not len(net.quads):
        raise InputError(
            f"expected quads of shape (m, 4), got {net.quads.shape}; "
            "faces with other numbers of sides become quads by one subdivision step"
        )
    n = len(net.vertices)
    for name, indices in (("quads", net.quads), ("creases", net.creases)):
        if indices.size and not 0 <= indices.min() <= indices.max() < n:
            raise InputError(
                f"the {name} name vertices {indices.min()} to {indices.max()}, but the net has "
                f"{n} vertices: count them from 0"
            )
    is_folded = (np.diff(np.sort(net.quads, axis=1), axis=1) == 0).any(axis=1)
    if is_folded.any():
        bad = int(np.argmax(is_folded))
        raise InputError(
            f"quad {bad} names a vertex twice ({net.quads[bad].tolist()}): give it four vertices, "
            "or take it as a triangle and subdivide once"
        )
    if not np.isfinite(net.vertices).all():
        bad = int(np.flatnonzero(~np.isfinite(net.vertices).all(axis=1))[0])
        raise InputError(f"vertex {bad} of the net is not finite: remove the quads that use it")


def _require_sides(net: CreasedNet, sides: Sides) -> None:
    is_side = side_places(sides.ends, net.creases, len(net.vertices)) >= 0
    if not is_side.all():
        a, b = net.creases[int(np.argmin(is_side))]
        raise InputError(
            f"the crease between vertices {a} and {b} is no side of a quad: "
            "let creases follow the sides of the net"
        )


def require_single_fans(net: CreasedNet, sectors: Sectors) -> None:
    """Refuse a net with two sheets that touch in a single vertex.

    Raises
    ------
    InputError
        Names the vertex.
    """
    n, sides = len(net.vertices), sectors.sides
    n_sharp = np.bincount(sides.ends[sides.is_sharp].ravel(), minlength=n)
    is_border = np.zeros(n, dtype=bool)
    is_border[sides.ends[sides.n_uses == 1]] = True
    expected = np.maximum(n_sharp - is_border, 1)
    split = np.flatnonzero(np.bincount(sectors.vertex, minlength=n) > expected)
    n_borders = np.bincount(sides.ends[sides.n_uses == 1].ravel(), minlength=n)
    split = np.union1d(split, np.flatnonzero(n_borders > 2))
    if len(split):
        raise _not_a_surface(net, "separate fans of quads touch in one vertex", (int(split[0]),))


def _not_a_surface(net: CreasedNet, what: str, vertices: tuple[int, ...]) -> InputError:
    place = ", ".join(f"{x:.4g}" for x in net.vertices[list(vertices)].mean(axis=0))
    names = " and ".join(str(int(v)) for v in vertices)
    return InputError(
        f"the net is no surface: {what} near ({place}), vertex {names}; "
        "give each sheet its own vertices"
    )
