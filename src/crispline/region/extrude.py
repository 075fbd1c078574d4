"""Smooth neighbours that are pieces of one face with straight rulings.

Between its creases a spline that was swept along a line has no primitive in it, yet noise lets
two or three cylinders pass for most of it. They leave more in the residuals than a profile does
that takes hardly more numbers to tell, and their borders are nowhere in the part.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.fit.choose import explains
from crispline.fit.extrusion import fit_extrusion
from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import LabelledCloud, fitted_region
from crispline.region.merge import MIN_BORDER, chi_square, gentle_borders
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

_SWEPT = ("cylinder", "cone", "bspline")  # what a piece of such a face passes for ...
_STRIP = "plane"  # ... and a small piece beside one of these
_NOISE_SHARE = 0.02  # fits differ by this much per point for reasons that are no faces
_MAX_ROUNDS = 8

Samples = tuple[Array, Array, Array]


def with_extrusions(
    label: Labels,
    fits: Mapping[int, RegionFit],
    labelled: LabelledCloud,
    graph: PatchGraph,
    options: RegionOptions,
    fit_options: FitOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels after joining neighbours that one surface of extrusion explains better.

    Better is: with the shorter description, residuals and parameters together. So cylinders
    that touch as designed stay, as nothing is left in their residuals.

    Parameters
    ----------
    label, fits : regions and surface of each.

    Returns
    -------
    The labels, and the surfaces of the joined regions.
    """
    label, found = label.copy(), dict(fits)
    joined: dict[int, RegionFit] = {}
    samples: dict[int, Samples] = {}
    refused: set[tuple[int, int]] = set()
    for _ in range(_MAX_ROUNDS):
        changed = False
        for pair, sides, _angle in gentle_borders(label, found, graph, options.merge_deg):
            if sides < MIN_BORDER or pair in refused or not set(pair) <= set(found):
                continue
            if not _may_be_swept([found[region] for region in pair]):
                continue
            for region in pair:
                if region not in samples:
                    samples[region] = labelled.samples(region, fit_options)
            parts = [samples[region] for region in pair]
            sigma = labelled.sigma(*pair)
            one = _joint(parts, [found[region] for region in pair], sigma, fit_options)
            if one is None:
                refused.add(pair)
                continue
            kept, gone = pair
            label[label == gone] = kept
            refused = {p for p in refused if kept not in p}
            samples[kept] = _together(parts)
            found[kept] = joined[kept] = one
            del found[gone]
            joined.pop(gone, None)
            changed = True
        if not changed:
            break
    return label, joined


def _may_be_swept(fits: list[RegionFit]) -> bool:
    """Whether two surfaces may be pieces of one that was swept."""
    smaller, larger = sorted(fits, key=lambda fit: len(fit.points))
    return larger.surface.kind in _SWEPT and smaller.surface.kind in (*_SWEPT, _STRIP)


def _together(parts: list[Samples]) -> Samples:
    points, normals, clearance = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(normals), np.concatenate(clearance)


def _joint(
    parts: list[Samples], fits: list[RegionFit], sigma: float, options: FitOptions
) -> RegionFit | None:
    """One surface of extrusion for two regions; None if it does not pay."""
    points, normals, clearance = _together(parts)
    sigma = max(sigma, options.sigma_floor)
    n = len(points)
    apart = chi_square(
        [(fit.surface, part) for fit, (part, _, _) in zip(fits, parts, strict=True)], sigma
    )
    surface = fit_extrusion(points, normals, sigma, options, border_distance=clearance)
    if surface is None:
        return None
    spared = sum(fit.surface.n_parameters for fit in fits) - surface.n_parameters
    together = chi_square([(surface, points)], sigma)
    if together + _NOISE_SHARE * n > apart + 2.0 * spared * float(np.log(n)):
        return None
    if not all(explains(surface, part, facing, sigma, options) for part, facing, _ in parts):
        return None
    return fitted_region(surface, points, normals, True)
