"""Spacing and noise of a cloud."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.surface.base import Array

N_NEIGHBOURS = 24
"""Neighbours per point, itself included, that every local estimate draws from."""

_N_SAMPLES = 5000

# Lower quartile of the standard normal distribution.
_QUARTILE = -0.6744897501960817

# A step between heights wider than these parts two sheets of a wall: in ranges of the heights, in
# radii of the neighbourhood.
_SHEET_GAP = 0.35
_MIN_SHEET_GAP = 0.3
_MIN_SPLIT = 0.1  # share of the neighbourhoods, for thin walls to matter

# Points beyond the six that a quadric needs, for it to tell the noise.
_MIN_FREEDOM = 5


def cloud_scale(points: Array, threads: int = 1) -> tuple[float, float]:
    """Spacing and noise of a cloud as it is, outliers included.

    Parameters
    ----------
    points : shape ``(n, 3)``, any unit.
    threads : threads for neighbour queries; the result does not depend on it.

    Returns
    -------
    spacing : see :func:`point_spacing`.
    noise : see :func:`local_noise`. Both are NaN for fewer
        than 24 distinct points.
    """
    distinct = np.unique(points, axis=0)
    if len(distinct) < N_NEIGHBOURS:
        return float("nan"), float("nan")
    sample = np.unique(np.linspace(0, len(distinct) - 1, _N_SAMPLES).astype(np.int64))
    distances, neighbours = cKDTree(distinct).query(
        distinct[sample], k=N_NEIGHBOURS, workers=threads
    )
    noise = local_noise(distinct, np.asarray(neighbours, dtype=np.int64))
    return point_spacing(np.asarray(distances)), noise


def point_spacing(distances: Array) -> float:
    """Mean distance between neighbouring points of a surface sampling.

    A disc that holds ``k`` points of a surface with spacing ``s`` has area
    ``k s^2``, so ``s = d_k sqrt(pi / k)``; the median over the points is taken
    for ``k = 8 ... 16`` and averaged, which regular grids need.

    Parameters
    ----------
    distances : sorted neighbour distances, the point itself first, shape ``(n, >= 17)``.
    """
    k = np.arange(8, 17)
    return float(np.mean(np.median(distances[:, 8:17], axis=0) * np.sqrt(np.pi / k)))


def local_noise(points: Array, neighbours: NDArray[np.int64], n_samples: int = 3000) -> float:
    """Noise along the normal: lower quartile of the residuals of quadrics through 24 neighbours.

    The same unit as ``points``. Creased, narrow and littered neighbourhoods are outvoted as
    long as a quarter of the surface is smooth and clean; the median needs half of it, and
    came out up to three times too large on small clouds. In a thin wall nearly every
    neighbourhood holds points of the other side; they are left out.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    neighbours : indices of the neighbours of some points or all, nearest first, shape
        ``(m, k)``, ``k`` over 6.
    n_samples : neighbourhoods that are used.

    References
    ----------
    Quantiles of chi-square: Wilson and Hilferty 1931.
    """
    variances = local_variances(points, neighbours[evenly(len(neighbours), n_samples)])
    return float(np.sqrt(np.quantile(variances[~np.isnan(variances)], 0.25)))


def evenly(n: int, n_samples: int) -> NDArray[np.int64]:
    """Up to ``n_samples`` of the indices 0 to ``n - 1``, evenly apart."""
    return np.unique(np.linspace(0, n - 1, n_samples).astype(np.int64))


def local_variances(points: Array, neighbours: NDArray[np.int64]) -> Array:
    """What quadrics leave of neighbourhoods ``(m, k)``, so scaled that noise has it as quartile.

    Variances of shape ``(m,)``; NaN for a neighbourhood with too few points on its own sheet.
    If all have, nothing tells the noise, and the mean squares of the residuals are returned.
    """
    local = points[neighbours]
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    z, y, x = np.moveaxis(np.einsum("nki,nij->nkj", local, axes), 2, 0)
    own = _own_sheet(z, np.hypot(x, y).max(axis=1))
    design = own[:, :, None] * np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    z = own * z
    q, _ = np.linalg.qr(design)
    residual = z - np.einsum("nkc,nc->nk", q, np.einsum("nkc,nk->nc", q, z))
    n_own = own.sum(axis=1)
    is_told = n_own > 6 + np.minimum(_MIN_FREEDOM, neighbours.shape[1] - 7)
    if not is_told.any():
        return np.asarray((residual**2).mean(axis=1))
    freedom = np.where(is_told, n_own - 6, np.nan)
    # A quantile of a chi-square with f degrees of freedom is about f (1 - g + z sqrt(g))^3 with
    # g = 2/(9 f) and z the same quantile of the normal distribution.
    g = 2.0 / (9.0 * freedom)
    factor = (1.0 - g + _QUARTILE * np.sqrt(g)) ** 3
    return np.asarray((residual**2).sum(axis=1) / (freedom * factor))


def _own_sheet(heights: Array, radius: Array) -> NDArray[np.bool_]:
    """Neighbours on the first one's side of a gap in the heights, shape ``(n, k)``.

    Heights fall into two sheets where the widest step between them is more than a share of
    their range and than a share of the neighbourhood's ``radius`` ``(n,)``.
    """
    order = np.argsort(heights, axis=1)
    ranked = np.take_along_axis(heights, order, axis=1)
    steps = np.diff(ranked, axis=1)
    widest = np.argmax(steps, axis=1)[:, None]
    step = np.take_along_axis(steps, widest, axis=1)[:, 0]
    is_split = step > np.maximum(
        _SHEET_GAP * (ranked[:, -1] - ranked[:, 0]), _MIN_SHEET_GAP * radius
    )
    middle = 0.5 * np.take_along_axis(ranked, widest, axis=1)
    middle += 0.5 * np.take_along_axis(ranked, widest + 1, axis=1)
    is_own = (heights > middle) == (heights[:, :1] > middle)
    if is_split.mean() < _MIN_SPLIT:  # edges and litter, which the quartile outvotes
        return np.ones(heights.shape, dtype=np.bool_)
    return np.asarray(is_own | ~is_split[:, None])
