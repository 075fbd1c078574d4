"""Sheets of a net that touch in single vertices, taken apart."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crispline.spline.creased import CreasedNet
from crispline.spline.sectors import net_sectors, next_corner


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
    tail = net.quads.ravel()
    paired = np.flatnonzero(sectors.twin >= 0)
    # The corner across a half-edge at the vertex that it leaves.
    links = coo_array(
        (np.ones(len(paired)), (paired, next_corner(sectors.twin[paired]))),
        shape=(len(tail), len(tail)),
    )
    _, fan = connected_components(links, directed=False)
    _, lowest = np.unique(fan, return_index=True)
    vertex_of_fan = tail[lowest]
    order = np.lexsort([lowest, vertex_of_fan])
    is_copy = np.zeros(len(order), dtype=bool)
    is_copy[order[1:]] = np.diff(vertex_of_fan[order]) == 0
    if not is_copy.any():
        return net
    number = vertex_of_fan.copy()
    number[is_copy] = len(net.vertices) + np.arange(is_copy.sum())
    quads = number[fan].reshape(-1, 4)

    sides = sectors.sides
    pairs = np.sort(net.creases, axis=1) @ [len(net.vertices), 1]
    is_crease = np.isin(sides.ends @ [len(net.vertices), 1], pairs)[sides.of_half_edge]
    half_edges = np.stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()], axis=1)
    creases = np.unique(np.sort(half_edges[is_crease], axis=1), axis=0)
    tagged = np.isin(vertex_of_fan, net.corners) & is_copy
    return CreasedNet(
        np.concatenate([net.vertices, net.vertices[vertex_of_fan[is_copy]]]),
        quads,
        creases,
        np.concatenate([net.corners, number[tagged]]),
    )
