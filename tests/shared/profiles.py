"""Noisy points in the half plane of an axis."""

from __future__ import annotations

import numpy as np

SIGMA = 0.3


def sampled(outline, n=1500, seed=0):
    """Points of even density on what an outline turns to, with noise across it."""
    rng = np.random.default_rng(seed)
    spans = np.diff(outline, axis=0)
    length = np.linalg.norm(spans, axis=1)
    which = rng.choice(len(spans), n, p=length / length.sum())
    places = outline[which] + rng.uniform(size=(n, 1)) * spans[which]
    normals = np.column_stack([-spans[:, 1], spans[:, 0]]) / length[:, None]
    return places + SIGMA * rng.normal(size=(n, 1)) * normals[which]
