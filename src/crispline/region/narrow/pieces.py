"""Pieces of one face about an axis that other faces keep apart: the chamfer of a nut.

Where a cone turns the corners of a prism, a crescent is left at each. A crescent hardly tells a
cone from a plane and comes out as a plane, each leaning another way, and their tips are lost.
But the axis is known, from the bore or the shank, and about it one line explains them all.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from crispline.fit.cone import MAX_HALF_ANGLE, MIN_HALF_ANGLE
from crispline.fit.residual import rms
from crispline.fit.swept import Line, Revolution, fit_line
from crispline.fit.verdict import is_pure_noise
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.evidence import Evidence
from crispline.region.fitting import fitted_region
from crispline.region.narrow.coaxial import Fits, axes
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Surface
from crispline.surface.base import Array
from crispline.surface.intersect import intersect

_MIN_PIECES = 3
_MIN_POINTS = 10  # of a piece
_NECK = 0.15  # height of the edge over the cone where they are one, spacings
_MEET = 0.1  # faces that meet have points so near to both, spacings
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
    noise = {
        name: float(np.median(evidence.patch_noise[label == name]))
        for name in sorted(fits, key=lambda name: (-size[name], name))
        if size[name] <= options.max_pruned_patches and len(fits[name].points) >= _MIN_POINTS
    }
    for sweep in axes(fits, size, options):
        small = [name for name in noise if name not in found]
        flat = {name: sweep.flattened(fits[name].points) for name in small}
        while small:
            pieces, surface = _pieces(small, sweep, flat, noise, fits)
            if surface is not None and len(pieces) >= _MIN_PIECES:
                for name in pieces:
                    fit = fits[name]
                    normals = fit.orientation * fit.surface.project(fit.points)[1]
                    found[name] = fitted_region(surface, fit.points, normals, True)
            small = [name for name in small[1:] if name not in found]
    return found


def bridged(
    label: Labels, fits: Fits, pieces: Fits, graph: PatchGraph, options: RegionOptions
) -> Labels:
    """Labels in which pieces of a cone are one over the narrow necks between them.

    A neck is where the edge of two other faces would stand out of the cone.

    Parameters
    ----------
    label, fits : regions and surface of each.
    pieces : what :func:`shared_by_pieces` has found.
    """
    label = label.copy()
    cones = {id(fit.surface): fit.surface for fit in pieces.values()}
    for cone in cones.values():
        names = [name for name, fit in pieces.items() if fit.surface is cone]
        near = np.stack([graph.rings(label == name, 1) for name in names])
        beside = np.setdiff1d(label[near.any(axis=0)], names).tolist()
        ends = np.sort(label[graph.pairs], axis=1)
        for pair in combinations(beside, 2):
            neck = np.isin(label, pair) & (near.sum(axis=0) > 1)  # where tips touch each other
            neck[graph.pairs[(ends == pair).all(axis=1)]] = True
            neck &= np.abs(cone.signed_distance(graph.points)) < options.ring_gap
            stretch = components(graph.adjacency, neck)
            for part in np.unique(stretch[neck]).tolist():
                own = neck & (stretch == part)
                joined = np.intersect1d(label[graph.rings(own, 1)], names)
                if not len(joined):
                    continue
                edge, gap = intersect(graph.points[own], [fits[side].surface for side in pair])
                away = np.linalg.norm(edge - graph.points[own], axis=1)
                out = pieces[int(joined[0])].orientation * cone.signed_distance(edge)
                meet = gap.max() < _MEET and away.max() < options.ring_gap
                if meet and out.min() > _NECK:
                    wide = graph.rings(own, 1) & np.isin(label, pair)  # a row would not last
                    label[wide | np.isin(label, joined)] = joined[0]
    return label


def _pieces(
    names: list[int],
    sweep: Revolution,
    flat: Mapping[int, Array],
    noise: Mapping[int, float],
    fits: Fits,
) -> tuple[list[int], Surface | None]:
    """Those of some faces that share a cone with the first, and the cone; None if it is none."""
    sigma = max(noise[name] for name in names)
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
