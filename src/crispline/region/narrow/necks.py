"""Pieces of one plane that a cylinder which touches it has cut apart.

Near the line in which the two touch noise hides which of them a patch is on, and the shortest
border wins: where the plane narrows to a neck, the cylinder reaches across. But that line is
known far better, from all of their points, and so is it that the pieces are one plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from crispline.fit.plane import fit_plane
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.claim import Claim
from crispline.region.evidence import Evidence
from crispline.region.fitting import fitted_region
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane, Surface, unit

Mask = NDArray[np.bool_]

_MAX_TILT = np.radians(3.0)  # of an axis out of a plane that its cylinder touches
_MAX_GAP = 0.3  # between the two, spacings; between pieces of one plane so much only if ...
_BIAS = 0.2  # ... the noise of their points leaves it open: borders bias a plane by less, spacings
_GAP_SIGMAS = 5.0
_NEAR_SIGMAS = 3.0  # patches farther than this from the plane are not on it
_LEEWAY = 0.5  # of what a face costs


def with_necks(
    label: Labels, fits: Mapping[int, RegionFit], evidence: Evidence, options: RegionOptions
) -> Labels:
    """Labels in which pieces of a plane are one over the neck between them.

    They are if one plane through the pieces and the neck explains all of it hardly worse than
    the surfaces that took these points as they were.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    for first, second, bent in list(_cut_apart(label, fits, evidence)):
        pieces = (label == first) | (label == second)
        if not ((label == first).any() and (label == second).any()):
            continue  # joined to another piece already
        neck = _beyond(label == first, label == bent, fits[first], fits[bent], evidence)
        piece = components(evidence.graph.adjacency, neck | pieces)
        start = np.unique(piece[label == first])
        if not np.isin(piece[label == second], start).any():
            continue
        neck &= np.isin(piece, start)
        both = pieces | neck
        plane = _plane_through(fits[first], both, evidence)
        if plane is None:
            continue
        before = sum(
            _cost(fits[name], part, evidence, options)
            for name, part in ((first, label == first), (second, label == second), (bent, neck))
        )
        if _cost(plane, both, evidence, options) <= before + _LEEWAY * options.face_cost:
            label[both] = first
    return label


def _cut_apart(
    label: Labels, fits: Mapping[int, RegionFit], evidence: Evidence
) -> Iterator[tuple[int, int, int]]:
    """Two pieces of one plane and a cylinder that touches both."""
    ends = np.sort(label[evidence.graph.pairs], axis=1)
    borders = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    size = np.bincount(label)
    for bent, fit in sorted(fits.items()):
        if not (isinstance(fit.surface, Cylinder) and fit.is_accepted):
            continue
        beside = np.setdiff1d(borders[(borders == bent).any(axis=1)], [bent])
        planes = [name for name in beside.tolist() if _touches(fits[name], fit.surface)]
        planes.sort(key=lambda name: (-size[name], name))
        for index, first in enumerate(planes):
            for second in planes[index + 1 :]:
                if _are_one(fits[first], fits[second]):
                    yield first, second, bent


def _touches(fit: RegionFit, cylinder: Cylinder) -> bool:
    """Whether a surface is a plane along a cylinder and touches it."""
    plane = fit.surface
    if not (isinstance(plane, Plane) and fit.is_accepted):
        return False
    height = abs(float((cylinder.origin - plane.origin) @ plane.normal))
    is_along = abs(float(cylinder.axis @ plane.normal)) < np.sin(_MAX_TILT)
    return bool(is_along and abs(height - cylinder.radius) < _MAX_GAP)


def _are_one(first: RegionFit, second: RegionFit) -> bool:
    """Whether each of two planes passes through the points of the other."""
    if first.orientation * second.orientation * _cosine(first.surface, second.surface) < 0.0:
        return False
    if min(len(first.points), len(second.points)) == 0:
        return False
    error = np.hypot(_error(first), _error(second))
    return all(
        abs(float(np.median(one.surface.signed_distance(other.points))))
        < min(_MAX_GAP, _BIAS + _GAP_SIGMAS * error)
        for one, other in ((first, second), (second, first))
    )


def _error(fit: RegionFit) -> float:
    """Standard error of the height of a surface, from its residuals, spacings."""
    return float(np.sqrt(np.mean(np.square(fit.residuals)) / len(fit.residuals)))


def _cosine(first: Surface, second: Surface) -> float:
    if isinstance(first, Plane) and isinstance(second, Plane):
        return float(first.normal @ second.normal)
    return -1.0


def _beyond(
    is_flat: Mask, is_bent: Mask, flat: RegionFit, bent: RegionFit, evidence: Evidence
) -> Mask:
    """Patches of a cylinder on the plane's side of where the two touch, and near the plane."""
    plane, cylinder = flat.surface, bent.surface
    if not (isinstance(plane, Plane) and isinstance(cylinder, Cylinder)):
        return np.zeros_like(is_bent)
    points = evidence.graph.points
    aside = (points - cylinder.origin) @ unit(np.cross(cylinder.axis, plane.normal))
    side = np.sign(np.median(aside[is_flat]))
    near = np.abs(plane.signed_distance(points)) < _NEAR_SIGMAS * evidence.patch_noise
    return np.asarray(is_bent & near & (side * aside > 0.0))


def _plane_through(fit: RegionFit, patches: Mask, evidence: Evidence) -> RegionFit | None:
    """The plane of the points of some patches, on the side of a fit."""
    rows = patches[evidence.patch]
    points, normals = evidence.points[rows], evidence.normals[rows]
    plane = fit_plane(points, normals, float(np.median(evidence.noise[rows])))
    return None if plane is None else fitted_region(plane, points, normals, fit.is_accepted)


def _cost(fit: RegionFit, patches: Mask, evidence: Evidence, options: RegionOptions) -> float:
    return float(Claim(fit, evidence, options).patch_costs(patches)[patches].sum())
