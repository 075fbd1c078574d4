"""Bicubic surface with creases over a quad net: Catmull-Clark with sharp rules.

Hoppe et al. 1994, DeRose, Kass and Truong 1998. A crease vertex that is tagged
as a corner is interpolated: on a regular net that is the control point put in
three times.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array


@dataclass(frozen=True)
class CreasedNet:
    """A control net with sharp edges and corners.

    Attributes
    ----------
    vertices : shape ``(n, 3)``.
    quads : vertex indices, counter-clockwise from outside, shape ``(m, 4)``.
    creases : pairs of vertices, each a side of the net, shape ``(e, 2)``.
    corners : vertices that the surface interpolates, shape ``(c,)``.
    """

    vertices: Array
    quads: NDArray[np.int64]
    creases: NDArray[np.int64]
    corners: NDArray[np.int64]


def subdivided(net: CreasedNet) -> CreasedNet:
    """One subdivision step; the limit surface stays the same.

    New vertices are numbered: old vertices, then edge points, then face points.
    Sides used by one quad only (an open border) count as creases.
    """
    n, m = len(net.vertices), len(net.quads)
    tail, head = net.quads.ravel(), np.roll(net.quads, -1, axis=1).ravel()
    key = np.minimum(tail, head) * n + np.maximum(tail, head)
    names, edge, uses = np.unique(key, return_inverse=True, return_counts=True)
    ends = np.stack([names // n, names % n], axis=1)
    crease_key = net.creases.min(axis=1) * n + net.creases.max(axis=1)
    is_crease = np.isin(names, crease_key) | (uses != 2)

    face_point = net.vertices[net.quads].mean(axis=1)
    per_side = np.repeat(face_point, 4, axis=0)
    middle = net.vertices[ends].mean(axis=1)
    smooth = (2.0 * middle + _sums(edge, per_side, len(ends))) / 4.0
    edge_point = np.where(is_crease[:, None], middle, smooth)

    degree = np.maximum(np.bincount(ends.ravel(), minlength=n), 1)[:, None]
    n_faces = np.maximum(np.bincount(tail, minlength=n), 1)[:, None]
    middles = _sums(ends.T.ravel(), np.concatenate([middle, middle]), n) / degree
    faces = _sums(tail, per_side, n) / n_faces
    vertex_point = (faces + 2.0 * middles + (degree - 3.0) * net.vertices) / degree

    sharp_ends = ends[is_crease]
    n_sharp = np.bincount(sharp_ends.ravel(), minlength=n)
    across = _sums(sharp_ends.T.ravel(), net.vertices[sharp_ends[:, ::-1].T.ravel()], n)
    on_crease = n_sharp == 2
    vertex_point[on_crease] = (0.75 * net.vertices + 0.125 * across)[on_crease]
    fixed = n_sharp > 2
    fixed[net.corners] = True
    vertex_point[fixed] = net.vertices[fixed]

    side = (n + edge).reshape(m, 4)
    centre = n + len(ends) + np.arange(m)
    quads = np.stack(
        [net.quads, side, np.broadcast_to(centre[:, None], (m, 4)), np.roll(side, 1, axis=1)],
        axis=2,
    ).reshape(4 * m, 4)
    marked = np.flatnonzero(is_crease & (uses == 2))
    creases = np.concatenate(
        [np.stack([ends[marked, i], n + marked], axis=1) for i in (0, 1)]
    ).astype(np.int64)
    vertices = np.concatenate([vertex_point, edge_point, face_point])
    return CreasedNet(vertices, quads, creases, net.corners)


def _sums(index: NDArray[np.int64], values: Array, n: int) -> Array:
    return np.stack([np.bincount(index, values[:, i], minlength=n) for i in range(3)], axis=1)
