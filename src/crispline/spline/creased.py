"""Bicubic surface with creases over a net of any topology: Catmull-Clark with sharp rules.

Hoppe et al. 1994, DeRose, Kass and Truong 1998. A crease vertex that is tagged
as a corner is interpolated: on a regular net that is the control point put in
three times. Open borders are creases, so on a regular open grid with its four
corners tagged the limit surface is the uniform bicubic B-spline of the grid with
one phantom row ``p[-1] = 2 p[0] - p[1]`` on each side.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.surface.base import Array

Index = NDArray[np.int64]


@dataclass(frozen=True)
class CreasedNet:
    """A control net of quads with sharp edges and corners.

    Attributes
    ----------
    vertices : shape ``(n, 3)``.
    quads : vertex indices, counter-clockwise from outside, shape ``(m, 4)``.
    creases : pairs of vertices, each a side of the net, shape ``(e, 2)``.
    corners : vertices that the surface interpolates, shape ``(c,)``.
    """

    vertices: Array
    quads: Index
    creases: Index
    corners: Index


@dataclass(frozen=True)
class PolygonNet:
    """A control net of faces with any number of sides; :func:`subdivided` makes it quads.

    Attributes
    ----------
    vertices : shape ``(n, 3)``.
    face_vertices : the vertices of all faces, one face after the other,
        counter-clockwise from outside, shape ``(sum of face_sizes,)``.
    face_sizes : number of sides of each face, at least 3, shape ``(m,)``.
    creases, corners : as in :class:`CreasedNet`.
    """

    vertices: Array
    face_vertices: Index
    face_sizes: Index
    creases: Index
    corners: Index


@dataclass(frozen=True)
class Sides:
    """The sides of a net; half-edge ``h`` leaves the vertex that a face lists at place ``h``.

    Attributes
    ----------
    ends : the two vertices of each side, the lower first, shape ``(e, 2)``.
    of_half_edge : side of each half-edge, shape ``(h,)``.
    n_uses : number of faces at each side, shape ``(e,)``.
    is_sharp : whether a side is a crease or has not exactly two faces, shape ``(e,)``.
    """

    ends: Index
    of_half_edge: Index
    n_uses: Index
    is_sharp: NDArray[np.bool_]


def net_sides(tail: Index, head: Index, creases: Index, n_vertices: int) -> Sides:
    """The sides of a net from the vertices where its half-edges start and end."""
    key = np.minimum(tail, head) * n_vertices + np.maximum(tail, head)
    names, side, n_uses = np.unique(key, return_inverse=True, return_counts=True)
    ends = np.stack([names // n_vertices, names % n_vertices], axis=1)
    is_sharp = n_uses != 2
    place = side_places(ends, creases, n_vertices)
    is_sharp[place[place >= 0]] = True
    return Sides(ends, side, n_uses, is_sharp)


def side_places(ends: Index, pairs: Index, n_vertices: int) -> Index:
    """Where pairs of vertices stand among sides, -1 for one that is none, shape ``(k,)``.

    Parameters
    ----------
    ends : see :class:`Sides`; ascending.
    pairs : in either order, shape ``(k, 2)``.
    """
    names = ends @ [n_vertices, 1]
    wanted = np.sort(pairs, axis=1) @ [n_vertices, 1]
    place = np.searchsorted(names, wanted)
    is_side = place < len(names)
    is_side[is_side] = names[place[is_side]] == wanted[is_side]
    return np.where(is_side, place, -1)


def subdivided(net: CreasedNet | PolygonNet) -> CreasedNet:
    """One subdivision step; the limit surface stays the same.

    New vertices are numbered: old vertices, then edge points, then face points.
    Quad ``h`` of the result starts at the old vertex that half-edge ``h`` leaves
    and goes on along that half-edge. Sides used by one face only (an open border)
    count as creases.

    A vertex with two creases moves along them; with more, or tagged as a corner,
    it stays; with one (a dart, where a crease ends) it moves as a smooth one.

    Raises
    ------
    InputError
        If a polygon has fewer than three sides, or the sizes do not fit the faces.
    """
    if isinstance(net, PolygonNet):
        _require_polygons(net)
        tail, sizes = net.face_vertices, net.face_sizes
    else:
        tail, sizes = net.quads.ravel(), np.full(len(net.quads), 4)
    n, m = len(net.vertices), len(sizes)
    face = np.repeat(np.arange(m), sizes)
    following, preceding = _round_the_face(sizes)
    sides = net_sides(tail, tail[following], net.creases, n)
    ends, edge, is_sharp = sides.ends, sides.of_half_edge, sides.is_sharp

    face_point = _sums(face, net.vertices[tail], m) / sizes[:, None]
    per_side = face_point[face]
    middle = net.vertices[ends].mean(axis=1)
    smooth = (2.0 * middle + _sums(edge, per_side, len(ends))) / 4.0
    edge_point = np.where(is_sharp[:, None], middle, smooth)

    valence = np.maximum(np.bincount(ends.ravel(), minlength=n), 1)[:, None]
    n_faces = np.maximum(np.bincount(tail, minlength=n), 1)[:, None]
    middles = _sums(ends.T.ravel(), np.concatenate([middle, middle]), n) / valence
    faces = _sums(tail, per_side, n) / n_faces
    vertex_point = (faces + 2.0 * middles + (valence - 3.0) * net.vertices) / valence

    sharp_ends = ends[is_sharp]
    n_sharp = np.bincount(sharp_ends.ravel(), minlength=n)
    across = _sums(sharp_ends.T.ravel(), net.vertices[sharp_ends[:, ::-1].T.ravel()], n)
    on_crease = n_sharp == 2
    vertex_point[on_crease] = (0.75 * net.vertices + 0.125 * across)[on_crease]
    is_fixed = n_sharp > 2
    is_fixed[net.corners] = True
    vertex_point[is_fixed] = net.vertices[is_fixed]

    quads = np.stack([tail, n + edge, n + len(ends) + face, n + edge[preceding]], axis=1)
    marked = np.flatnonzero(is_sharp & (sides.n_uses == 2))
    creases = np.concatenate([np.stack([ends[marked, i], n + marked], axis=1) for i in (0, 1)])
    vertices = np.concatenate([vertex_point, edge_point, face_point])
    return CreasedNet(vertices, quads, creases, net.corners)


def _require_polygons(net: PolygonNet) -> None:
    smallest = int(net.face_sizes.min(initial=3))
    if smallest < 3:
        raise InputError(
            f"face {int(np.argmin(net.face_sizes))} has {smallest} sides: expected at least 3; "
            "remove it from the net"
        )
    if net.face_sizes.sum() != len(net.face_vertices):
        raise InputError(
            f"the face sizes add up to {net.face_sizes.sum()}, but {len(net.face_vertices)} "
            "vertices are listed: give each face as many vertices as sides"
        )


def _round_the_face(sizes: Index) -> tuple[Index, Index]:
    """The next and the previous half-edge of every half-edge round its face."""
    last = np.cumsum(sizes) - 1
    first = last - sizes + 1
    following = np.arange(1, sizes.sum() + 1)
    following[last] = first
    preceding = np.arange(-1, sizes.sum() - 1)
    preceding[first] = last
    return following, preceding


def _sums(index: Index, values: Array, n: int) -> Array:
    return np.stack([np.bincount(index, values[:, i], minlength=n) for i in range(3)], axis=1)
