"""Which regions have a border in common, and the sides that it runs along."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.region.patches import Labels, PatchGraph


@dataclass(frozen=True)
class Borders:
    """The borders of a labelling, as it was when they were looked for.

    Attributes
    ----------
    regions : the two of each border, the lower first, in ascending order, shape ``(k, 2)``.
    lengths : number of sides of each, shape ``(k,)``.
    rows : of ``PatchGraph.pairs``: the sides, border by border, shape ``(sum(lengths),)``.
    """

    regions: Labels
    lengths: NDArray[np.int64]
    rows: NDArray[np.int64]

    @classmethod
    def of(cls, label: Labels, graph: PatchGraph) -> Borders:
        """All borders of a labelled net, shape ``(m,)``."""
        a, b = label[graph.pairs].T
        rows = np.flatnonzero(a != b)
        a, b = a[rows], b[rows]
        order = np.lexsort((rows, np.maximum(a, b), np.minimum(a, b)))
        ends = np.sort(np.stack([a, b], axis=1)[order], axis=1)
        regions, lengths = np.unique(ends, axis=0, return_counts=True)
        return cls(regions, lengths, rows[order])

    def sides(self, first: int, second: int) -> NDArray[np.int64]:
        """Rows of ``PatchGraph.pairs`` between two regions, ascending; none if they are apart."""
        pair = sorted((first, second))
        found = np.flatnonzero((self.regions == pair).all(axis=1))
        if len(found) == 0:
            return found
        end = int(self.lengths[: found[0] + 1].sum())
        return self.rows[end - int(self.lengths[found[0]]) : end]
