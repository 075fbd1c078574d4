"""Pieces of one face about an axis that other faces keep apart: the chamfer of a nut.

Where a cone turns the corners of a prism, a crescent is left at each. A crescent hardly tells a
cone from a plane and comes out as a plane, each leaning another way, and their tips are lost.
But the axis is known, from the bore or the shank, and about it one line explains them all.
"""

from __future__ import annotations

import numpy as np

from crispline.fit.cone import MAX_HALF_ANGLE, MIN_HALF_ANGLE
from crispline.fit.residual import rms
from crispline.fit.swept import Line, Revolution, fit_line
from crispline.fit.verdict import is_pure_noise
from crispline.options import RegionOptions
from crispline.region.evidence import Evidence
from crispline.region.fitting import fitted_region
from crispline.region.narrow.coaxial import Fits, axes
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Surface
from crispline.surface.base import Array

_MIN_PIECES = 3
_MIN_POINTS = 10  # of a piece
_SAME = 0.5  # distance of the median of a piece from the line of another, spacings


def shared_by_pieces(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> dict[int, RegionFit]:
    """The common cones of small faces about the axis of a larger one.

    At least three faces share a cone, if it leaves nothing but noise in the points of each
    and no more than the parameters of a surface of its own are worth.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    found: dict[int, RegionFit] = {}
    size = np.bincount(label)
    for sweep in axes(fits, size, options):
        small = [
            name
            for name in sorted(fits, key=lambda name: (-size[name], name))
            if size[name] <= options.max_pruned_patches
            and len(fits[name].points) >= _MIN_POINTS
            and name not in found
        ]
        while small:
            pieces, surface = _pieces(small, sweep, label, fits, evidence)
            if surface is not None and len(pieces) >= _MIN_PIECES:
                for name in pieces:
                    fit = fits[name]
                    normals = fit.orientation * fit.surface.project(fit.points)[1]
                    found[name] = fitted_region(surface, fit.points, normals, True)
            small = [name for name in small[1:] if name not in found]
    return found


def _pieces(
    names: list[int], sweep: Revolution, label: Labels, fits: Fits, evidence: Evidence
) -> tuple[list[int], Surface | None]:
    """Those of some faces that share a cone with the first, and the cone; None if it is none."""
    flat = {name: sweep.flattened(fits[name].points) for name in names}
    noise = {name: float(np.median(evidence.patch_noise[label == name])) for name in names}
    sigma = max(noise.values())
    members, line = [names[0]], fit_line(flat[names[0]], sigma)
    for name in names[1:]:
        if line is None or abs(float(np.median(_off(line, flat[name])))) > _SAME:
            continue
        trial = [*members, name]
        common = fit_line(np.concatenate([flat[member] for member in trial]), sigma)
        if common is not None and all(
            _is_enough(_off(common, flat[member]), fits[member], noise[member]) for member in trial
        ):
            members, line = trial, common
    cone = None if line is None else sweep.surface(line)
    is_cone = isinstance(cone, Cone) and MIN_HALF_ANGLE < cone.half_angle < MAX_HALF_ANGLE
    return members, cone if is_cone else None


def _off(line: Line, flat: Array) -> Array:
    return np.asarray(flat @ line.normal - line.offset)


def _is_enough(residuals: Array, own: RegionFit, sigma: float) -> bool:
    """Whether a piece needs no surface of its own, by the Bayesian information criterion."""
    n_points = len(residuals)
    more = float(np.square(residuals).sum() - np.square(own.residuals).sum()) / sigma**2
    is_worse = more > own.surface.n_parameters * np.log(n_points)
    return is_pure_noise(rms(residuals), n_points, sigma) and not is_worse
