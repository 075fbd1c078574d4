"""A creased net as a watertight quilt of few B-spline surfaces.

Exact patches are gathered into rectangles, one uniform bicubic B-spline each;
every other quad is a surface of its own. Where one surface borders several, its
side is cut, so that each edge lies between two surfaces from end to end.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.curve import BSplineCurve
from crispline.spline.bezier import CornerPoints, corner_points, gathered_patches, is_exact
from crispline.spline.creased import CreasedNet, Index
from crispline.spline.pieces import rectangle_surface, refined_surfaces, uniform_controls
from crispline.spline.rectangles import rectangles
from crispline.spline.sectors import next_corner, require_single_fans
from crispline.surface import BSplineSurface
from crispline.surface.base import Array
from crispline.surface.basis import uniform_knots


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
    depth : how often quads whose patch is not exact are subdivided first. Each
        remains one surface, with continuous tangents inside.

    Raises
    ------
    InputError
        If the net is no oriented surface, or two sheets of it touch in one vertex.
    """
    points = corner_points(net)
    sectors = points.sectors
    require_single_fans(net, sectors)
    exact = is_exact(sectors)
    is_smooth = ~sectors.sides.is_sharp[sectors.sides.of_half_edge]
    quad = np.arange(len(is_smooth)) // 4
    blocks = rectangles(sectors.twin, is_smooth & exact[quad] & exact[sectors.twin // 4])
    regular = [block for block in blocks if exact[block[0, 0] // 4]]
    single = np.flatnonzero(~exact)

    patches = gathered_patches(points, net.quads)
    faces = [rectangle_surface(patches, block) for block in regular]
    if len(single):
        faces += refined_surfaces(net, single, depth)
    layout = _layout([*regular, *(4 * single[:, None, None])], len(quad))
    return _sewn(net, points, layout, tuple(faces), len(regular))


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
    edges = []
    for begin in chain_starts.tolist():
        chain = [begin]
        while not ends_chain[chain[-1]]:
            chain.append(int(layout.ahead[chain[-1]]))
        edges.append(
            QuiltEdge(
                _curve(points, tail, layout, chain, faces, n_exact),
                int(number[tail[begin]]),
                int(number[head[chain[-1]]]),
                _side(layout, begin, chain[-1]),
                None if twin[begin] < 0 else _side(layout, twin[begin], twin[chain[-1]], False),
                bool(is_sharp[begin]),
            )
        )
    return Quilt(points.position[is_vertex], tuple(edges), faces, n_exact, layout.face[::4])


def _side(layout: _Layout, first: int, last: int, is_forward: bool = True) -> EdgeSide:
    """An edge in a face whose half-edges run along its curve, or against it."""
    start, end = (layout.start, layout.end) if is_forward else (layout.end, layout.start)
    begin = first if is_forward else last
    (u0, v0), (u1, v1) = start[first].tolist(), end[last].tolist()
    return EdgeSide(int(layout.face[first]), (u0, v0), (u1, v1), int(layout.place[begin]))


def _curve(
    points: CornerPoints,
    tail: Index,
    layout: _Layout,
    chain: list[int],
    faces: tuple[BSplineSurface, ...],
    n_exact: int,
) -> BSplineCurve:
    face = int(layout.face[chain[0]])
    if face >= n_exact:
        surface, side = faces[face], int(layout.place[chain[0]])
        controls = surface.control_points
        rows = (controls[:, 0], controls[-1], controls[::-1, -1], controls[0, ::-1])
        return BSplineCurve(surface.knots_u, rows[side])
    half_edge = np.array(chain)
    n = len(chain)
    bezier = np.empty((3 * n + 1, 3))
    bezier[:-1:3] = points.position[tail[half_edge]]
    bezier[-1] = points.position[tail[next_corner(half_edge[-1:])[0]]]
    bezier[1::3] = points.outgoing[half_edge]
    bezier[2::3] = points.incoming[next_corner(half_edge)]
    return BSplineCurve(uniform_knots(0.0, n, n), uniform_controls(bezier))
