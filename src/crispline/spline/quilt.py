"""A creased net as a watertight quilt of few B-spline surfaces.

Quads are gathered into rectangles, one bicubic B-spline each, whose sides no vertex
lies beside that is not regular: such vertices are corners. A rectangle is uniform but
for its corner quads, which are finer where the limit surface is no polynomial. Where one
surface borders several, its side is cut, so that each edge lies between two surfaces
from end to end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.curve import BSplineCurve
from crispline.spline.bezier import CornerPoints, corner_points, gathered_patches, is_exact
from crispline.spline.creased import CreasedNet, Index
from crispline.spline.pieces import (
    Fine,
    fine_patches,
    joined_knots,
    rectangle_surfaces,
    spline_controls,
)
from crispline.spline.rectangles import rectangles
from crispline.spline.sectors import next_corner, require_single_fans
from crispline.surface import BSplineSurface
from crispline.surface.base import Array


@dataclass(frozen=True)
class EdgeSide:
    """What an edge is in the parameter plane of one of its faces: a line with unit speed.

    Attributes
    ----------
    face : index into ``Quilt.faces``.
    start, end : ``(u, v)`` where the edge's curve starts and ends.
    place : how far round the border of the face, anticlockwise, this side begins.
    """

    face: int
    start: tuple[float, float]
    end: tuple[float, float]
    place: float


@dataclass(frozen=True)
class QuiltEdge:
    """A curve between two surfaces, or at an open border.

    Attributes
    ----------
    curve : cubic B-spline, one unit of its parameter for each side of the net.
    start, end : indices into ``Quilt.vertices``.
    left : the face on its left, seen from outside.
    right : the face on its right, or None on an open border.
    is_sharp : whether it is a crease.
    """

    curve: BSplineCurve
    start: int
    end: int
    left: EdgeSide
    right: EdgeSide | None
    is_sharp: bool


@dataclass(frozen=True)
class Quilt:
    """B-spline surfaces that share edges and vertices.

    Attributes
    ----------
    vertices : shape ``(n, 3)``.
    edges : each with one or two faces.
    faces : outward surfaces; parameters count quads of the net.
    n_exact : how many of the faces, the first ones, are exactly the limit surface.
    face_of_quad : the face that each quad of the net is part of, shape ``(m,)``.
    """

    vertices: Array
    edges: tuple[QuiltEdge, ...]
    faces: tuple[BSplineSurface, ...]
    n_exact: int
    face_of_quad: Index

    @property
    def is_closed(self) -> bool:
        """Whether every edge has two faces."""
        return all(edge.right is not None for edge in self.edges)


def quilt(net: CreasedNet, depth: int = 1) -> Quilt:
    """Cover the surface of a net with few B-spline surfaces.

    Parameters
    ----------
    net : open or closed.
    depth : how often quads whose patch is not exact are subdivided first. Tangents are
        continuous inside of a surface.

    Raises
    ------
    InputError
        If the net is no oriented surface, or two sheets of it touch in one vertex.
    """
    points = corner_points(net)
    sectors = points.sectors
    require_single_fans(net, sectors)
    is_smooth = ~sectors.sides.is_sharp[sectors.sides.of_half_edge]
    is_regular = sectors.is_regular[sectors.of_corner]
    goes_on = is_regular & is_regular[next_corner(np.arange(len(is_regular)))]
    blocks = rectangles(sectors.twin, is_smooth & goes_on)
    exact = is_exact(sectors)
    is_plain = [bool(exact[block // 4].all()) for block in blocks]
    blocks = [blocks[i] for i in np.argsort(np.logical_not(is_plain), kind="stable")]

    fine = fine_patches(net, np.flatnonzero(~exact), depth)
    patches = gathered_patches(points, net.quads)
    faces = tuple(rectangle_surfaces(patches, fine, blocks))
    layout = _layout(blocks, len(is_smooth))
    return _sewn(net, points, fine, layout, faces, sum(is_plain))


@dataclass(frozen=True)
class _Layout:
    """Where the half-edges of the net lie, one row for each.

    Attributes
    ----------
    face : the surface, shape ``(4 m,)``.
    start, end : ends in the parameter plane of the surface, shape ``(4 m, 2)``.
    place : how far round the border of the surface it starts, if it is there.
    turns : whether the border turns at its end.
    ahead : the half-edge straight on in the same surface, -1 where it turns.
    """

    face: Index
    start: Index
    end: Index
    place: Index
    turns: NDArray[np.bool_]
    ahead: Index


def _layout(blocks: list[Index], n_half_edges: int) -> _Layout:
    corner = np.concatenate([block.ravel() for block in blocks])
    shapes = np.array([block.shape for block in blocks])
    n_quads = shapes.prod(axis=1)
    owner = np.repeat(np.arange(len(blocks)), n_quads)
    a, b = shapes[owner].T
    within = np.arange(len(corner)) - np.repeat(np.cumsum(n_quads) - n_quads, n_quads)
    i, j = within // b, within % b

    face = np.empty(n_half_edges, dtype=np.int64)
    start, end = np.empty((n_half_edges, 2), np.int64), np.empty((n_half_edges, 2), np.int64)
    place, ahead = np.empty_like(face), np.full_like(face, -1)
    turns = np.empty(n_half_edges, dtype=bool)
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    places = (i, a + j, 2 * a + b - 1 - i, 2 * (a + b) - 1 - j)
    is_last = (i == a - 1, j == b - 1, i == 0, j == 0)
    cell = np.stack([i, j], axis=1)
    side = corner
    for k, step in enumerate((b, 1, -b, -1)):
        face[side] = owner
        start[side], end[side] = cell + square[k], cell + square[(k + 1) % 4]
        place[side], turns[side] = places[k], is_last[k]
        inner = np.flatnonzero(~is_last[k])
        ahead[side[inner]] = side[inner + np.broadcast_to(step, len(corner))[inner]]
        side = next_corner(side)
    return _Layout(face, start, end, place, turns, ahead)


def _sewn(
    net: CreasedNet,
    points: CornerPoints,
    fine: Fine,
    layout: _Layout,
    faces: tuple[BSplineSurface, ...],
    n_exact: int,
) -> Quilt:
    """Edges along the borders of the faces, from one vertex to the next."""
    twin, sides = points.sectors.twin, points.sectors.sides
    tail, head = net.quads.ravel(), np.roll(net.quads, -1, axis=1).ravel()
    is_sharp = sides.is_sharp[sides.of_half_edge]
    across = np.where(twin >= 0, layout.face[twin], -1)
    border = np.flatnonzero(across != layout.face)
    # A vertex is wherever a border turns or its other side changes. Where a crease ends the
    # quads are not regular, so the other side changes there too.
    beyond = layout.ahead[border]
    is_end = layout.turns[border] | (across[border] != across[beyond])
    is_vertex = np.zeros(len(net.vertices), dtype=bool)
    is_vertex[head[border[is_end]]] = True
    number = np.cumsum(is_vertex) - 1

    # The lower face, which is the simpler one, gives the curve.
    first = border[(twin[border] < 0) | (layout.face[border] < across[border])]
    chain_starts = first[is_vertex[tail[first]]]
    ends_chain = is_vertex[head]
    chains = []
    for begin in chain_starts.tolist():
        chain = [begin]
        while not ends_chain[chain[-1]]:
            chain.append(int(layout.ahead[chain[-1]]))
        chains.append(chain)
    edges = [
        QuiltEdge(
            curve,
            int(number[tail[chain[0]]]),
            int(number[head[chain[-1]]]),
            _side(layout, chain[0], chain[-1]),
            None if twin[chain[0]] < 0 else _side(layout, twin[chain[0]], twin[chain[-1]], False),
            bool(is_sharp[chain[0]]),
        )
        for chain, curve in zip(chains, _curves(points, tail, fine, chains), strict=True)
    ]
    return Quilt(points.position[is_vertex], tuple(edges), faces, n_exact, layout.face[::4])


def _side(layout: _Layout, first: int, last: int, is_forward: bool = True) -> EdgeSide:
    """An edge in a face whose half-edges run along its curve, or against it."""
    start, end = (layout.start, layout.end) if is_forward else (layout.end, layout.start)
    begin = first if is_forward else last
    (u0, v0), (u1, v1) = start[first].tolist(), end[last].tolist()
    return EdgeSide(int(layout.face[first]), (u0, v0), (u1, v1), int(layout.place[begin]))


def _curves(
    points: CornerPoints, tail: Index, fine: Fine, chains: list[list[int]]
) -> list[BSplineCurve]:
    """The curves along chains of half-edges, fine where their quads are."""
    half_edge = np.concatenate([np.array(chain) for chain in chains])
    bezier = np.empty((len(half_edge), 4, 3))
    bezier[:, 0] = points.position[tail[half_edge]]
    bezier[:, 1] = points.outgoing[half_edge]
    bezier[:, 2] = points.incoming[next_corner(half_edge)]
    bezier[:, 3] = points.position[tail[next_corner(half_edge)]]
    is_fine = fine.number[half_edge // 4] >= 0
    ends = np.cumsum([len(chain) for chain in chains])
    alike: dict[bytes, list[int]] = {}
    for index, part in enumerate(np.split(is_fine, ends[:-1])):
        alike.setdefault(part.tobytes(), []).append(index)
    curves: list[BSplineCurve] = [None] * len(chains)  # type: ignore[list-item]
    for pattern, group in alike.items():
        finer = np.frombuffer(pattern, dtype=bool)
        last = ends[group]
        pieces = []
        for step, is_finer in enumerate(finer.tolist()):
            row = last - len(finer) + step
            piece = fine.sides(half_edge[row]) if is_finer else bezier[row]
            pieces.append(piece[:, 1:] if step else piece)
        knots = joined_knots(finer, fine.depth)
        controls = spline_controls(np.concatenate(pieces, axis=1).swapaxes(0, 1), knots)
        for index, mine in zip(group, controls.swapaxes(0, 1), strict=True):
            curves[index] = BSplineCurve(knots, np.ascontiguousarray(mine))
    return curves
