"""Grooves and undercuts about an axis: narrow faces that only its half plane shows.

The net rounds off what is as narrow as its sides, so that a groove of three faces comes out as
one torus, an undercut as a cone, and the foot of a chamfer as a part of the shoulder above it.
But the raw points of a ring all fall on a short piece of its profile, where straight lines
stand out that are shorter than a spacing. Faces made from these lines need patches of their
own, a ring for each, whatever the net has made of the place.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.fit.chain import Chain, corner_cost, fit_chain
from crispline.fit.outline import Ray, round_cost
from crispline.fit.swept import Circle, Line
from crispline.net.halfedge import HalfEdges
from crispline.options import RegionOptions
from crispline.region.evidence import Evidence
from crispline.region.fitting import fitted_region
from crispline.region.narrow.coaxial import (
    Fits,
    Site,
    coaxial_sites,
    goes_round,
    is_on_axis,
    straight_profile,
)
from crispline.region.narrow.layers import beside_others, layered
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Torus
from crispline.surface.base import Array

Mask = NDArray[np.bool_]

_AROUND = 5  # rings about a site whose points are looked at
_LOST = 2.0  # sigmas; points so far off both neighbours are on neither
_MIN_LENGTH = 0.5  # of a line of the profile, spacings
_FAR = 0.9  # share of a face's points that are nearer to the other face than its ray points
_SEEN = 0.1  # share of the points near a site that either side must have
_EXPLAINED = 10.0  # by how much another profile must be more likely than the one there is, nats


def with_grooves(
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    quads: HalfEdges,
    options: RegionOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the narrow faces between faces about one axis, and their surfaces.

    One to three faces take the place of a crumb that goes round the axis between the two, or
    come between two that touch, where they make the points likelier by more than what telling
    them costs.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    found: dict[int, RegionFit] = {}
    touched: set[int | None] = set()
    for site in list(coaxial_sites(label, fits, evidence, options)):
        if touched & {site.first, site.last, site.crumb}:
            continue
        near = _near(site, label, evidence.graph)
        rows = np.flatnonzero(near[evidence.patch])
        points, owner = evidence.points[rows], label[evidence.patch[rows]]
        if site.crumb is not None and not goes_round(site.sweep, points[owner == site.crumb]):
            continue
        flat = site.sweep.flattened(points)
        sigma = max(float(np.median(evidence.noise[rows])), options.swallowed_floor)
        chain = _chain(site, fits, flat, owner, sigma, options)
        if chain is None:
            continue
        parts = [points[chain.part == index + 1] for index in range(len(chain.lines))]
        if not all(goes_round(site.sweep, part) for part in parts):
            continue
        faces = [site.sweep.surface(line) for line in chain.lines]
        if any(face is None for face in faces):
            continue
        layer = _layers(site, chain, near, rows, label, evidence, quads)
        if layer is None:
            continue
        for index, face in enumerate(faces):
            name = int(label.max()) + 1
            label[layer == index + 1] = name
            own = rows[chain.part == index + 1]
            if face is not None:
                found[name] = fitted_region(face, evidence.points[own], evidence.normals[own], True)
        label[layer == 0] = site.first
        label[layer == len(faces) + 1] = site.last
        touched |= {site.crumb} - {None}
    return label, found


def _near(site: Site, label: Labels, graph: PatchGraph) -> Mask:
    """Patches of the site's regions along the crumb or the border."""
    if site.crumb is None:
        ends = np.sort(label[graph.pairs], axis=1)
        touching = (ends == sorted((site.first, site.last))).all(axis=1)
        along = np.zeros(len(label), dtype=bool)
        along[graph.pairs[touching].ravel()] = True
    else:
        along = label == site.crumb
    regions = [name for name in (site.first, site.last, site.crumb) if name is not None]
    return graph.rings(along, _AROUND) & np.isin(label, regions)


def _chain(
    site: Site, fits: Fits, flat: Array, owner: Labels, sigma: float, options: RegionOptions
) -> Chain | None:
    """The profile between the two faces; None if there is none better than the present one."""
    rays = _rays(site, flat, owner)
    if rays is None:
        return None
    off = [np.abs(flat @ ray.line.normal - ray.line.offset) for ray in rays]
    is_lost = np.min(off, axis=0) > _LOST * sigma
    chain = fit_chain(flat, is_lost, rays, sigma, _MIN_LENGTH)
    if chain is None:
        return None
    bare = corner_cost(flat, rays, sigma)
    if chain.cost > bare - options.face_cost * len(chain.lines):
        return None
    if site.crumb is not None:
        fit = fits[site.crumb]
        surface = fit.surface
        if (
            len(chain.lines) == 1
            and straight_profile(fit, site.sweep) is not None
            and fit.is_accepted
        ):
            return None
        if isinstance(surface, Torus) and is_on_axis(surface.centre, surface.axis, site.sweep):
            height = float((surface.centre - site.sweep.origin) @ site.sweep.axis)
            circle = Circle(np.array([surface.major_radius, height]), surface.minor_radius)
            if chain.cost > round_cost(flat, circle, rays, sigma) - _EXPLAINED:
                return None
    return chain


def _rays(site: Site, flat: Array, owner: Labels) -> tuple[Ray, Ray] | None:
    """The two faces on the sides of their own points; of one face, its sides of the crumb.

    None if the face is on one side of the crumb only, as round the bottom of a hole.
    """
    sides = [owner == site.first, owner == site.last]
    if site.first == site.last:
        line = site.lines[0]
        along = flat @ np.array([-line.normal[1], line.normal[0]])
        is_before = along < np.median(along[owner == site.crumb])
        sides = [sides[0] & is_before, sides[1] & ~is_before]
    if min(side.mean() for side in sides) < _SEEN:
        return None
    seen = flat[sides[0]], flat[sides[1]]
    return _ray(site.lines[0], *seen), _ray(site.lines[1], *seen[::-1])


def _ray(line: Line, own: Array, others: Array) -> Ray:
    """A face on the side of its points that are farthest from those of the other face."""
    heading = np.array([-line.normal[1], line.normal[0]])
    away = own @ heading - float(np.median(others @ heading))
    far = np.quantile(away, _FAR if np.median(away) > 0.0 else 1.0 - _FAR)
    return Ray(line, own[np.argmin(np.abs(away - far))])


def _layers(
    site: Site,
    chain: Chain,
    near: Mask,
    rows: Labels,
    label: Labels,
    evidence: Evidence,
    quads: HalfEdges,
) -> Labels | None:
    """Part of the profile that every patch near the site belongs to, -1 elsewhere.

    A patch goes where most of its points do, or else its centre.
    """
    patches = np.flatnonzero(near)
    wanted = np.full(len(label), -1)
    flat = site.sweep.flattened(evidence.graph.points[patches])
    wanted[patches] = chain.nearest_part(flat)
    votes = np.zeros((len(label), len(chain.lines) + 2))
    np.add.at(votes, (evidence.patch[rows], chain.part), 1.0)
    is_told = near & (votes.sum(axis=1) > 0.0)
    wanted[is_told] = np.argmax(votes[is_told], axis=1)
    if site.first != site.last:  # labels tell the two sides apart where no point is between
        inner = (wanted > 0) & (wanted <= len(chain.lines))
        wanted[near & ~inner & (label == site.first)] = 0
        wanted[near & ~inner & (label == site.last)] = len(chain.lines) + 1
        # A ring does not reach what is beside the two faces.
        at_end = beside_others(near, quads)
        wanted[at_end & (label == site.first)] = 0
        wanted[at_end & (label == site.last)] = len(chain.lines) + 1
    return layered(wanted, len(chain.lines), quads)
