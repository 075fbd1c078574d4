"""Borders whose corners have changed places.

Labels are ragged: a border a few patches long may run anywhere in the net, also the other way than
its corners lie. Only if these have changed places in truth, the next borders of a face beside it,
which then begin at the wrong ends, cross each other.
"""

from __future__ import annotations

import numpy as np

from crispline.sharp.network import chains_at, side_labels
from crispline.sharp.sites import Sites
from crispline.surface.base import Array

EXACT = 1e-6
"""Corners with a smaller gap lie on all their surfaces, in spacings."""
_REACH = 4.0
"""Where a border leads to is seen so far from its corner, in spacings; farther by twice the length
of the border between the corners."""


def is_backward(sites: Sites, index: int) -> bool:
    """Whether the corners of a chain have changed places.

    They have not if they lie as their ends in the net do. Else corners that are exact are asked
    for what leads away from them; others count as reversed.
    """
    start, end = sites.ends(index)
    across = sites.across(index)
    if across @ (sites.vertices[end] - sites.vertices[start]) >= 0.0:
        return False
    if any(sites.corners[v].is_fallback or sites.corners[v].gap > EXACT for v in (start, end)):
        return True
    reach = _REACH + 2.0 * float(np.linalg.norm(across))
    chain, border = sites.topology.chains[index], sites.borders[index]
    middle = sites.corners[start].position + 0.5 * across
    for label, surface in zip((chain.left, chain.right), border.surfaces, strict=False):
        legs = [_leg(sites, index, vertex, label, reach) for vertex in (start, end)]
        if legs[0] is None or legs[1] is None:
            return True
        normal = surface.project(middle[None])[1][0]
        if _cross(legs[0], legs[1], normal):
            return True
    return False


def _leg(sites: Sites, index: int, vertex: int, label: int, reach: float) -> Array | None:
    """From a corner to where the next border of a face leads, shape ``(2, 3)``; None if unclear."""
    chains = sites.topology.chains
    beside = [
        i
        for i in chains_at(sites.topology, vertex)
        if i != index and label in side_labels(chains[i])
    ]
    if len(beside) != 1 or chains[beside[0]].is_closed:
        return None
    path = chains[beside[0]].vertices
    path = path if int(path[0]) == vertex else path[::-1]
    away = np.linalg.norm(sites.vertices[path] - sites.vertices[vertex], axis=1)
    far = np.flatnonzero(away > reach)
    target = sites.vertices[path[far[0]]] if len(far) else sites.corners[int(path[-1])].position
    return np.stack([sites.corners[vertex].position, target])


def _cross(first: Array, second: Array, normal: Array) -> bool:
    """Whether two segments cross, seen along a direction."""

    def side(line: Array, points: Array) -> Array:
        return np.asarray(np.cross(line[1] - line[0], points - line[0]) @ normal)

    a, b = side(first, second), side(second, first)
    return bool(a[0] * a[1] < 0.0 and b[0] * b[1] < 0.0)
