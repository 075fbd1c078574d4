"""Nearest points on the same side of a thin wall."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.facing import OPPOSITE
from crispline.cloud.nearest import nearest
from crispline.surface.base import Array

_CHUNK = 50_000


def nearest_alike(
    places: Array,
    directions: Array,
    tree: cKDTree,
    normals: Array,
    k: int,
    threads: int = -1,
) -> NDArray[np.int64]:
    """The nearest of a tree's points whose normals do not look the other way, ``(m, k)``.

    Looks among the 8 ``k`` nearest, and takes others where these do not suffice.

    Parameters
    ----------
    places, directions : where to look, and outward unit normals there, shape ``(m, 3)``.
    tree, normals : points to be found, more than ``k``, and their outward unit normals ``(n, 3)``.
    """
    n_near = min(8 * k, len(normals))
    found = np.empty((len(places), k), dtype=np.int64)
    for begin in range(0, len(places), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        _, index = nearest(tree, places[rows], n_near, threads)
        across = np.einsum("mki,mi->mk", normals[index], directions[rows]) < OPPOSITE
        order = np.argsort(across, axis=1, kind="stable")[:, :k]
        found[rows] = np.take_along_axis(index, order, axis=1)
    return found
