"""Narrow faces about the axis of a larger one: chamfers, fillets and grooves of turned parts.

A face two or three patches wide hardly tells its own axis: seeds find a piece of it here and
there, each of which leans another way, and borders close over the rest. But what goes round
a cylinder has the cylinder's axis. A line or a circle in the half plane of that axis, fitted
to the raw points that lie off the larger faces, explains all pieces at once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.cone import MAX_HALF_ANGLE, MIN_HALF_ANGLE
from crispline.fit.swept import Profile, Revolution, fit_circle, fit_line
from crispline.options import RegionOptions
from crispline.region.claim import Claim, cheapest_together, misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.narrow.coaxial import Fits, goes_round
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Cylinder, Plane, Surface, Torus
from crispline.surface.base import Array

Mask = NDArray[np.bool_]

_AROUND = 3  # rings about the borders of the neighbours, within which a face is looked for
_OFF = 1.5  # sigmas; points farther from the larger faces than this are on none of them
_FAR_OFF = 3.0  # sigmas; noise leaves hardly any so far off
_REACH = 3.0  # sigmas; points nearer to the new surface than this are on it
_MIN_POINTS = 10
_STEPS = 8  # of growth
_WITHIN = 0.9  # share of a crumb that must lie where the new face is looked for ...
_SHARED = 0.5  # ... and of its lost points that must be on it, or the crumb stays
_MAX_TILT = np.radians(3.0)  # of planes that count as being across an axis
_MAX_OFFSET = 0.5  # of axes that count as one, spacings
_ALONE = 2.0  # times the cost of a face that a single crumb must be worth


@dataclass(frozen=True)
class _Site:
    """A crumb, the larger faces beside it, and the raw points along their borders.

    Attributes
    ----------
    crumb, larger : labels.
    near : patches in question, shape ``(m,)``.
    points, noise, patch : of the ``n`` raw points on them.
    owner : label of each point's patch.
    off : misfit of each point, in squared residuals over 2 sigma^2, on the best of the larger.
    lost : points off the larger faces, to the side of each on which those of the crumb are.
    """

    crumb: int
    larger: tuple[int, ...]
    near: Mask
    points: Array
    noise: Array
    patch: Labels
    owner: Labels
    off: Array
    lost: Mask

    def misfit(self, surface: Surface) -> Array:
        """Of each point on a surface, shape ``(n,)``."""
        return misfit(surface.signed_distance(self.points), self.noise)


@dataclass(frozen=True)
class _Ring:
    """A surface about an axis, what it takes, by how much it explains the points better.

    It `completes` a crumb if its points go round the axis, and those of the crumb do not.
    """

    surface: Surface
    field: Mask
    crumbs: tuple[int, ...]
    gain: float
    completes: bool


def with_rings(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels in which crumbs round an axis are one face each, and the surfaces of these.

    A crumb gives way, with others along the same borders, to a surface of revolution about
    the axis of a larger neighbour if the points are explained no worse than by the crumbs, a
    face less counted as `options.face_cost`. For a single crumb they must be explained better
    by what two faces cost, unless it covers a part of a face that goes round.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label, found = label.copy(), dict(fits)
    rings: dict[int, RegionFit] = {}
    names, sizes = np.unique(label, return_counts=True)
    order = np.lexsort((names, -sizes))
    for crumb in names[order][sizes[order] <= options.max_pruned_patches].tolist():
        if crumb in rings or not (label == crumb).any():
            continue
        site = _site(crumb, label, found, evidence, options)
        ring = _best(site, label, found, evidence.graph, options)
        if ring is None:
            continue
        own = np.flatnonzero(label == crumb)
        fit = held_fit(ring.surface, own, evidence)
        _assign(label, {**found, crumb: fit}, ring, site, evidence, options)
        members = np.flatnonzero(label == crumb)
        if len(members):
            found[crumb] = rings[crumb] = held_fit(ring.surface, members, evidence)
    return label, rings


def _site(
    crumb: int, label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> _Site:
    """The surroundings of a crumb: along all borders of its larger neighbours with each other."""
    graph, size = evidence.graph, np.bincount(label)
    beside = np.unique(label[graph.rings(label == crumb, 1)])
    larger = beside[size[beside] > max(size[crumb], options.crumb_patches)]
    is_crumb = size <= options.max_pruned_patches
    ends = label[graph.pairs]
    is_larger = np.isin(ends, larger)
    border = (ends[:, 0] != ends[:, 1]) & is_larger.any(axis=1)
    border &= (is_larger | is_crumb[ends]).all(axis=1)
    along = label == crumb
    along[graph.pairs[border].ravel()] = True
    near = graph.rings(along, _AROUND)
    rows = np.flatnonzero(near[evidence.patch])
    points, patch = evidence.points[rows], evidence.patch[rows]
    noise = np.maximum(evidence.noise[rows], options.swallowed_floor)
    distance = np.full((len(larger) + 1, len(rows)), np.inf)
    for k, region in enumerate(larger.tolist()):
        distance[k] = fits[region].surface.signed_distance(points)
    nearest = np.argmin(np.abs(distance), axis=0)
    height = distance[nearest, np.arange(len(rows))]
    off = misfit(height, noise)
    owner = label[patch]
    lost = off > 0.5 * _OFF**2
    for k in range(len(larger)):
        own = (nearest == k) & lost & (owner == crumb)
        if own.any():
            lost &= (nearest != k) | ((height > 0.0) == (np.median(height[own]) > 0.0))
    return _Site(crumb, tuple(larger.tolist()), near, points, noise, patch, owner, off, lost)


def _best(
    site: _Site, label: Labels, fits: Fits, graph: PatchGraph, options: RegionOptions
) -> _Ring | None:
    """The ring that gains most about any axis, a line before a circle; None if none gains."""
    best: _Ring | None = None
    for sweep in _sweeps(site, label, fits, graph):
        for fit_profile, price in ((fit_line, 0.0), (fit_circle, options.face_cost)):
            ring = _ring(site, sweep, fit_profile, label, fits, graph, options)
            if ring is not None and (best is None or ring.gain > best.gain + price):
                best = ring
    is_alone = best is not None and len(best.crumbs) == 1 and not best.completes
    least = _ALONE * options.face_cost if is_alone else 0.0
    return best if best is not None and best.gain > least else None


def _sweeps(site: _Site, label: Labels, fits: Fits, graph: PatchGraph) -> Iterator[Revolution]:
    """Revolutions about the axes of larger neighbours, each axis once."""
    middle = graph.points[label == site.crumb].mean(axis=0)
    known: list[Revolution] = []
    for region in site.larger:
        surface = fits[region].surface
        match surface:
            case Cylinder():
                origin = surface.origin
            case Cone():
                origin = surface.apex
            case Torus():
                origin = surface.centre
            case _:
                continue
        if not fits[region].is_accepted:
            continue
        axis = surface.axis
        place = origin + ((middle - origin) @ axis) * axis
        if all(np.linalg.norm(np.cross(place - k.origin, k.axis)) > _MAX_OFFSET for k in known):
            known.append(Revolution(place, axis))
            yield known[-1]


def _ring(
    site: _Site,
    sweep: Revolution,
    fit_profile: Callable[[Array, float], Profile | None],
    label: Labels,
    fits: Fits,
    graph: PatchGraph,
    options: RegionOptions,
) -> _Ring | None:
    """The surface grown from a crumb's lost points to all that lie on it."""
    lost = site.lost
    kept = lost & (site.owner == site.crumb)
    surface: Surface | None = None
    for _ in range(_STEPS):
        if np.count_nonzero(kept) < _MIN_POINTS:
            return None
        profile = fit_profile(sweep.flattened(site.points[kept]), float(np.median(site.noise)))
        surface = None if profile is None else sweep.surface(profile)
        if surface is None or not _is_proper(surface):
            return None
        # What noise takes off the larger faces would turn the surface until it lies along them.
        on_it = (site.misfit(surface) < 0.5 * _REACH**2) & ~np.isin(site.owner, site.larger)
        before, kept = kept, lost & on_it
        if np.array_equal(kept, before):
            break
    if surface is None:
        return None
    crumbs = [
        region
        for region in np.setdiff1d(site.owner, site.larger).tolist()
        if _gives_way(region, site, sweep, lost, kept, label, fits, options)
    ]
    if site.crumb not in crumbs:
        return None
    claimed = np.zeros(len(label), dtype=bool)
    is_on = lost & (site.misfit(surface) < 0.5 * _REACH**2)
    claimed[site.patch[is_on]] = True
    is_own = site.owner == site.crumb
    completes = goes_round(sweep, site.points[is_on]) > goes_round(sweep, site.points[is_own])
    is_crumb = np.isin(label, crumbs)
    field = graph.rings(claimed, 1) & site.near & np.isin(label, site.larger) | is_crumb
    before_cost = np.min([site.off, *(site.misfit(fits[r].surface) for r in crumbs)], axis=0)
    after_cost = np.minimum(site.off, site.misfit(surface))
    # Of what noise takes off the larger faces, a surface that hugs them would explain some too.
    counts = np.isin(site.owner, crumbs) | (site.off > 0.5 * _FAR_OFF**2) & field[site.patch]
    gain = float((before_cost - after_cost)[counts].sum())
    gain += options.face_cost * (len(crumbs) - 1)
    return _Ring(surface, field, tuple(crumbs), gain, completes)


