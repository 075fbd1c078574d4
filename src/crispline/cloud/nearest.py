"""Nearest points, with the types that a search tree does not promise."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.surface.base import Array


def nearest(
    tree: cKDTree, places: Array, k: int, threads: int = -1, within: float = np.inf
) -> tuple[Array, NDArray[np.int64]]:
    """Distances and indices of the ``k`` points nearest to each place, nearest first.

    Parameters
    ----------
    tree : search tree over at least ``k`` points.
    places : shape ``(n, 3)``.
    threads : threads to use; the result does not depend on it.
    within : points farther than this are not looked for, which is slow for places far from all:
        their distance is infinite, and their index the number of points.

    Returns
    -------
    Both of shape ``(n, k)``.
    """
    distance, index = tree.query(
        places, k=np.arange(1, k + 1), distance_upper_bound=within, workers=threads
    )
    return np.asarray(distance, dtype=np.float64), np.asarray(index, dtype=np.int64)
