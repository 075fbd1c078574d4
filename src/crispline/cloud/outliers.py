"""Points that do not belong to the surface: thin crowds, and clouds in space."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.options import CloudOptions
from crispline.surface.base import Array

_N_NEIGHBOURS = 24
_N_CROWD = 8
_N_SHAPE = 16
_MAX_ROUNDS = 4
_MAX_HEIGHT = 0.7  # over the plane of the neighbours, in units of their crowding
_CHUNK = 100_000


def inliers(points: Array, options: CloudOptions, threads: int = -1) -> NDArray[np.int64]:
    """Indices of the points that are no outliers, ascending.

    The *crowding* of a point is its mean distance to its 8 nearest neighbours. A point
    is an outlier

    - if its crowding is over ``options.outlier_factor`` times the median of its 24
      neighbours' and it stands off the plane through them: it hangs over the surface. Over
      twice that factor it need not stand off, as beyond a rim. A point of the surface where
      the scan suddenly becomes thin lies in the plane and stays; or
    - if its crowding is over that many times the median of the whole cloud and the
      points round it scatter in all directions (smallest share of a principal
      component over ``options.outlier_scatter``, in the median over its neighbours):
      it stands in a thin cloud. A thinly scanned stretch of surface is flat and stays.

    Outliers shield each other, so this is repeated while it finds some.

    Parameters
    ----------
    points : distinct, any unit, shape ``(n, 3)``.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    kept = np.arange(len(points))
    for _ in range(_MAX_ROUNDS):
        if len(kept) <= _N_NEIGHBOURS:
            break
        good = _good(points[kept], options, threads)
        kept = kept[good]
        if good.all():
            break
    return kept


def _good(points: Array, options: CloudOptions, threads: int) -> NDArray[np.bool_]:
    distance, neighbours = nearest(cKDTree(points), points, _N_NEIGHBOURS, threads)
    crowding = distance[:, 1 : _N_CROWD + 1].mean(axis=1)
    beside = np.median(crowding[neighbours], axis=1)
    stands_off = crowding > options.outlier_factor * beside
    doubtful = np.flatnonzero(stands_off & (crowding <= 2.0 * options.outlier_factor * beside))
    height = _heights(points, doubtful, neighbours[doubtful, 1 : _N_SHAPE + 1])
    stands_off[doubtful] = height > _MAX_HEIGHT * beside[doubtful]
    thin = np.flatnonzero(crowding > options.outlier_factor * np.median(crowding))
    scatter = np.zeros(len(points))
    # Only the scatter of thin points and of their neighbours is asked for.
    asked = np.unique(neighbours[thin])
    for begin in range(0, len(asked), _CHUNK):
        chunk = asked[begin : begin + _CHUNK]
        local = points[neighbours[chunk, :_N_SHAPE]]
        local = local - local.mean(axis=1, keepdims=True)
        spread = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", local, local))
        scatter[chunk] = spread[:, 0] / np.maximum(spread.sum(axis=1), np.finfo(float).tiny)
    is_scattered = np.zeros(len(points), dtype=bool)
    is_scattered[thin] = np.median(scatter[neighbours[thin]], axis=1) > options.outlier_scatter
    return np.asarray(~(stands_off | is_scattered))


def _heights(points: Array, chosen: NDArray[np.int64], neighbours: NDArray[np.int64]) -> Array:
    """Distance of chosen points from the planes through their neighbours ``(k, m)``."""
    around = points[neighbours]
    middle = around.mean(axis=1)
    offset = around - middle[:, None]
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", offset, offset))
    return np.asarray(np.abs(np.einsum("ni,ni->n", points[chosen] - middle, axes[:, :, 0])))
