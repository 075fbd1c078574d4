"""Grids of points on shapes whose edges are known."""

from types import SimpleNamespace

import numpy as np
import pytest


def steps(phase, reach=8.75):
    """Unit steps across an edge at 0; the last step before it ends ``phase`` short of it."""
    return np.arange(-np.floor(reach - phase) - phase, reach)


def folded(phase, n_rows=9):
    """A right-angled edge along the rows: ``x`` falls to 0, then ``z`` falls from 0."""
    across, along = steps(phase), np.arange(n_rows) - (n_rows - 1) / 2.0
    s, t = np.meshgrid(across, along)
    return np.stack([np.minimum(s, 0.0), t, -np.maximum(s, 0.0)], axis=2)


def rim(phase, radius=25.0, n_rows=9):
    """The upper rim of a cylinder: wall, then cap; rows along the rim."""
    angle = (np.arange(n_rows) - (n_rows - 1) / 2.0) / radius
    s, t = np.meshgrid(steps(phase), angle)
    rho = radius - np.maximum(s, 0.0)
    return np.stack([rho * np.cos(t), rho * np.sin(t), np.minimum(s, 0.0)], axis=2)


def corner(phase, turn=0.3):
    """A cube's corner at the origin seen along its diagonal; NaN beyond 8.75 from it."""
    view = np.ones(3) / np.sqrt(3.0)
    e1 = np.array([1.0, -1.0, 0.0]) / np.sqrt(2.0)
    e2 = np.cross(view, e1)
    e1, e2 = np.cos(turn) * e1 + np.sin(turn) * e2, np.cos(turn) * e2 - np.sin(turn) * e1
    pixel = (np.arange(-20, 21) + phase) * 3.0**-0.25
    a, b = np.meshgrid(pixel, pixel, indexing="ij")
    ray = a[..., None] * e1 + b[..., None] * e2
    points = ray - (ray / view).max(axis=2, keepdims=True) * view
    return np.where((points > -8.75).all(axis=2, keepdims=True), points, np.nan)


def heights(function, n=24, m=None):
    """The graph of a function of row and column."""
    i, j = np.mgrid[: m or n, :n].astype(float)
    return np.stack([i, j, function(i, j)], axis=2)


def noisy(points, level, seed=0):
    """The paper's noise: a step of ``level * 8.75`` in a random direction for every point."""
    step = np.random.default_rng(seed).normal(size=points.shape)
    return points + level * 8.75 * step / np.linalg.norm(step, axis=2, keepdims=True)


@pytest.fixture(scope="session")
def grids():
    return SimpleNamespace(
        steps=steps, folded=folded, rim=rim, corner=corner, heights=heights, noisy=noisy
    )
