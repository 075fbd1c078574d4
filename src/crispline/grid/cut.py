"""Step five on any course of the edges: the control net is cut along them.

Where an edge crosses a link of the net a vertex is put in; the cells it
crosses are divided, and the new sides are creases. Corners lie inside cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csc_array, eye_array
from scipy.sparse.linalg import splu

from crispline.grid.corners import Corners, cell_crossings
from crispline.grid.crossings import Crossings
from crispline.grid.lattice import Mask
from crispline.spline.creased import PolygonNet
from crispline.surface.base import Array

Index = NDArray[np.int64]

_SNAP = 0.3
"""A crossing this near to a point of the net, in links, moves the point instead."""


def cut_net(
    net: Array, has_patch: Mask, crossings: Crossings, corners: Corners, is_creased: bool = True
) -> PolygonNet:
    """The control net with creases along the edges.

    Parameters
    ----------
    net : control points, shape ``(m, n, 3)``; those without a patch are left out.
    has_patch : shape ``(m - 1, n - 1)``.
    crossings, corners : with points in the unit of the net.
    is_creased : whether to tag the new sides as creases.

    Returns
    -------
    Cells that no edge crosses stay quads. The control vertices of every crease are
    solved so that its limit curve passes through the located points.
    """
    n = net.shape[1]
    pinched = _pinched(has_patch)
    node, vertices = _nodes(net, crossings, pinched[0] | pinched[1])
    cells = np.argwhere(has_patch)
    i, j = cells.T
    quad = np.stack([i * n + j, (i + 1) * n + j, (i + 1) * n + j + 1, i * n + j + 1], axis=1)
    # Two cells that touch in a point of the net only get a copy of it each.
    extra = len(vertices) + np.arange(int(pinched.sum()))
    copies = np.full(pinched.shape, -1, dtype=np.int64)
    copies[pinched] = extra
    vertices = np.concatenate([vertices, net[np.nonzero(pinched)[1:]]])
    quad[:, 0] = np.where(copies[0][i, j] >= 0, copies[0][i, j], quad[:, 0])
    quad[:, 3] = np.where(copies[1][i, j + 1] >= 0, copies[1][i, j + 1], quad[:, 3])
    around = cell_crossings(crossings, has_patch.shape)[i, j]
    is_cut = (around >= 0).any(axis=1)
    # The outline of a cell in eight places: corners and, between them, the nodes of crossings.
    outline = np.full((len(cells), 8), -1, dtype=np.int64)
    outline[:, 0::2] = quad
    outline[:, 1::2] = np.where(around >= 0, np.append(node, -1)[around], -1)
    is_node, outline = _marked(outline)
    centre = np.full(has_patch.shape, -1, dtype=np.int64)
    lies_between = corners.crossing >= 0
    tag = np.where(
        lies_between,
        np.append(node, -1)[corners.crossing],
        len(vertices) + np.arange(len(corners.cells)),
    )
    centre[tuple(corners.cells.T)] = tag
    vertices = np.concatenate([vertices, corners.points])
    vertices[tag[lies_between]] = corners.points[lies_between]

    plain = outline[~is_cut][:, 0::2]
    count = is_node.sum(axis=1)
    middle = centre[i, j]
    parts, pairs = [], []
    # A cell with fewer than two nodes stays in one piece; an edge may end at its border.
    whole = np.flatnonzero(is_cut & ((count < 2) | ((count > 2) & (middle < 0))))
    parts.append(outline[whole])
    halves = np.flatnonzero(is_cut & (count == 2) & (middle < 0))
    for start, stop in _spans(is_node[halves], 2):
        parts.append(_between(outline[halves], start, stop))
    start, stop = _spans(is_node[halves], 2)[0]
    rows = np.arange(len(halves))
    pairs.append(np.stack([outline[halves][rows, start], outline[halves][rows, stop]], axis=1))
    for k in (2, 3, 4):
        fans = np.flatnonzero(is_cut & (count == k) & (middle >= 0))
        rows = np.arange(len(fans))
        for start, stop in _spans(is_node[fans], k):
            sector, hub = _between(outline[fans], start, stop), middle[fans]
            first, last = outline[fans][rows, start], outline[fans][rows, stop]
            end = np.where((hub == first) | (hub == last), -1, hub)
            parts.append(np.concatenate([sector, end[:, None]], axis=1))
            pairs.append(np.stack([hub, first], axis=1)[hub != first])
    face_vertices, face_sizes = _packed(plain, parts)
    creases = np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0)
    return _finished(vertices, face_vertices, face_sizes, creases, is_creased, tag)


def _pinched(has_patch: Mask) -> Mask:
    """Points ``(2, m, n)`` that two diagonal cells share and no other.

    First those between the cells above left and below right, then those between
    the cells above right and below left.
    """
    cell = np.pad(has_patch, 1)
    above_left, above_right = cell[:-1, :-1], cell[:-1, 1:]
    below_left, below_right = cell[1:, :-1], cell[1:, 1:]
    falling = above_left & below_right & ~above_right & ~below_left
    rising = above_right & below_left & ~above_left & ~below_right
    return np.stack([falling, rising])


def _nodes(net: Array, crossings: Crossings, is_fixed: Mask) -> tuple[Index, Array]:
    """The vertex that stands for each crossing, and all vertices, the moved ones included."""
    m, n = net.shape[:2]
    vertices = net.reshape(-1, 3).copy()
    first = crossings.start @ np.array([n, 1])
    other = first + np.where(crossings.axis == 0, n, 1)
    is_fixed = is_fixed.ravel()
    near_first = (crossings.share < _SNAP) & ~is_fixed[first]
    near_other = (crossings.share > 1.0 - _SNAP) & ~is_fixed[other]
    node = np.where(near_first, first, other)
    is_moved = near_first | near_other
    n_new = int((~is_moved).sum())
    node[~is_moved] = m * n + np.arange(n_new)
    total = np.zeros((m * n, 3))
    np.add.at(total, node[is_moved], crossings.points[is_moved])
    uses = np.bincount(node[is_moved], minlength=m * n)
    vertices[uses > 0] = total[uses > 0] / uses[uses > 0, None]
    return node, np.concatenate([vertices, crossings.points[~is_moved]])


def _marked(outline: Index) -> tuple[Mask, Index]:
    """Which places of an outline are nodes, with nodes at a corner of the cell moved to it."""
    is_node = np.zeros(outline.shape, dtype=bool)
    result = outline.copy()
    for place in (1, 3, 5, 7):
        here = outline[:, place]
        before, after = place - 1, (place + 1) % 8
        at_before = (here >= 0) & (here == outline[:, before])
        at_after = (here >= 0) & (here == outline[:, after])
        is_node[:, before] |= at_before
        is_node[:, after] |= at_after
        is_node[:, place] = (here >= 0) & ~at_before & ~at_after
        result[at_before | at_after, place] = -1
    return is_node, result


def _spans(is_node: Mask, k: int) -> list[tuple[Index, Index]]:
    """From each of the ``k`` nodes of an outline to the next one round: their places."""
    places = np.nonzero(is_node)[1].reshape(-1, k)
    return [(places[:, a], places[:, (a + 1) % k]) for a in range(k)]


def _between(outline: Index, start: Index, stop: Index) -> Index:
    """The part of each outline from one place on to another, both included, padded with -1."""
    step = np.arange(9)
    length = (stop - start) % 8
    place = (start[:, None] + step) % 8
    part = np.take_along_axis(outline, place, axis=1)
    return np.where(step <= length[:, None], part, -1)


def _packed(plain: Index, parts: list[Index]) -> tuple[Index, Index]:
    """Faces one after the other and their sizes, without paddings and faces that vanished."""
    width = max((part.shape[1] for part in parts), default=4)
    padded = [
        np.pad(part, ((0, 0), (0, width - part.shape[1])), constant_values=-1)
        for part in (plain, *parts)
    ]
    faces = np.concatenate(padded)
    sizes = (faces >= 0).sum(axis=1)
    faces, sizes = faces[sizes >= 3], sizes[sizes >= 3]
    return faces[faces >= 0], sizes


def _finished(
    vertices: Array,
    face_vertices: Index,
    face_sizes: Index,
    creases: Index,
    is_creased: bool,
    corners: Index,
) -> PolygonNet:
    """Drop vertices without faces, tag corners, solve for the creases' control vertices."""
    used, face_vertices = np.unique(face_vertices, return_inverse=True)
    number = np.full(len(vertices), -1, dtype=np.int64)
    number[used] = np.arange(len(used))
    creases = number[creases]
    creases = creases[(creases >= 0).all(axis=1)] if is_creased else creases[:0]
    n_faces = np.bincount(face_vertices, minlength=len(used))
    tips = np.flatnonzero(n_faces == 1)
    n_ends = np.bincount(creases.ravel(), minlength=len(used))
    is_corner = np.zeros(len(vertices), dtype=bool)
    is_corner[corners] = True
    meeting = np.flatnonzero(is_corner[used] & (n_ends > 2))
    controls = crease_controls(vertices[used], face_vertices, face_sizes, creases)
    return PolygonNet(
        controls, face_vertices, face_sizes, creases, np.unique(np.concatenate([tips, meeting]))
    )


