"""Walls and slots too thin for the spacing, told before the work begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.cloud.working import WorkingCloud
from crispline.surface.base import Array

MIN_WALL = 2.0
"""Sheets nearer to each other than this run together, in spacings."""

_MAX_SAMPLES = 5000
_MIN_SIDE = 4  # points on either sheet
_MIN_APART = 0.3  # spacings between the middles of the sheets ...
_MIN_CONTRAST = 4.5  # ... and times the scatter within them; one noisy sheet has 2.9, a round 3.5
_MAX_BENT = 0.5  # share of the squared heights that a quadric takes away: one sheet that is bent
_MAX_SHIFT = 0.8  # of the middles of the sheets along them: a step has its sheets side by side
_MIN_SHARE = 0.01  # clouds without thin walls have up to 0.007


@dataclass(frozen=True)
class ThinWalls:
    """Where two sheets lie close to each other.

    Attributes
    ----------
    share : of the points that clearly see another sheet near them; noise hides it from others.
    distance : median distance of the two sheets there, spacings.
    place : one of the points, in the middle of the others, spacings, shape ``(3,)``.
    """

    share: float
    distance: float
    place: Array

    def sentence(self, cloud: WorkingCloud) -> str:
        """What to tell the user, in the user's unit; empty if it is not worth telling."""
        if self.share < _MIN_SHARE:
            return ""
        place = "({:.4g}, {:.4g}, {:.4g})".format(*cloud.to_user.points(self.place))
        return (
            f"at least {100.0 * self.share:.0f} % of the points see a second sheet only "
            f"{self.distance * cloud.spacing:.3g} away, {self.distance:.1f} spacings, for example "
            f"near {place}: walls and slots under {MIN_WALL:g} spacings run together; "
            "scan more densely"
        )


def thin_walls(cloud: WorkingCloud, limit: float = MIN_WALL) -> ThinWalls:
    """Look for points whose neighbourhood falls into two parallel sheets under ``limit`` apart.

    The heights of the 24 nearest points along their smallest principal component are
    split where the two halves scatter least (Otsu 1979, A threshold selection method from
    gray-level histograms).
    """
    n = len(cloud.points)
    sample = np.unique(np.linspace(0, n - 1, _MAX_SAMPLES).astype(np.int64))
    local = cloud.points[cloud.neighbours[sample]]
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    turned = np.einsum("nki,nij->nkj", local, axes)
    is_bent = _bent(turned) > _MAX_BENT
    order = np.argsort(turned[:, :, 0], axis=1)
    turned = np.take_along_axis(turned, order[:, :, None], axis=1)
    height = turned[:, :, 0]
    n_below, within = _split(height)
    below = np.arange(height.shape[1])[None] < n_below[:, None]
    apart = _mean(turned, ~below) - _mean(turned, below)
    shift = np.hypot(apart[:, 1], apart[:, 2])
    is_thin = (apart[:, 0] > np.maximum(_MIN_CONTRAST * within, _MIN_APART)) & ~is_bent
    is_thin &= (shift < _MAX_SHIFT) & (apart[:, 0] < limit)
    if not is_thin.any():
        return ThinWalls(0.0, np.inf, np.zeros(3))
    thin = cloud.points[sample[is_thin]]
    nearest = np.argmin(np.linalg.norm(thin - np.median(thin, axis=0), axis=1))
    return ThinWalls(float(is_thin.mean()), float(np.median(apart[is_thin, 0])), thin[nearest])


def _bent(turned: Array) -> Array:
    """Share of the squared heights ``turned[:, :, 0]`` that a quadric explains, shape ``(n,)``."""
    height, x, y = np.moveaxis(turned, 2, 0)
    basis, _ = np.linalg.qr(np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2))
    explained = np.square(np.einsum("nki,nk->ni", basis, height)).sum(axis=1)
    return np.asarray(explained / np.maximum(np.square(height).sum(axis=1), 1e-30))


def _split(height: Array) -> tuple[NDArray[np.int64], Array]:
    """Cut ascending heights ``(n, k)`` of mean zero in two so that they scatter least.

    Returns
    -------
    n_below : heights below the cut, shape ``(n,)``, at least four, as above it.
    within : their standard deviation about the means of the two halves, shape ``(n,)``.
    """
    k = height.shape[1]
    sizes = np.arange(_MIN_SIDE, k - _MIN_SIDE + 1)
    sums = np.cumsum(height, axis=1)[:, sizes - 1]
    between = sums**2 * (1.0 / sizes + 1.0 / (k - sizes))
    best = np.argmax(between, axis=1)
    rest = np.square(height).sum(axis=1) - np.take_along_axis(between, best[:, None], 1)[:, 0]
    return sizes[best], np.sqrt(np.maximum(rest, 0.0) / (k - 2))


def _mean(values: Array, members: NDArray[np.bool_]) -> Array:
    """Mean over the members of each row, shape ``(n, c)`` for values ``(n, k, c)``."""
    total = np.einsum("nkc,nk->nc", values, members.astype(np.float64))
    return np.asarray(total / np.maximum(members.sum(axis=1), 1)[:, None])
