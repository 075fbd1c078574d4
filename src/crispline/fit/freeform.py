"""A free-form region: as little freedom as leaves nothing but noise."""

from __future__ import annotations

from crispline.fit.bspline import fit_bspline_surface
from crispline.fit.extrusion import fit_extrusion
from crispline.fit.revolution import fit_revolution
from crispline.fit.verdict import Fit, tested
from crispline.options import FitOptions
from crispline.surface.base import Array


def free_form(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    border_distance: Array | None = None,
) -> Fit | None:
    """A spline profile swept along a line or about an axis, or else a free B-spline.

    Parameters
    ----------
    points, normals, sigma, options, border_distance : see
        :func:`crispline.fit.bspline.fit_bspline_surface`.

    Returns
    -------
    A swept profile only if it passes the residual test; the B-spline also if it does not. None
    for a region that is no height field and not swept.
    """
    for fit_swept in (fit_extrusion, fit_revolution):
        swept = fit_swept(points, normals, sigma, options, border_distance=border_distance)
        if swept is not None:
            fit = tested(swept, points, sigma, options, normals)
            if fit.is_accepted:
                return fit
    free = fit_bspline_surface(points, normals, sigma, options, border_distance=border_distance)
    return None if free is None else tested(free, points, sigma, options, normals)
