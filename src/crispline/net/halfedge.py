"""Half-edges of a quad net: who lies beside whom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from crispline.surface.base import Array

Index = NDArray[np.int64]

_MANY_RIMS = 20
_QUADS_PER_RIM = 1000


@dataclass(frozen=True)
class HalfEdges:
    """Connectivity of a quad net; half-edge ``4 f + i`` leaves corner ``i`` of quad ``f``.

    Attributes
    ----------
    origin, target : vertices of each half-edge, shape ``(4 m,)``.
    twin : the opposite half-edge, or -1 on an open border, shape ``(4 m,)``.
    n_vertices : number of vertices of the net.
    """

    origin: Index
    target: Index
    twin: Index
    n_vertices: int

    @property
    def n_quads(self) -> int:
        """Number of quads."""
        return len(self.origin) // 4

    @property
    def quad(self) -> Index:
        """Quad of each half-edge, shape ``(4 m,)``."""
        return np.arange(len(self.origin)) // 4

    @property
    def next(self) -> Index:
        """Next half-edge round the quad, shape ``(4 m,)``."""
        half_edge = np.arange(len(self.origin))
        return half_edge // 4 * 4 + (half_edge + 1) % 4

    @property
    def is_closed(self) -> bool:
        """Whether every half-edge has a twin."""
        return bool((self.twin >= 0).all())

    def opening(self, vertices: Array) -> str:
        """How many sides are open or not manifold and where, empty if none are.

        Parameters
        ----------
        vertices : positions that the sentence may name, in the user's unit, shape ``(n, 3)``.
        """
        loose = vertices[self.origin[self.twin < 0]]
        if len(loose) == 0:
            return ""
        middle = np.median(loose, axis=0)
        place = loose[np.argmin(np.linalg.norm(loose - middle, axis=1))]
        return (
            f"the net over the cloud is open at {len(loose)} sides, most of them near "
            "({:.4g}, {:.4g}, {:.4g}); ".format(*place)
            + "scan the missing stretch, or more densely where walls are thin"
        )

    def rims(self, vertices: Array) -> str:
        """How many free borders there are and how long the longest is, for a warning.

        Parameters
        ----------
        vertices : positions in the unit of the length, shape ``(n, 3)``.
        """
        tail, head, rim = self._rims()
        length = np.bincount(rim, np.linalg.norm(vertices[tail] - vertices[head], axis=1))
        return (
            f"open shell: the scan is not closed; {len(length)} free borders, "
            f"the longest {length.max(initial=0.0):.4g} long"
        )

    def tears(self) -> int:
        """The number of free borders if they are all over the net, as in a sieve; else 0.

        An open scan has ends, and holes where the scanner did not see: a few.
        """
        n_rims = len(np.unique(self._rims()[2]))
        return n_rims if n_rims >= max(_MANY_RIMS, self.n_quads / _QUADS_PER_RIM) else 0

    def _rims(self) -> tuple[Index, Index, Index]:
        """Tail, head and number of the free border, 0, 1, ..., of every loose half edge."""
        loose = self.twin < 0
        tail, head = self.origin[loose], self.target[loose]
        links = coo_array((np.ones(len(tail)), (tail, head)), shape=(self.n_vertices,) * 2)
        _, rim = connected_components(links, directed=False)
        return tail, head, np.unique(rim[tail], return_inverse=True)[1]

    def neighbours(self) -> Index:
        """The quad beyond each side, -1 on an open border, shape ``(m, 4)``."""
        return np.where(self.twin >= 0, self.twin // 4, -1).reshape(-1, 4)

    def adjacency(self) -> csr_array:
        """Symmetric 0/1 matrix of quads that share a side, shape ``(m, m)``."""
        inner = self.twin >= 0
        rows, columns = self.quad[inner], self.twin[inner] // 4
        m = self.n_quads
        matrix = csr_array((np.ones(len(rows)), (rows, columns)), shape=(m, m))
        matrix.data[:] = 1.0
        return matrix

    def pairs(self) -> Index:
        """Quads that share a side, each pair once with the lower quad first, shape ``(e, 2)``."""
        inner = (self.twin >= 0) & (np.arange(len(self.twin)) < self.twin)
        pair = np.stack([self.quad[inner], self.twin[inner] // 4], axis=1)
        return np.sort(pair, axis=1)


def half_edges(quads: Index, n_vertices: int) -> HalfEdges:
    """Connect a quad net.

    Parameters
    ----------
    quads : vertex indices, consistently oriented, shape ``(m, 4)``.

    A side shared by more than two quads, or by two quads of opposite
    orientation, keeps no twin: such a net counts as open there.
    """
    origin = quads.ravel()
    target = np.roll(quads, -1, axis=1).ravel()
    forward = origin * n_vertices + target
    backward = target * n_vertices + origin
    order = np.argsort(forward, kind="stable")
    ordered = forward[order]
    found = np.minimum(np.searchsorted(ordered, backward), len(ordered) - 1)
    twin = np.where(ordered[found] == backward, order[found], -1)
    # A side used twice in one direction is not manifold: neither use has a twin.
    _, inverse, count = np.unique(forward, return_inverse=True, return_counts=True)
    repeated = count[inverse] > 1
    twin[repeated] = -1
    twin[(twin >= 0) & repeated[np.maximum(twin, 0)]] = -1
    return HalfEdges(origin, target, twin, n_vertices)
