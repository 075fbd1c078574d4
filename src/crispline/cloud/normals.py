"""Normals by local principal components, oriented along a minimum spanning tree."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree

from crispline.surface.base import Array, unit


def principal_normals(points: Array, neighbours: NDArray[np.int64], k: int) -> Array:
    """Unoriented unit normals from the ``k`` nearest points, shape ``(n, 3)``."""
    local = points[neighbours[:, :k]]
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    return np.ascontiguousarray(axes[:, :, 0])


def orient_by_spanning_tree(
    points: Array,
    normals: Array,
    neighbours: NDArray[np.int64],
    bending: float,
    offset_weight: float,
) -> Array:
    """Flip normals so that they agree along a minimum spanning tree, outward.

    Two neighbours at distance ``d e`` agree by
    ``n . n' - bending * (n . e)(n' . e) min(1, d^2)``: with ``bending = 2`` that
    is the agreement after reflecting one normal at the plane between them, as
    on a circular arc (Xie et al. 2003); with 0 it is Hoppe et al. 1992. The
    cost of an edge grows with disagreement and with the offset of either point
    from the other's tangent plane, so that the tree avoids jumping to an
    opposite sheet.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals of either sign, shape ``(n, 3)``.
    neighbours : nearest points, itself first, shape ``(n, >= 11)``.

    Returns
    -------
    Oriented normals, shape ``(n, 3)``. Each connected piece is turned so that
    its extreme points look outward.
    """
    n, k = len(points), 10
    tail = np.repeat(np.arange(n), k)
    head = neighbours[:, 1 : k + 1].ravel()
    step = points[head] - points[tail]
    length = np.linalg.norm(step, axis=1)
    direction = unit(step)
    lift_tail = np.einsum("ij,ij->i", direction, normals[tail])
    lift_head = np.einsum("ij,ij->i", direction, normals[head])
    agreement = np.einsum("ij,ij->i", normals[tail], normals[head])
    agreement -= bending * lift_tail * lift_head * np.minimum(1.0, length**2)
    offset = np.maximum(np.abs(lift_tail), np.abs(lift_head))
    cost = 1.0 - np.minimum(np.abs(agreement), 1.0) + offset_weight * offset**2
    # Ties are broken by length; csgraph drops explicit zeros, so cost stays positive.
    cost = cost + 1e-6 * length + 1e-9

    # Each undirected pair once: both directions carry the same cost.
    pair = np.unique(np.minimum(tail, head) * n + np.maximum(tail, head), return_index=True)[1]
    graph = coo_array((cost[pair], (tail[pair], head[pair])), shape=(n, n)).tocsr()
    tree = minimum_spanning_tree(graph)
    n_pieces, piece = connected_components(tree, directed=False)
    oriented = normals.copy()
    for label in range(n_pieces):
        members = np.flatnonzero(piece == label)
        root = members[0]
        order, parent = breadth_first_order(tree, root, directed=False)
        sign = _signs_along_tree(points, normals, order, parent, bending)
        oriented[order] *= sign[:, None]
        if _looks_inward(points[members], oriented[members]):
            oriented[members] *= -1.0
    return oriented


def _signs_along_tree(
    points: Array,
    normals: Array,
    order: NDArray[np.int32],
    parent: NDArray[np.int32],
    bending: float,
) -> Array:
    """Product of the agreements' signs from the root to each node, by pointer doubling."""
    position = np.full(len(points), -1)
    position[order] = np.arange(len(order))
    up = np.zeros(len(order), dtype=np.int64)
    up[1:] = position[parent[order[1:]]]
    child, mother = order, order[up]
    step = points[mother] - points[child]
    direction = unit(step)
    bend = np.einsum("ij,ij->i", direction, normals[child])
    bend = bend * np.einsum("ij,ij->i", direction, normals[mother])
    bend = bend * np.minimum(1.0, np.einsum("ij,ij->i", step, step))
    agreement = np.einsum("ij,ij->i", normals[child], normals[mother]) - bending * bend
    sign = np.where(agreement < 0.0, -1.0, 1.0)
    sign[0] = 1.0
    while up.any():
        sign = sign * sign[up]
        up = up[up]
    return sign


def _looks_inward(points: Array, normals: Array) -> bool:
    """Vote of the five extreme points in each of the six axis directions."""
    vote = 0.0
    for axis in range(3):
        order = np.argsort(points[:, axis], kind="stable")
        for extreme, side in ((order[-5:], 1.0), (order[:5], -1.0)):
            along = side * normals[extreme, axis]
            vote += float((along * np.abs(along)).sum())
    return vote < 0.0
