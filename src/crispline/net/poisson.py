"""Indicator function of the solid behind oriented points, by FFT on a grid.

Poisson reconstruction (Kazhdan 2005): the gradient of the smoothed indicator
is the field of inward normals, so the indicator is the solution of a Poisson
equation, which on a periodic grid is a division in the frequency domain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from crispline.surface.base import Array, unit

MAX_CELLS = 30_000_000
"""Largest grid; beyond this the cells are coarsened."""


@dataclass(frozen=True)
class Indicator:
    """Grid samples of the smoothed indicator; larger inside.

    ``values`` has shape ``(n_x, n_y, n_z)``, sample ``(i, j, k)`` lies at
    ``origin + cell * (i, j, k)``.
    """

    values: NDArray[np.float32]
    origin: Array
    cell: float

    def at(self, points: Array) -> Array:
        """Trilinear interpolation, shape ``(n,)``."""
        grid = (points - self.origin) / self.cell
        return np.asarray(map_coordinates(self.values, grid.T, order=1))

    def gradient(self, points: Array) -> Array:
        """Unit directions in which it grows, by central differences, shape ``(n, 3)``.

        The x axis where it is constant.
        """
        half = 0.5 * self.cell * np.eye(3)
        rise = [self.at(points + step) - self.at(points - step) for step in half]
        return unit(np.stack(rise, axis=1).astype(np.float64))


def grid_cells(points: Array, cell: float) -> float:
    """Number of cells that :func:`poisson_indicator` needs before coarsening."""
    extent = np.ptp(points, axis=0)
    return float(np.prod((extent + 2.0 * _margin(extent, cell)) / cell))


def poisson_indicator(
    points: Array,
    normals: Array,
    areas: Array,
    cell: float = 1.0,
    smoothing: float = 1.0,
    threads: int = -1,
) -> Indicator:
    """Solve for the indicator on a grid.

    Parameters
    ----------
    points, normals : shape ``(n, 3)``, normals outward.
    areas : surface area that each point stands for, shape ``(n,)``.
    cell : grid spacing.
    smoothing : standard deviation of the Gaussian, in cells.
    threads : threads of the transforms; the result does not depend on it.
    """
    extent, low = np.ptp(points, axis=0), points.min(axis=0)
    coarsening = max(1.0, (grid_cells(points, cell) / MAX_CELLS) ** (1.0 / 3.0))
    cell = cell * coarsening
    margin = _margin(extent, cell)
    shape = tuple(
        int(scipy.fft.next_fast_len(int(np.ceil(side)), real=True))
        for side in (extent + 2.0 * margin) / cell
    )
    origin = low - margin
    # The grid is that of all points, also where only those of one face have a normal.
    told = np.flatnonzero(normals.any(axis=1))
    normals, areas = normals[told], areas[told]
    position = (points[told] - origin) / cell
    corner = np.floor(position).astype(np.int64)
    fraction = position - corner

    frequency = [2.0 * np.pi * np.fft.fftfreq(side) for side in shape[:2]]
    frequency.append(2.0 * np.pi * np.fft.rfftfreq(shape[2]))
    waves = np.meshgrid(*(f.astype(np.float32) for f in frequency), indexing="ij", sparse=True)

    flat, weights = _trilinear(corner, fraction, shape)
    divergence = np.zeros((*shape[:2], shape[2] // 2 + 1), dtype=np.complex64)
    for axis in range(3):
        mass = weights * (normals[:, axis] * areas)
        field = np.bincount(flat.ravel(), mass.ravel(), minlength=int(np.prod(shape)))
        field = field.reshape(shape).astype(np.float32)
        divergence += 1j * waves[axis] * scipy.fft.rfftn(field, workers=threads)
    squared = waves[0] ** 2 + waves[1] ** 2 + waves[2] ** 2
    gaussian = np.exp(-0.5 * smoothing**2 * squared)
    squared[0, 0, 0] = 1.0
    divergence *= gaussian / squared
    divergence[0, 0, 0] = 0.0
    values = scipy.fft.irfftn(divergence, s=shape, workers=threads) / cell**2
    return Indicator(np.asarray(values, dtype=np.float32), origin, cell)


def point_areas(distances: Array) -> Array:
    """Surface area that each point stands for, from its 8th neighbour, shape ``(n,)``."""
    return np.asarray(np.pi * distances[:, 8] ** 2 / 8.0)


def _margin(extent: Array, cell: float) -> float:
    return float(max(8.0 * cell, 0.15 * extent.max()))


def _trilinear(
    corner: NDArray[np.int64], fraction: Array, shape: tuple[int, ...]
) -> tuple[NDArray[np.int64], Array]:
    """Flat grid indices and weights of the eight cell corners, each shape ``(8, n)``."""
    offsets = np.stack(np.meshgrid([0, 1], [0, 1], [0, 1], indexing="ij"), axis=-1).reshape(8, 3)
    index = corner[None] + offsets[:, None]
    flat = np.ravel_multi_index(tuple(np.moveaxis(index, 2, 0)), shape)
    weights = np.where(offsets[:, None] == 1, fraction[None], 1.0 - fraction[None]).prod(axis=2)
    return flat, weights
