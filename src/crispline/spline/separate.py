"""Sheets of a net that touch in single vertices, taken apart."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crispline.spline.creased import CreasedNet
from crispline.spline.sectors import net_sectors, next_corner

Index = NDArray[np.int64]


def separated(net: CreasedNet) -> CreasedNet:
    """The net with one vertex for each fan of quads, so that it is a surface everywhere.

    Where two fans touch in a vertex, the one with the lowest quad keeps it and the
    others get copies at the end of ``vertices``, at the same place, and tagged as
    corners if it was. A net that needs no copy comes back as it is.

    Raises
    ------
    InputError
        If a side has more than two quads, or two with opposite sides up.
    """
    sectors = net_sectors(net)
    quads, source = fan_vertices(net.quads, sectors.twin, len(net.vertices))
    n = len(net.vertices)
    if len(source) == n:
        return net
    sides = sectors.sides
    pairs = np.sort(net.creases, axis=1) @ [n, 1]
    is_crease = np.isin(sides.ends @ [n, 1], pairs)[sides.of_half_edge]
    half_edges = np.stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()], axis=1)
    creases = np.unique(np.sort(half_edges[is_crease], axis=1), axis=0)
    tagged = n + np.flatnonzero(np.isin(source[n:], net.corners))
    return CreasedNet(net.vertices[source], quads, creases, np.concatenate([net.corners, tagged]))


def fan_vertices(quads: Index, twin: Index, n_vertices: int) -> tuple[Index, Index]:
    """One vertex for each fan of quads.

    Parameters
    ----------
    quads : vertex indices, shape ``(m, 4)``.
    twin : the half-edge on the other side of each, -1 for none, shape ``(4 m,)``; half-edge
        ``4 q + k`` runs from corner `k` of quad `q`. Where there is none, a fan ends.
    n_vertices : number of vertices.

    Returns
    -------
    quads : with the new vertices, shape ``(m, 4)``.
    source : the old vertex of each new one: all of them, then the copies.
    """
    tail = quads.ravel()
    paired = np.flatnonzero(twin >= 0)
    # The corner across a half-edge at the vertex that it leaves.
    links = coo_array(
        (np.ones(len(paired)), (paired, next_corner(twin[paired]))),
        shape=(len(tail), len(tail)),
    )
    _, fan = connected_components(links, directed=False)
    _, lowest = np.unique(fan, return_index=True)
    vertex_of_fan = tail[lowest]
    order = np.lexsort([lowest, vertex_of_fan])
    is_copy = np.zeros(len(order), dtype=bool)
    is_copy[order[1:]] = np.diff(vertex_of_fan[order]) == 0
    number = vertex_of_fan.copy()
    number[is_copy] = n_vertices + np.arange(is_copy.sum())
    source = np.concatenate([np.arange(n_vertices), vertex_of_fan[is_copy]])
    return number[fan].reshape(-1, 4), source
