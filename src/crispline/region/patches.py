"""The patches of a net as a graph: what regions are grown, cut and merged on."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from crispline.surface.base import Array

Labels = NDArray[np.int64]


@dataclass(frozen=True)
class PatchGraph:
    """Patch centres and which patches share a side.

    Attributes
    ----------
    points, normals : limit positions and outward unit normals at the centres, shape ``(m, 3)``.
    pairs : patches that share a side, each pair once, shape ``(e, 2)``.
    edge_length : median side of the patches, spacings.
    """

    points: Array
    normals: Array
    pairs: NDArray[np.int64]
    edge_length: float

    def __len__(self) -> int:
        return len(self.points)

    @cached_property
    def adjacency(self) -> csr_array:
        """Symmetric 0/1 matrix of patches that share a side, shape ``(m, m)``."""
        both = np.concatenate([self.pairs, self.pairs[:, ::-1]])
        shape = (len(self), len(self))
        return csr_array((np.ones(len(both)), (both[:, 0], both[:, 1])), shape=shape)

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree over the patch centres."""
        return cKDTree(self.points)

    def rings(self, members: NDArray[np.bool_], n: int) -> NDArray[np.bool_]:
        """``members`` grown by ``n`` rings of patches, shape ``(m,)``."""
        grown = members.copy()
        front = np.flatnonzero(members)
        for _ in range(n):
            beside = self._beside[front].ravel()
            front = np.unique(beside[~grown[beside]])
            grown[front] = True
        return grown

    def sides_of(self, patches: NDArray[np.int64]) -> NDArray[np.int64]:
        """Rows of ``pairs`` with at least one of the patches, ascending, shape ``(k,)``."""
        touched = np.zeros(len(self.pairs) + 1, dtype=bool)
        touched[self._sides[patches]] = True
        return np.flatnonzero(touched[:-1])

    @cached_property
    def _beside(self) -> NDArray[np.int64]:
        """Patches that share a side with each, filled up with itself, shape ``(m, most)``."""
        own = np.arange(len(self))
        ends = np.append(self.pairs, np.zeros((1, 2), dtype=np.int64), axis=0)[self._sides]
        other = np.where(ends[..., 0] == own[:, None], ends[..., 1], ends[..., 0])
        return np.where(self._sides == len(self.pairs), own[:, None], other)

    @cached_property
    def _sides(self) -> NDArray[np.int64]:
        """Rows of ``pairs`` with each patch, filled up with their number, shape ``(m, most)``."""
        n_sides = len(self.pairs)
        order = np.argsort(self.pairs.T.ravel(), kind="stable")
        count = np.bincount(self.pairs.ravel(), minlength=len(self))
        column = np.arange(int(count.max(initial=0)))
        place = (np.cumsum(count) - count)[:, None] + column
        row = np.append(order % max(n_sides, 1), n_sides)
        return np.where(column < count[:, None], row[np.minimum(place, 2 * n_sides)], n_sides)
