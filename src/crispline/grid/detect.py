"""Steps two and three on a grid or a B-spline surface: curvature, then flat, curved and sharp."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from crispline.grid.band import curved_band, paper_rule
from crispline.grid.centres import Curvature, grid_curvature, surface_centres
from crispline.grid.lattice import Lattice, Mask, Surface, as_lattice
from crispline.grid.noise import Noise, estimate_noise
from crispline.options import SharpenOptions
from crispline.sharp.curvature import curvature as mean_curvature
from crispline.sharp.detect import normal_spread
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array, unit

Index = NDArray[np.int64]

PAPER_EPS = 0.25
"""Between 0.15, beside a right-angled edge midway between two rows, and 0.6 on it."""
_RINGS = 3


@dataclass(frozen=True)
class Detection:
    """Which patches are flat, curved and sharp, each mask of shape ``(m - 1, n - 1)``.

    Attributes
    ----------
    has_patch : cells with four valid points.
    is_curved : curvature above the threshold, sharp ones included.
    is_sharp : curved, between flat patches.
    threshold : smallest curvature called curved, 1/spacing.
    noise : of the points, spacings.
    """

    has_patch: Mask
    is_curved: Mask
    is_sharp: Mask
    threshold: float
    noise: Noise


def curvature(surface: Surface | Lattice) -> Curvature:
    """Mean curvature of every patch at its centre, and the patch's size.

    Parameters
    ----------
    surface : organised points ``(m, n, 3)``, which are the control net of a uniform
        bicubic surface, one patch a cell; or a B-spline surface, one patch a knot span.
    """
    lattice = as_lattice(surface)
    if not isinstance(lattice.given, TensorSpline):
        found = grid_curvature(lattice.points, lattice.is_valid)
        return Curvature(found.mean / lattice.spacing, found.size * lattice.spacing)
    centres = surface_centres(lattice.given, lattice.u, lattice.v)
    return Curvature(mean_curvature(centres), centres.size)


def detect(
    surface: Surface | Lattice,
    curvature: Curvature,
    options: SharpenOptions | None = None,
) -> Detection:
    """Classify every patch as flat, curved or sharp.

    The paper's rule: a patch is curved if ``|H| >= eps``, sharp if four or more of its
    eight neighbours are flat. The robust rule: thresholds follow from the noise, which
    is estimated from the points; curvature is smoothed along the way; a curved patch
    is sharp if it is the most curved across the band and the flat patches around face
    different ways.

    Parameters
    ----------
    surface : what the curvature was computed of.
    """
    options = options or SharpenOptions()
    lattice = as_lattice(surface)
    has_patch, noise = lattice.has_patch, estimate_noise(lattice)
    if options.rule == "paper":
        eps = PAPER_EPS if options.eps is None else options.eps
        bend = curvature.mean * lattice.spacing
        is_curved, is_sharp = paper_rule(bend, has_patch, eps)
        return Detection(has_patch, is_curved, is_sharp, eps, noise)
    bend = curvature.mean * curvature.size
    is_curved, smooth, threshold = curved_band(bend, has_patch, noise.normal, options)
    is_sharp = _ridge(lattice, smooth, is_curved)
    is_sharp &= _spread(lattice, is_curved, is_sharp) > np.radians(options.spread_deg)
    return Detection(has_patch, is_curved, is_sharp, threshold, noise)


def _ridge(lattice: Lattice, bend: Array, is_curved: Mask) -> Mask:
    """Curved patches that are the most curved ones across their band; equals count both."""
    ridge = np.zeros_like(is_curved)
    i, j = np.nonzero(is_curved)
    # The band runs along the direction in which the normals of the cells change least.
    normal = np.stack([cell_normals(lattice, i + di, j) for di in (-1, 1)])
    turn_u = np.linalg.norm(normal[1] - normal[0], axis=1)
    normal = np.stack([cell_normals(lattice, i, j + dj) for dj in (-1, 1)])
    turn_v = np.linalg.norm(normal[1] - normal[0], axis=1)
    padded = np.pad(bend, 1)
    along_u = np.maximum(padded[i, j + 1], padded[i + 2, j + 1])
    along_v = np.maximum(padded[i + 1, j], padded[i + 1, j + 2])
    ridge[i, j] = bend[i, j] >= (1.0 - 1e-9) * np.where(turn_u >= turn_v, along_u, along_v)
    return ridge


def _spread(lattice: Lattice, is_curved: Mask, wanted: Mask) -> Array:
    """Angle between the flat normals near each wanted patch that differ most, ``(m, n)``."""
    spread = np.zeros(is_curved.shape)
    if not wanted.any():
        return spread
    m, n = is_curved.shape
    near = wanted.copy()
    for _ in range(_RINGS):
        grown = near.copy()
        grown[1:] |= near[:-1]
        grown[:-1] |= near[1:]
        grown[:, 1:] |= near[:, :-1]
        grown[:, :-1] |= near[:, 1:]
        near = grown & lattice.has_patch
    i, j = np.nonzero(near)
    number = np.full((m, n), -1)
    number[i, j] = np.arange(len(i))
    pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
    one, two = (np.concatenate([pair[k].ravel() for pair in pairs]) for k in (0, 1))
    both = (one >= 0) & (two >= 0)
    one, two = one[both], two[both]
    ends = (np.concatenate([one, two]), np.concatenate([two, one]))
    adjacency = csr_array(coo_array((np.ones(2 * len(one)), ends), shape=(len(i), len(i))))
    normals = cell_normals(lattice, i, j)
    found = normal_spread(normals, adjacency, is_curved[i, j], _RINGS, wanted[i, j])
    spread[i, j] = found
    return spread


def cell_normals(lattice: Lattice, i: Index, j: Index) -> Array:
    """Unit normals of cells, from their diagonals; cells beyond the border count as on it."""
    m, n = lattice.is_valid.shape
    i, j = np.clip(i, 0, m - 2), np.clip(j, 0, n - 2)
    p = lattice.points
    return unit(np.cross(p[i + 1, j + 1] - p[i, j], p[i, j + 1] - p[i + 1, j]))
