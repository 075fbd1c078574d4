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
from crispline.spline.creased import CreasedNet
from crispline.surface.base import Array

_SAMPLES = 201


def preserve(net: QuadNet, topology: Topology, model: Model) -> CreasedNet:
    """Net whose bicubic surface is sharp along the located edges.

    Parameters
    ----------
    net : the plain net.
    topology : chains of the net, in the order of the model's edges.
    model : the located edges; only sharp ones are preserved.

    Returns
    -------
    The creased net. Vertices of a sharp chain lie on its edge, at equal shares
    of its length as before, so the quads beside it keep their order; vertices
    where three or more sharp edges end are corners.
    """
    vertices = net.vertices.copy()
    sides = [np.zeros((0, 2), dtype=np.int64)]
    for chain, edge in zip(topology.chains, model.edges, strict=True):
        if not edge.is_sharp:
            continue
        curve = edge.curve.samples(_SAMPLES)
        share, along = _arc_shares(net.vertices[chain.vertices]), _arc_shares(curve)
        placed = [np.interp(share, along, curve[:, axis]) for axis in range(3)]
        vertices[chain.vertices] = np.stack(placed, axis=1)
        sides.append(np.stack([chain.vertices[:-1], chain.vertices[1:]], axis=1))
    creases = np.concatenate(sides)
    n_ends = np.bincount(creases.ravel(), minlength=len(vertices))
    return CreasedNet(vertices, net.quads, creases, np.flatnonzero(n_ends > 2))


def _arc_shares(polyline: Array) -> Array:
    """Arc length from the start over the whole length, shape ``(k,)``."""
    arc = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(polyline, axis=0), axis=1)))
    return np.asarray(arc / arc[-1] if arc[-1] > 0.0 else np.linspace(0.0, 1.0, len(arc)))
