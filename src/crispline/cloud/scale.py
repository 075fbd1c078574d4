"""Spacing and noise of a cloud from a sample of its points."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from crispline.cloud.working import N_NEIGHBOURS, local_noise, point_spacing
from crispline.surface.base import Array

_N_SAMPLES = 5000


def cloud_scale(points: Array, threads: int = 1) -> tuple[float, float]:
    """Spacing and noise of a cloud as it is, outliers included.

    Parameters
    ----------
    points : shape ``(n, 3)``, any unit.
    threads : threads for neighbour queries; the result does not depend on it.

    Returns
    -------
    spacing : see :func:`crispline.cloud.working.point_spacing`.
    noise : see :func:`crispline.cloud.working.local_noise`. Both are NaN for fewer
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
