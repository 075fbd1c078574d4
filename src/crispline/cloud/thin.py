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
_MIN_GAP = 0.4  # spacings without a point between the sheets ...
_MIN_CONTRAST = 2.5  # ... and times the scatter within them
_MAX_SHIFT = 0.8  # of the middles of the sheets along them: a step has its sheets side by side
_MIN_SHARE = 0.01


@dataclass(frozen=True)
class ThinWalls:
    """Where two sheets lie close to each other.

    Attributes
    ----------
    share : of the points that see another sheet near them.
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
            f"{100.0 * self.share:.0f} % of the points see a second sheet only "
            f"{self.distance * cloud.spacing:.3g} away, {self.distance:.1f} spacings, for example "
            f"near {place}: walls and slots under {MIN_WALL:g} spacings run together; "
            "scan more densely"
        )


def thin_walls(cloud: WorkingCloud, limit: float = MIN_WALL) -> ThinWalls:
    """Look for points whose neighbourhood falls into two parallel sheets under ``limit`` apart.

    The heights of the 24 nearest points along their smallest principal component are
    split at the widest step between them.
    """
    n = len(cloud.points)
    sample = np.unique(np.linspace(0, n - 1, _MAX_SAMPLES).astype(np.int64))
    local = cloud.points[cloud.neighbours[sample]]
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    turned = np.einsum("nki,nij->nkj", local, axes)
    order = np.argsort(turned[:, :, 0], axis=1)
    turned = np.take_along_axis(turned, order[:, :, None], axis=1)
    height = turned[:, :, 0]
    steps = np.diff(height, axis=1)[:, _MIN_SIDE - 1 : -(_MIN_SIDE - 1)]
    lower = np.argmax(steps, axis=1) + _MIN_SIDE
    gap = np.max(steps, axis=1)
    below = np.arange(height.shape[1])[None] < lower[:, None]
    middles = [_mean(turned, side) for side in (below, ~below)]
    scatter = np.sqrt(
        sum(_mean((height - m[:, :1])[:, :, None] ** 2, s)[:, 0] * s.mean(axis=1)
            for m, s in zip(middles, (below, ~below), strict=True))
    )  # fmt: skip
    apart = middles[1] - middles[0]
    shift = np.hypot(apart[:, 1], apart[:, 2])
    is_thin = (gap > _MIN_GAP) & (apart[:, 0] > _MIN_CONTRAST * 2.0 * scatter)
    is_thin &= (shift < _MAX_SHIFT) & (apart[:, 0] < limit)
    if not is_thin.any():
        return ThinWalls(0.0, np.inf, np.zeros(3))
    thin = cloud.points[sample[is_thin]]
    nearest = np.argmin(np.linalg.norm(thin - np.median(thin, axis=0), axis=1))
    return ThinWalls(float(is_thin.mean()), float(np.median(apart[is_thin, 0])), thin[nearest])


def _mean(values: Array, members: NDArray[np.bool_]) -> Array:
    """Mean over the members of each row, shape ``(n, c)`` for values ``(n, k, c)``."""
    total = np.einsum("nkc,nk->nc", values, members.astype(np.float64))
    return np.asarray(total / np.maximum(members.sum(axis=1), 1)[:, None])
