"""One primitive for several regions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crispline.fit.choose import CANDIDATE_SLACK, N_CANDIDATE_POINTS, PRIMITIVE_FITS
from crispline.fit.residual import residual_limit, rms, rms_limit
from crispline.fit.robust import thinned
from crispline.options import FitOptions
from crispline.surface import Surface
from crispline.surface.base import Array

_OFF = 0.4  # sigmas that a piece may lie off by ...
_CREST = 1.6  # ... and where neighbours err together, as a small one lies on one ripple


def fit_jointly(
    kinds: Sequence[str],
    parts: Sequence[tuple[Array, Array]],
    sigma: float,
    options: FitOptions,
) -> Surface | None:
    """The simplest primitive that explains every one of several regions.

    Parameters
    ----------
    kinds : the kinds to try, in this order; B-splines are not tried.
    parts : points and normals ``(n, 3)`` of each region.
    sigma : noise along the normal, spacings.

    Returns
    -------
    The surface fitted to all regions together, if in each region alone the rms
    residual is below ``accept_rms sigma + 3 tolerance`` and the mean residual
    below ``0.4 sigma + tolerance``, or what neighbours share of the noise; else None.
    """
    sigma = max(sigma, options.sigma_floor)
    n_each = max(options.max_points // max(len(parts), 1), 1)
    subsets = [thinned(len(points), n_each) for points, _ in parts]
    points = np.concatenate([p[kept] for (p, _), kept in zip(parts, subsets, strict=True)])
    normals = np.concatenate([n[kept] for (_, n), kept in zip(parts, subsets, strict=True)])
    rough = thinned(len(points), N_CANDIDATE_POINTS)
    cut = residual_limit(sigma, options)
    limit = CANDIDATE_SLACK * (rms_limit(sigma, options) + options.tolerance)
    for kind in kinds:
        if kind not in PRIMITIVE_FITS:
            continue
        # Most pairs are not one surface; a draft on some of the points tells.
        draft = PRIMITIVE_FITS[kind](points[rough], normals[rough], sigma, None, True)
        if draft is None or (rms(np.clip(draft.signed_distance(points[rough]), -cut, cut)) > limit):
            continue
        surface = PRIMITIVE_FITS[kind](points, normals, sigma, draft)
        if surface is not None and all(
            _explains_part(surface, part, sigma, options) for part, _ in parts
        ):
            return surface
    return None


def _explains_part(surface: Surface, points: Array, sigma: float, options: FitOptions) -> bool:
    limit = residual_limit(sigma, options)
    residuals = np.clip(surface.signed_distance(points), -limit, limit)
    off = _CREST * float(np.sqrt(options.shared_variance)) * sigma
    most = max(rms_limit(sigma, options), float(np.hypot(sigma, off))) + options.tolerance
    return (
        rms(residuals) < most
        and abs(float(residuals.mean())) < max(_OFF * sigma, off) + options.tolerance
    )