def crease_controls(
    points: Array, face_vertices: Index, face_sizes: Index, creases: Index
) -> Array:
    """Control vertices whose crease curves pass through the points given for them.

    A crease vertex between two others has its limit at ``(1, 4, 1)/6`` of the
    three; where creases end, meet or reach the border it is interpolated.
    """
    n = len(points)
    n_ends = np.bincount(creases.ravel(), minlength=n)
    is_inner = (n_ends == 2) & ~_on_border(face_vertices, face_sizes, n)
    if not is_inner.any():
        return points
    tail = np.concatenate([creases[:, 0], creases[:, 1]])
    head = np.concatenate([creases[:, 1], creases[:, 0]])
    rows = is_inner[tail]
    weights = np.full(int(rows.sum()), 1.0 / 6.0)
    across = coo_array((weights, (tail[rows], head[rows])), shape=(n, n))
    diagonal = eye_array(n) - coo_array(
        (np.full(int(is_inner.sum()), 1.0 / 3.0), (np.flatnonzero(is_inner),) * 2), shape=(n, n)
    )
    touched = np.flatnonzero(n_ends > 0)
    system = csc_array(csc_array(across + diagonal)[touched][:, touched])
    controls = points.copy()
    controls[touched] = splu(system).solve(points[touched])
    return controls


def _on_border(face_vertices: Index, face_sizes: Index, n_vertices: int) -> Mask:
    """Vertices at a side that only one face has."""
    last = np.cumsum(face_sizes) - 1
    head = np.roll(face_vertices, -1)
    head[last] = face_vertices[last - face_sizes + 1]
    key = np.minimum(face_vertices, head) * n_vertices + np.maximum(face_vertices, head)
    names, uses = np.unique(key, return_counts=True)
    lone = names[uses == 1]
    border = np.zeros(n_vertices, dtype=bool)
    border[lone // n_vertices] = True
    border[lone % n_vertices] = True
    return border
