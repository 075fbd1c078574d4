"""Layers of patches between two faces: as many closed rings as there are faces to be put there.

Where faces are as narrow as the patches, the net does not give each of them a ring of its own,
yet a solid needs one border after the other. Their exact place does not matter, as borders are
located on the surfaces; their order does.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crispline.net.halfedge import HalfEdges
from crispline.region.patches import Labels

Mask = NDArray[np.bool_]

_MAX_ROUNDS = 12


def layered(wanted: Labels, n_layers: int, quads: HalfEdges) -> Labels | None:
    """Layers nearest to those wanted that separate the two sides one after the other.

    Two layers that do not follow each other share no vertex, and none with other patches.

    Parameters
    ----------
    wanted : 0 on one side, ``n_layers + 1`` on the other, 1 to ``n_layers`` between, -1 on
        patches that are none of these, shape ``(m,)``.
    n_layers : one to three.

    Returns
    -------
    The same kind of numbers; None if patches do not suffice.
    """
    touching = _Touching.of(wanted >= 0, quads)
    layer = wanted[touching.patches].copy()
    last = n_layers + 1
    is_open = ~beside_others(wanted >= 0, quads)[touching.patches]
    if (~is_open & (layer > 0) & (layer < last)).any():
        return None
    for _ in range(_MAX_ROUNDS):
        inner = (layer > 0) & (layer < last)
        from_first = touching.steps(layer == 0, inner, last)
        from_last = touching.steps(layer == last, inner, last)
        is_thin = inner & (from_first + from_last <= n_layers)
        meets = touching.beside(layer == 0) & (layer == last)
        meets |= touching.beside(layer == last) & (layer == 0)
        if not (is_thin.any() or meets.any()):
            break
        taken = ~inner & is_open & (meets | touching.beside(is_thin))
        if not taken.any():
            return None
        layer[taken] = np.where(layer[taken] == 0, 1, n_layers)
    else:
        return None
    low, high = np.maximum(1, last - from_last), np.minimum(n_layers, from_first)
    layer[inner] = np.clip(layer, low, high)[inner]
    for _ in range(_MAX_ROUNDS):
        # Only of three layers can two touch that do not follow each other.
        leaps = (layer == 3) & inner & touching.beside((layer == 1) & inner) & (last == 4)
        if not leaps.any():
            break
        layer[leaps & (low <= 2)] = 2
        rest = leaps & (low > 2)
        layer[touching.beside(rest) & (layer == 1) & (high >= 2)] = 2
    sizes = np.bincount(layer[inner], minlength=last)[1:last]
    if sizes.min() == 0:
        return None
    found = np.full(len(wanted), -1)
    found[touching.patches] = layer
    return found


def beside_others(members: Mask, quads: HalfEdges) -> Mask:
    """Which of some patches share a vertex with another patch, shape ``(m,)``."""
    is_theirs = np.zeros(quads.n_vertices, dtype=bool)
    corners = quads.origin.reshape(-1, 4)
    is_theirs[corners[~members]] = True
    return np.asarray(members & is_theirs[corners].any(axis=1))


class _Touching:
    """Patches that share a vertex, among some of a net."""

    def __init__(self, patches: NDArray[np.int64], corners: csr_array) -> None:
        self.patches = patches
        self._corners = corners

    @classmethod
    def of(cls, members: Mask, quads: HalfEdges) -> _Touching:
        patches = np.flatnonzero(members)
        vertices = quads.origin.reshape(-1, 4)[patches]
        shape = (len(patches), quads.n_vertices)
        rows = np.arange(len(patches)).repeat(4)
        return cls(patches, csr_array((np.ones(rows.size), (rows, vertices.ravel())), shape=shape))

    def beside(self, members: Mask) -> Mask:
        """Those that share a vertex with ``members``, and these."""
        return np.asarray(self._corners @ (self._corners.T @ members.astype(float)) > 0.0)

    def steps(self, start: Mask, through: Mask, most: int) -> Labels:
        """Steps from ``start`` through patches, at most ``most``."""
        steps = np.full(len(start), most)
        reached = start
        for count in range(1, most):
            reached = self.beside(reached) & (through | start)
            steps[reached & ~start & (steps == most)] = count
        steps[start] = 0
        return steps
