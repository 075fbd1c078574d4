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
            beside = self.adjacency[front].indices
            front = np.unique(beside[~grown[beside]])
            grown[front] = True
        return grown