def _is_proper(surface: Surface) -> bool:
    """Whether a cone is clearly none of the faces that are usual across or along an axis."""
    if isinstance(surface, Cone):
        return bool(MIN_HALF_ANGLE < surface.half_angle < MAX_HALF_ANGLE)
    return True


def _gives_way(
    region: int,
    site: _Site,
    sweep: Revolution,
    lost: Mask,
    kept: Mask,
    label: Labels,
    fits: Fits,
    options: RegionOptions,
) -> bool:
    """Whether a region is a crumb of what was grown, and no plane across the axis."""
    members = label == region
    if np.count_nonzero(members) > options.max_pruned_patches:
        return False
    surface = fits[region].surface
    if (
        fits[region].is_accepted
        and isinstance(surface, Plane)
        and abs(float(surface.normal @ sweep.axis)) > np.cos(_MAX_TILT)
    ):
        return False
    own = lost & (site.owner == region)
    is_on = np.count_nonzero(kept & own) > _SHARED * np.count_nonzero(own)
    return bool(is_on and site.near[members].mean() > _WITHIN)


def _assign(
    label: Labels,
    fits: Fits,
    ring: _Ring,
    site: _Site,
    evidence: Evidence,
    options: RegionOptions,
) -> None:
    """Give patches to the ring or the larger faces, as neighbours together find cheapest."""
    field = np.flatnonzero(ring.field)
    regions = [*site.larger, site.crumb]
    costs = np.stack(
        [Claim(fits[r], evidence, options).patch_costs(ring.field)[field] for r in regions],
        axis=1,
    )
    label[field] = np.array(regions)[cheapest_together(costs, field, evidence.graph)]
