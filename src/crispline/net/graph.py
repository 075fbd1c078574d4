"""Connected components of patches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components


def components(adjacency: csr_array, members: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Connected component of each patch within ``members``; others are alone, shape ``(m,)``."""
    inside = np.flatnonzero(members)
    n, piece = connected_components(adjacency[inside][:, inside], directed=False)
    label = n + np.arange(len(members))
    label[inside] = piece
    return label
