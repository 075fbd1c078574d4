"""Weights that turn the net round a vertex into the corner of a bicubic Bezier patch.

A sector with ``k`` quads has the nodes ``v`` (the vertex), ``e_0 .. e_k`` (the far
ends of its sides, anticlockwise; a ring has no ``e_k``) and ``d_0 .. d_(k-1)``
(the corners opposite to ``v``), in this order.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from crispline.spline.sectors import Kind
from crispline.surface.base import Array


@dataclass(frozen=True)
class Masks:
    """Weights on the nodes of a sector; each row adds up to one.

    Attributes
    ----------
    position : limit position of the vertex, shape ``(n_nodes,)``.
    edge : Bezier points next to the vertex on each side, shape ``(n_sides, n_nodes)``.
    inner : inner Bezier points of each quad, shape ``(k, n_nodes)``.
    """

    position: Array
    edge: Array
    inner: Array


@cache
def sector_masks(kind: Kind, k: int) -> Masks:
    """Masks of a sector with ``k`` quads.

    In regular sectors (see :attr:`Sectors.is_regular`) they are those of the
    uniform cubic B-spline. In others the limit position is exact, the edge points
    lie in the limit tangent plane (a dart's and a smooth vertex's exactly where the
    tangent part of the net puts them), and the inner points are those of Loop and
    Schaefer 2008, moved with the edge points. At a corner with more than one quad
    the Catmull-Clark surface has no tangent plane: the edge points are means.

    References
    ----------
    Loop and Schaefer 2008, Approximating Catmull-Clark subdivision surfaces with
    bicubic patches; Halstead, Kass and DeRose 1993 for limit masks from the left
    eigenvectors of the subdivision matrix.
    """
    inner = _inner(kind, k)
    edge = _edges(kind, k, inner)
    n_nodes = inner.shape[1]
    vertex, first, last = np.eye(n_nodes)[[0, 1, k + (not kind.is_ring)]]
    if kind in (Kind.CORNER, Kind.CONE):
        return Masks(vertex, edge, inner)
    if kind is Kind.CREASE:
        position = (first + 4.0 * vertex + last) / 6.0
        flat = edge if k == 2 else position + _crease_tangents(k, edge)
    elif kind is Kind.SMOOTH and k in (2, 4):
        position, flat = inner.mean(axis=0), edge
    else:
        position, modes = _ring_modes(kind, k)
        flat = position + edge @ modes
    moved = flat - edge
    if kind.is_ring:
        inner = inner + 0.5 * (moved + np.roll(moved, -1, axis=0))
    else:
        inner = inner + 0.5 * (moved[:-1] + moved[1:])
    return Masks(position, flat, inner)


def _inner(kind: Kind, k: int) -> Array:
    """Loop and Schaefer's inner points; the valence is that of the whole disc."""
    valence = {Kind.CREASE: 2 * k, Kind.CORNER: 4, Kind.CONE: 4}.get(kind, k)
    n_sides = k + (not kind.is_ring)
    inner = np.zeros((k, 1 + n_sides + k))
    i = np.arange(k)
    inner[:, 0] = valence
    inner[i, 1 + i] += 2.0
    inner[i, 1 + (i + 1) % n_sides] += 2.0
    inner[i, 1 + n_sides + i] = 1.0
    return inner / (valence + 5.0)


def _edges(kind: Kind, k: int, inner: Array) -> Array:
    """Means of the inner points on both sides; on a sharp side those of a cubic B-spline."""
    if kind.is_ring:
        return 0.5 * (inner + np.roll(inner, 1, axis=0))
    edges = np.zeros((k + 1, inner.shape[1]))
    edges[1:-1] = 0.5 * (inner[1:] + inner[:-1])
    edges[[0, -1], 0] = 2.0 / 3.0
    edges[0, 1] = 1.0 / 3.0
    # A dart has the same side first and last; its two uses get the very same point.
    edges[-1, 1 if kind is Kind.DART else k + 1] = 1.0 / 3.0
    return edges


