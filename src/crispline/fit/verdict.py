"""A fitted surface and whether it explains its points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crispline.fit.residual import faces_alike, judge
from crispline.fit.robust import thinned
from crispline.options import FitOptions
from crispline.surface import Surface
from crispline.surface.base import Array


@dataclass(frozen=True)
class Fit:
    """A surface and how well it explains its points.

    Attributes
    ----------
    surface : the surface.
    rms, drift : of the residuals, spacings; see :class:`crispline.fit.residual.ResidualTest`.
    is_accepted : whether the residuals are what noise explains.
    n_points : number of points that were fitted and tested.
    """

    surface: Surface
    rms: float
    drift: float
    is_accepted: bool
    n_points: int


def is_pure_noise(size: float, n_points: int, sigma: float) -> bool:
    """Whether the rms residual is within three standard errors of the noise."""
    return size**2 < sigma**2 * (1.0 + 3.0 * float(np.sqrt(2.0 / n_points)))


def tested(
    surface: Surface,
    points: Array,
    sigma: float,
    options: FitOptions,
    normals: Array | None = None,  # noqa: PT028  (not a test)
) -> Fit:
    """The surface with the test of its residuals, and normals if given, at points ``(n, 3)``."""
    feet, surface_normals = surface.project(points)
    residuals = np.einsum("ij,ij->i", points - feet, surface_normals)
    result = judge(points, residuals, sigma, options)
    is_accepted = result.is_accepted and (normals is None or faces_alike(normals, surface_normals))
    return Fit(surface, result.rms, result.drift, is_accepted, len(points))


def explains(
    surface: Surface, points: Array, normals: Array, sigma: float, options: FitOptions
) -> bool:
    """Whether the surface leaves nothing but noise at the points and faces as they do.

    The same test that :func:`crispline.fit.choose.choose_surface` accepts a fit by, for points
    ``(n, 3)`` that need not have been fitted.
    """
    sigma = max(sigma, options.sigma_floor)
    kept = thinned(len(points), options.max_points)
    return tested(surface, points[kept], sigma, options, normals[kept]).is_accepted
