"""How points lie about one another: rims, walls, rows of a scanner."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.surface.base import Array

_RIM_GAP = np.radians(135.0)
"""Widest angle without a neighbour that is still inside: points about a rim leave 180 degrees."""
_N_ROUND = 24
_N_ROW = 9
_MIN_ROW = 3
"""Of a point at a rim and its 8 nearest, this many lie there at least."""
_REACH = 3.0
"""Farthest opposite sheet that is looked for, in spacings."""
_N_REACH = 96
"""Neighbours that hold all points that near, on two sheets."""
_N_NORMAL = 10
_N_PLANE = 8
_PLANE_QUARTILE = 2.6746
"""Lower quartile of chi-square with 8 - 3 degrees of freedom."""
_PARALLEL = 0.9
_MIN_FACING = 2
"""One point beyond may be an outlier."""
_ROW_REACH = 3.0
_ROW_SHARE = 0.8
_N_PAIRS = 20_000


def rim_share(sample: Array, points: Array, tree: cKDTree, threads: int = 1) -> float:
    """Share of points at a rim: their neighbours leave a wide angle free, and so do several
    of their neighbours' neighbours, for a rim is a row of points.

    Parameters
    ----------
    sample : points that are asked about, shape ``(m, 3)``.
    points, tree : the whole cloud, shape ``(n, 3)``, and its search tree.

    References
    ----------
    The angle criterion of Bendels, Schnabel and Klein, Detecting holes in point set
    surfaces, 2006.
    """
    count = min(_N_ROUND, len(points))
    near = np.asarray(tree.query(sample, k=count, workers=threads)[1], dtype=np.int64)
    may_be = near[_has_gap(points, near), :_N_ROW]
    if not len(may_be):
        return 0.0
    asked, place = np.unique(may_be, return_inverse=True)
    around = np.asarray(tree.query(points[asked], k=count, workers=threads)[1], dtype=np.int64)
    n_alike = _has_gap(points, around)[place.reshape(may_be.shape)].sum(axis=1)
    return float(np.count_nonzero(n_alike >= _MIN_ROW) / len(sample))


def _has_gap(points: Array, neighbours: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Whether the neighbours of each point, itself first, leave a wide angle free."""
    local = points[neighbours[:, 1:]] - points[neighbours[:, :1]]
    axes = _principal_axes(local)
    x = np.einsum("nki,ni->nk", local, axes[:, :, 2])
    y = np.einsum("nki,ni->nk", local, axes[:, :, 1])
    angles = np.sort(np.arctan2(y, x), axis=1)
    gaps = np.diff(angles, axis=1, append=angles[:, :1] + 2.0 * np.pi)
    return np.asarray(gaps.max(axis=1) > _RIM_GAP)


def wall_gaps(
    sample: Array, points: Array, tree: cKDTree, spacing: float, noise: float, threads: int = 1
) -> Array:
    """Distance of points to another sheet of surface that is near and parallel.

    Parameters
    ----------
    sample : points that are asked about, shape ``(m, 3)``.
    points, tree : the whole cloud, shape ``(n, 3)``, and its search tree.
    spacing : mean distance between neighbouring points.
    noise : standard deviation along the normal.

    Returns
    -------
    Shape ``(m,)``; NaN where no other sheet lies within 3 spacings.
    """
    count = min(_N_REACH, len(points))
    near = np.asarray(tree.query(sample, k=count, workers=threads)[1], dtype=np.int64)
    normal = _normals(points, near)
    offset = points[near] - sample[:, None, :]
    height = np.einsum("nki,ni->nk", offset, normal)
    across = np.linalg.norm(offset - height[:, :, None] * normal[:, None, :], axis=2)
    # Nearer than that a point may belong to the own sheet, by noise or curvature.
    floor = 0.4 * spacing + 4.0 * noise
    far_side = np.abs(height)
    may_face = (across < spacing) & (far_side > floor) & (far_side < _REACH * spacing)
    row, column = np.nonzero(may_face)
    if not len(row):
        return np.full(len(sample), np.nan)
    other, place = np.unique(near[row, column], return_inverse=True)
    around = np.asarray(tree.query(points[other], k=min(_N_NORMAL, count), workers=threads)[1])
    theirs = _normals(points, around.astype(np.int64))[place]
    is_parallel = np.abs(np.einsum("ni,ni->n", theirs, normal[row])) > _PARALLEL
    # Seen from there the distance must be the same: beside a step it is not.
    back = np.abs(np.einsum("ni,ni->n", theirs, offset[row, column]))
    facing = far_side[row, column]
    is_sheet = is_parallel & (np.abs(back - facing) < 0.3 * facing)
    gaps = np.full(len(sample), np.inf)
    np.minimum.at(gaps, row[is_sheet], facing[is_sheet])
    n_facing = np.bincount(row[is_sheet], minlength=len(sample))
    return np.where(n_facing >= _MIN_FACING, gaps, np.nan)


def plane_noise(points: Array, neighbours: NDArray[np.int64]) -> float:
    """Noise along the normal from planes through 8 points: larger than that of quadrics
    through 24 where the surface bends, smaller where two sheets are near.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    neighbours : of some points, each itself first, shape ``(m, >= 8)``.
    """
    local = points[neighbours[:, :_N_PLANE]]
    local = local - local.mean(axis=1, keepdims=True)
    squares = np.linalg.eigvalsh(np.einsum("nki,nkj->nij", local, local))[:, 0]
    return float(np.sqrt(max(np.quantile(squares, 0.25), 0.0) / _PLANE_QUARTILE))


def is_in_scan_order(points: Array, spacing: float) -> bool:
    """Whether the points follow one another in rows, as a scanner takes them."""
    start = np.unique(np.linspace(0, len(points) - 2, _N_PAIRS).astype(np.int64))
    steps = np.linalg.norm(points[start + 1] - points[start], axis=1)
    return bool(np.mean(steps < _ROW_REACH * spacing) > _ROW_SHARE)


def _normals(points: Array, neighbours: NDArray[np.int64]) -> Array:
    """Unoriented normals from the nearest neighbours, shape ``(m, 3)``."""
    local = points[neighbours[:, :_N_NORMAL]]
    return _principal_axes(local - local.mean(axis=1, keepdims=True))[:, :, 0]


def _principal_axes(local: Array) -> Array:
    """Principal axes in columns, that of the smallest spread first, shape ``(m, 3, 3)``."""
    return np.asarray(np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))[1])
