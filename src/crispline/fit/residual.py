"""Residuals of a fit and the test whether they are noise."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.fit.robust import thinned
from crispline.options import FitOptions
from crispline.surface.base import Array

N_NEIGHBOURS = 30
"""Residuals averaged for the drift; also in the meaning of ``FitOptions.accept_drift``."""
_N_PROBES = 1000
_MAX_NORMAL_ERROR = np.radians(40.0)  # largest median angle between given and fitted normals


@dataclass(frozen=True)
class ResidualTest:
    """Size and drift of residuals against the noise.

    Attributes
    ----------
    rms : root mean square, spacings, of residuals clipped as :func:`clipped` does.
    drift : rms of their averages over 30 neighbours, spacings; noise averages
        out, a wrong shape does not.
    is_accepted : whether both are what noise explains.
    """

    rms: float
    drift: float
    is_accepted: bool


def residual_limit(sigma: float, options: FitOptions) -> float:
    """Largest residual of a point that belongs to the surface, spacings."""
    return 4.0 * sigma + 3.0 * options.tolerance


def clipped(residuals: Array, sigma: float, options: FitOptions) -> Array:
    """Residuals limited to what still counts, so that a few foreign points do not decide."""
    limit = residual_limit(sigma, options)
    return np.clip(residuals, -limit, limit)


def rms(residuals: Array) -> float:
    """Root mean square; 0 for none."""
    return float(np.sqrt(np.mean(np.square(residuals)))) if residuals.size else 0.0


def drift(points: Array, residuals: Array) -> float:
    """Root mean square of :func:`local_means`."""
    return rms(local_means(points, residuals))


def local_means(points: Array, residuals: Array) -> Array:
    """Averages of the residuals over 30 neighbours, at up to 1000 points chosen reproducibly."""
    return means_over(neighbourhoods(points), residuals)


def neighbourhoods(points: Array) -> NDArray[np.int64]:
    """The 30 nearest of points ``(n, 3)`` to each of up to 1000, a row each."""
    if not len(points):
        return np.zeros((0, 1), dtype=np.int64)
    n_neighbours = min(N_NEIGHBOURS, len(points))
    probes = points[thinned(len(points), _N_PROBES)]
    _, neighbours = cKDTree(points).query(probes, n_neighbours)
    return np.asarray(neighbours, dtype=np.int64).reshape(len(probes), -1)


def means_over(neighbours: NDArray[np.int64], residuals: Array) -> Array:
    """Averages of the residuals over known :func:`neighbourhoods`."""
    return np.asarray(residuals[neighbours].mean(axis=1)) if len(neighbours) else np.zeros(0)


def rms_limit(sigma: float, options: FitOptions) -> float:
    """Largest rms residual that noise explains, spacings."""
    return options.accept_rms * sigma + 2.0 * options.tolerance


def drift_limit(n_points: int, sigma: float, options: FitOptions) -> float:
    """Largest drift that noise explains, spacings."""
    averaged = min(N_NEIGHBOURS, max(n_points, 1))
    # What neighbours have in common does not average out.
    left = np.sqrt((1.0 - options.shared_variance) / averaged + options.shared_variance)
    return float(options.accept_drift * sigma * left + options.tolerance)


def judge(points: Array, residuals: Array, sigma: float, options: FitOptions) -> ResidualTest:
    """Test residuals ``(n,)`` of points ``(n, 3)`` against the noise ``sigma`` (spacings)."""
    within = clipped(residuals, sigma, options)
    size, trend = rms(within), drift(points, within)
    is_accepted = size < rms_limit(sigma, options) and trend < drift_limit(
        len(points), sigma, options
    )
    return ResidualTest(size, trend, is_accepted)


def faces_alike(normals: Array, surface_normals: Array) -> bool:
    """Whether half the normals are within 40 degrees of the surface's, on one side.

    Both ``(n, 3)``; one normal ``(1, 3)`` of a plane will do.

    Lenient, because normals near edges are poor; it rejects a plane through the
    points of a narrow ring, whose distances alone look like noise.
    """
    cosines = np.asarray((normals * surface_normals).sum(axis=1))
    side = 1.0 if cosines.sum() >= 0.0 else -1.0
    return bool(np.median(side * cosines) > np.cos(_MAX_NORMAL_ERROR))
