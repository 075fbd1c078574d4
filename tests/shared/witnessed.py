"""What noisy raw points say of patches that lie exactly on the truth."""

from __future__ import annotations

import numpy as np

from crispline.region.evidence import N_WITNESSES, Evidence
from crispline.region.patches import PatchGraph


def witnessed(points, normals, pairs, sigma, seed=0):
    """The evidence of patches a unit apart, each with its witnesses along the normal."""
    rng = np.random.default_rng(seed)
    shape = (len(points), N_WITNESSES, 1)
    witnesses = points[:, None] + sigma * rng.normal(size=shape) * normals[:, None]
    noise = np.full(len(points), sigma)
    return Evidence(
        PatchGraph(points, normals, np.sort(pairs, axis=1), 1.0),
        witnesses.reshape(-1, 3),
        normals.repeat(N_WITNESSES, axis=0),
        np.arange(len(points)).repeat(N_WITNESSES),
        witnesses,
        noise.repeat(N_WITNESSES),
        noise,
    )
