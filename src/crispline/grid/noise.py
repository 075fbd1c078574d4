"""Noise of a grid, from the grid alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crispline.grid.lattice import Lattice

_MAX_SAMPLES = 200_000
_GAIN = 6.0
"""Root of the sum of squares of the stencil ``(1, -2, 1) x (1, -2, 1)``."""
_MEDIAN_1D, _MEDIAN_2D = 0.67449, 1.17741
"""Medians of ``|x|`` and of ``hypot(x, y)`` for standard normal ``x``, ``y``."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations a coordinate, spacings.

    Attributes
    ----------
    normal : across the surface; it blurs where features are.
    tangential : along the surface; it blurs which patches they cross.
    """

    normal: float
    tangential: float


def estimate_noise(lattice: Lattice) -> Noise:
    """Noise from mixed fourth differences, which vanish on anything straight along a row or column.

    The stencil ``(1, -2, 1) x (1, -2, 1)`` takes out every surface that is linear
    along rows or along columns, so a crease along either does not disturb it; the
    median ignores other creases. Grids of more than 200,000 points are thinned
    by whole rows. A grid without nine valid points in a square has no noise.
    """
    m, n = lattice.is_valid.shape
    step = max((m * n) // _MAX_SAMPLES, 1)
    rows = np.arange(0, m - 2, step)
    p = lattice.points
    above, at, below = p[rows], p[rows + 1], p[rows + 2]
    across = above - 2.0 * at + below
    mixed = (across[:, :-2] - 2.0 * across[:, 1:-1] + across[:, 2:]) / _GAIN
    normal = np.cross(below[:, 1:-1] - above[:, 1:-1], at[:, 2:] - at[:, :-2])
    length = np.linalg.norm(normal, axis=2, keepdims=True)
    ok = lattice.is_valid[rows] & lattice.is_valid[rows + 1] & lattice.is_valid[rows + 2]
    ok = ok[:, :-2] & ok[:, 1:-1] & ok[:, 2:] & (length[:, :, 0] > 0.0)
    if not ok.any():
        return Noise(0.0, 0.0)
    along = np.einsum("kni,kni->kn", mixed, normal / np.where(length > 0.0, length, 1.0))[ok]
    sideways = np.sqrt(np.maximum(np.einsum("ni,ni->n", mixed[ok], mixed[ok]) - along**2, 0.0))
    return Noise(
        float(np.median(np.abs(along))) / _MEDIAN_1D, float(np.median(sideways)) / _MEDIAN_2D
    )
