"""Step five of the paper on any topology: put the located features into the net.

On a grid a located point goes into the net three times; on a net of quads its
counterpart is a vertex on the located crease whose sides along the crease are
tagged sharp, and a corner is a vertex that the surface interpolates.
"""

from __future__ import annotations

import numpy as np

from crispline.model import Model
from crispline.net.quads import QuadNet
from crispline.region.topology import Topology
from crispline.spline.creased import CreasedNet, Index
from crispline.surface.base import Array

N_SAMPLES = 201
_EVENNESS = 0.5
"""Share of the equal spacing in the place of a vertex; keeps neighbours from falling together."""


def preserve(net: QuadNet, topology: Topology, model: Model, max_move: float) -> CreasedNet:
    """Net whose bicubic surface is sharp along the located edges.

    Parameters
    ----------
    net : the plain net.
    topology : chains of the net, in the order of the model's edges.
    model : the located edges; only sharp ones are preserved.
    max_move : an edge farther from a vertex of its chain stays smooth, as the quads beside
        it would fold over; in the unit of the net.

    Returns
    -------
    The creased net. Vertices of a sharp chain lie on its edge, near where they were and in
    their order; vertices where three or more sharp edges end are corners.
    """
    vertices = net.vertices.copy()
    sides = [np.zeros((0, 2), dtype=np.int64)]
    for chain, edge in zip(topology.chains, model.edges, strict=True):
        if not edge.is_sharp:
            continue
        chosen, curve = net.vertices[chain.vertices], edge.curve.samples(N_SAMPLES)
        if reach(chosen, curve) > max_move:
            continue
        vertices[chain.vertices] = placed_on(chosen, curve)
        sides.append(np.stack([chain.vertices[:-1], chain.vertices[1:]], axis=1))
    creases = sides_of(net.quads, np.concatenate(sides))
    return CreasedNet(vertices, net.quads, creases, corners_of(creases, len(vertices)))


def corners_of(creases: Index, n_vertices: int) -> Index:
    """Vertices where three or more crease sides end, ascending."""
    return np.flatnonzero(np.bincount(creases.ravel(), minlength=n_vertices) > 2)


def reach(chain: Array, curve: Array) -> float:
    """Largest distance of an inner vertex of a chain from a polyline.

    The ends do not count: at a corner the net is rounded off in all directions.
    """
    inner = chain[1:-1] if len(chain) > 2 else chain
    return float(np.linalg.norm(inner[:, None] - curve[None], axis=2).min(axis=1).max())


def placed_on(chain: Array, curve: Array) -> Array:
    """Where the vertices of a chain go on a polyline from its start to its end.

    Each goes to the place nearest to it, evened out with equal shares of the length, so
    that vertices whose nearest places coincide or run backwards keep their order.
    """
    along = _arc_shares(curve)
    even = _arc_shares(chain)
    nearest = np.linalg.norm(chain[:, None] - curve[None], axis=2).argmin(axis=1)
    share = along[nearest]
    if np.array_equal(chain[0], chain[-1]):  # no end: the nearest place of the first is round 0
        share = share - np.round(share - even)
        share[-1] = share[0] + 1.0
        even = even + share[0]
    else:
        share[0], share[-1] = 0.0, 1.0
    share = (1.0 - _EVENNESS) * np.maximum.accumulate(
        np.minimum(share, share[-1])
    ) + _EVENNESS * even
    share = np.where((share < 0.0) | (share > 1.0), share - np.floor(share), share)
    return np.stack([np.interp(share, along, curve[:, axis]) for axis in range(3)], axis=1)


def sides_of(quads: Index, pairs: Index) -> Index:
    """Those pairs of vertices that are sides; a chain beside a contracted one ends with none."""
    both = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    key = [int(quads.max(initial=0)) + 1, 1]
    return pairs[np.isin(np.sort(pairs, axis=1) @ key, np.sort(both, axis=1) @ key)]


def _arc_shares(polyline: Array) -> Array:
    """Arc length from the start over the whole length, shape ``(k,)``."""
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(polyline, axis=0), axis=1)))
    return np.asarray(arc / arc[-1] if arc[-1] > 0.0 else np.linspace(0.0, 1.0, len(arc)))