def _ring_modes(kind: Kind, k: int) -> tuple[Array, Array]:
    """Limit position mask, and the projector of a net on its tangent part.

    The ring mirrored about its first side has a symmetric and an antisymmetric
    half; the leading eigenvector below 1 of each spans the tangent plane.
    """
    matrix = _ring_matrix(k, kind is Kind.DART)
    i = np.arange(k)
    mirror = np.eye(2 * k + 1)[np.concatenate([[0], 1 + -i % k, 1 + k + (-1 - i) % k])]
    symmetric = matrix @ (np.eye(2 * k + 1) + mirror) / 2.0
    antisymmetric = matrix @ (np.eye(2 * k + 1) - mirror) / 2.0
    _, position = _eigenvectors(symmetric, 0)
    pairs = [_eigenvectors(symmetric, 1), _eigenvectors(antisymmetric, 0)]
    right, left = (np.stack([pair[j] for pair in pairs]) for j in (0, 1))
    position = position / position.sum()
    if kind is Kind.DART:
        right = np.insert(right, k + 1, right[:, 1], axis=1)
        left, position = np.insert(left, k + 1, 0.0, axis=1), np.insert(position, k + 1, 0.0)
    return position, right.T @ left


def _eigenvectors(matrix: Array, rank: int) -> tuple[Array, Array]:
    """Right and left eigenvector of the ``rank``-th largest eigenvalue, with product one."""
    found = []
    for operand in (matrix, matrix.T):
        values, vectors = np.linalg.eig(operand)
        found.append(vectors[:, np.argsort(-values.real, kind="stable")[rank]].real)
    right, left = found
    return right, left / (left @ right)


def _ring_matrix(k: int, is_dart: bool) -> Array:
    """Subdivision matrix of a ring, after Catmull and Clark; the first side of a dart is sharp."""
    i = np.arange(k)
    node = np.eye(2 * k + 1)
    vertex, edge, across = node[0], node[1 : k + 1], node[k + 1 :]
    face = (vertex + edge + edge[(i + 1) % k] + across) / 4.0
    middle = (vertex + edge) / 2.0
    smooth = (vertex + edge + face + face[i - 1]) / 4.0
    if is_dart:
        smooth[0] = middle[0]
    centre = (face.mean(axis=0) + 2.0 * middle.mean(axis=0) + (k - 3.0) * vertex) / k
    return np.vstack([centre, smooth, face])


def _crease_tangents(k: int, edge: Array) -> Array:
    """Offsets of the edge points from the vertex in the limit tangent plane beside a crease.

    They turn evenly from one half of the crease to the other. The direction across
    is the leading eigenvector of the nets that vanish on the crease.
    """
    angle = np.pi * np.arange(k + 1) / k
    n_nodes = edge.shape[1]
    along = np.zeros(n_nodes)
    along[1], along[k + 1] = 1.0 / 6.0, -1.0 / 6.0
    offsets = np.cos(angle)[:, None] * along
    if k == 1:
        return offsets
    node = np.eye(n_nodes)
    vertex, end, across = node[0], node[1 : k + 2], node[k + 2 :]
    face = (vertex + end[:-1] + end[1:] + across) / 4.0
    middle = (vertex + end) / 2.0
    middle[1:-1] = (vertex + end[1:-1] + face[1:] + face[:-1]) / 4.0
    matrix = np.vstack([0.75 * vertex + 0.125 * (end[0] + end[-1]), middle, face])
    fixed = np.array([0, 1, k + 1])
    free = np.setdiff1d(np.arange(n_nodes), fixed)
    right, left = _eigenvectors(matrix[np.ix_(free, free)], 0)
    value = float(left @ matrix[np.ix_(free, free)] @ right)
    mask = np.zeros(n_nodes)
    mask[free] = left
    lag = value * np.eye(3) - matrix[np.ix_(fixed, fixed)]
    mask[fixed] = np.linalg.solve(lag.T, left @ matrix[np.ix_(free, fixed)])
    return np.asarray(offsets + np.outer(edge[:, free] @ right, mask))
