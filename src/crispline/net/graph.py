"""Connected components of patches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


def components(adjacency: csr_array, members: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Connected component of each patch within ``members``; others are alone, shape ``(m,)``."""
    links = adjacency.tocoo()
    keep = members[links.row] & members[links.col]
    graph = csr_array(
        (np.ones(int(keep.sum())), (links.row[keep], links.col[keep])), shape=adjacency.shape
    )
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
