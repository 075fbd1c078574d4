"""Even quads beside vertices that were moved: slide their neighbours along the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crispline.spline.creased import CreasedNet, Index
from crispline.surface.base import unit

_STEP = 0.5
"""Share of the way to the middle of its neighbours that a vertex slides each round."""


def relaxed(net: CreasedNet, fixed: Index, n_rings: int) -> CreasedNet:
    """Slide the vertices near some fixed ones towards the middle of their neighbours.

    Each slides in the plane across its normal, so the surface keeps its shape up to the
    square of the way. Vertices of creases and open borders stay.

    Parameters
    ----------
    net : oriented quads.
    fixed : vertices that stay, shape ``(k,)``.
    n_rings : how far from a fixed vertex others may slide; also the number of rounds.
    """
    tail = net.quads.ravel()
    head = np.roll(net.quads, -1, axis=1).ravel()
    n = len(net.vertices)
    is_fixed = np.zeros(n, dtype=bool)
    is_fixed[fixed] = True
    reach = is_fixed.copy()
    for _ in range(n_rings):
        reach[head[reach[tail]]] = True
        reach[tail[reach[head]]] = True
    is_fixed[net.creases.ravel()] = True
    is_fixed[net.corners] = True
    is_fixed[_open_ends(tail, head, n)] = True
    moves = np.flatnonzero(reach & ~is_fixed)

    valence = np.maximum(np.bincount(tail, minlength=n), 1)[:, None]
    vertices = net.vertices.copy()
    for _ in range(n_rings):
        corner = vertices[net.quads]
        normal = np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1])
        up, middle = np.zeros((2, n, 3))
        np.add.at(up, tail, np.repeat(normal, 4, axis=0))
        np.add.at(middle, tail, vertices[head])
        up = unit(up[moves])
        way = (middle / valence)[moves] - vertices[moves]
        way -= np.einsum("ij,ij->i", way, up)[:, None] * up
        vertices[moves] += _STEP * way
    return replace(net, vertices=vertices)


def _open_ends(tail: Index, head: Index, n: int) -> Index:
    """Ends of sides that one quad has alone."""
    is_open = ~np.isin(tail * n + head, head * n + tail)
    return np.union1d(tail[is_open], head[is_open])
