"""B-splines refitted so that they pass smoothly into their neighbours."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from crispline.fit.bspline import PassThrough, fit_bspline_surface
from crispline.fit.extrusion import fit_extrusion
from crispline.fit.residual import residual_limit
from crispline.fit.verdict import explains
from crispline.options import FitOptions, LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Topology
from crispline.sharp.crease import touching_border
from crispline.sharp.network import corner_vertices
from crispline.sharp.trace import Guide, guide_along
from crispline.surface import ExtrudedSurface
from crispline.surface.base import Array

_BESIDE = 1.0
"""How far from the border the neighbour's tangent plane is taken over, spacings."""
_MAX_KINK_DEG = 30.0
"""Free B-splines swing at their rim: up to this angle a border is tried as a smooth one, and
the points decide."""
_MAX_GAP = 0.5
"""Surfaces farther apart along a border do not touch: a narrow face was lost there, spacings."""
_FINER = 5.0
"""A join that needs so many times the control points is no join."""


def blended(
    topology: Topology,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    sigma: float,
    fit_options: FitOptions,
    options: LocateOptions,
) -> dict[int, RegionFit]:
    """The fits with every B-spline drawn to its smooth borders.

    Primitives stay; of two B-splines the larger is refitted first and then stays for
    the other. A refitted surface is kept if its points still lie on it and it is
    nearer to its neighbours than before.

    Parameters
    ----------
    topology, net_vertices, regions : as for :func:`crispline.sharp.locate.locate`.
    sigma : noise of the raw points, spacings.
    fit_options : of the fits.
    options : which borders count as smooth.
    """
    found = dict(regions)
    lenient = replace(options, smooth_angle_deg=max(options.smooth_angle_deg, _MAX_KINK_DEG))
    free = [label for label, fit in regions.items() if fit.surface.kind == "bspline"]
    fixed = set(regions) - set(free)
    for label in sorted(free, key=lambda label: (-len(regions[label].points), label)):
        borders = list(_borders(label, fixed, topology, net_vertices, found, lenient))
        fixed.add(label)
        if not borders:
            continue
        constraints = PassThrough(
            np.concatenate([positions for positions, _ in borders]),
            np.concatenate([beside for _, beside in borders]),
        )
        refitted = _refitted(found[label], constraints, sigma, fit_options)
        if refitted is not None:
            found[label] = refitted
    return found


def _borders(
    label: int,
    fixed: set[int],
    topology: Topology,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    options: LocateOptions,
) -> Iterator[tuple[Array, Array]]:
    """Points of the neighbours along and beside the smooth borders of a region."""
    anchors = corner_vertices(topology)
    for chain in topology.chains:
        if label not in (chain.left, chain.right):
            continue
        other = chain.right if chain.left == label else chain.left
        if other not in fixed:
            continue
        is_ring = chain.is_closed and int(chain.vertices[0]) not in anchors
        guide = guide_along(net_vertices[chain.vertices], is_ring)
        pair = [regions[chain.left], regions[chain.right]]
        if touching_border(guide, pair, options) is None:
            continue
        feet, beside = _along(guide, regions[other], 1.0 if chain.left == other else -1.0)
        if np.abs(regions[label].surface.signed_distance(feet)).max() <= _MAX_GAP:
            yield feet, beside


def _along(guide: Guide, neighbour: RegionFit, side: float) -> tuple[Array, Array]:
    """Feet of a guide on a neighbour and points of it a little to its side, both ``(n, 3)``."""
    feet, normals = neighbour.surface.project(guide.points)
    # Seen from outside, a region on the left of a border lies towards normal x direction.
    across = side * neighbour.orientation * np.cross(normals, guide.directions())
    beside, _ = neighbour.surface.project(feet + _BESIDE * across)
    return feet, beside


def _refitted(
    fit: RegionFit, constraints: PassThrough, sigma: float, options: FitOptions
) -> RegionFit | None:
    """The B-spline through the constraints; None if its points or they speak against it."""
    sigma = max(sigma, options.sigma_floor)
    # Points that the free fit left out at the rim belong to a neighbour.
    own = np.abs(fit.residuals) < residual_limit(sigma, options)
    points = fit.points[own]
    normals = fit.orientation * fit.surface.project(points)[1]
    is_swept = isinstance(fit.surface, ExtrudedSurface)
    refit = fit_extrusion if is_swept else fit_bspline_surface
    surface = refit(points, normals, sigma, options, constraints)
    if surface is None or surface.n_parameters > _FINER * fit.surface.n_parameters:
        return None
    if not explains(surface, points, normals, sigma, options):
        return None
    before, after = (
        float(np.abs(candidate.signed_distance(constraints.points)).max())
        for candidate in (fit.surface, surface)
    )
    if after >= before:
        return None
    return RegionFit(surface, 1, fit.points, surface.signed_distance(fit.points), True)
