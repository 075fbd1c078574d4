"""Walls of windows and slots through thin plates.

Between the two sides of a plate the wall of an opening is a strip a few patches wide. Such a
strip hardly tells how it leans, and where it turns a corner its pieces stay one region that no
surface explains, or that the two sides share between them. But it stands upright on the plate:
seen along the plate's normal its points lie on a line, and after a corner on another one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from crispline.fit.frame import frame_about
from crispline.fit.residual import rms
from crispline.fit.swept import Translation, fit_line
from crispline.fit.verdict import is_pure_noise
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.claim import Claim
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Plane, unit
from crispline.surface.base import Array

Fits = Mapping[int, RegionFit]
Mask = NDArray[np.bool_]

_MAX_TILT = np.radians(3.0)  # between the two sides of a plate
_THICKEST = 6.0  # spacings; higher walls tell enough of themselves
_BESIDE = 0.5  # share of a wall's border that is with the two sides
_MARGIN = 0.8  # points so near to either side may be its own, spacings
_MIN_POINTS = 6
_MIN_PATCHES = 4
_AROUND = 2  # rings of patches about a border of the two sides, where a wall may be
_ALONG = 0.8  # cosine to the plate's normal, of patches of its walls and their rounded rims
_MAX_TURN = np.cos(np.radians(20.0))  # of the normal from patch to patch on one piece
_ROUNDS = 3


def with_openings(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with a region for each plane wall of an opening, and these walls upright.

    A wall that no surface explains is cut where it turns, if its pieces explain the points by more
    than the faces cost. A plane wall stands upright if its points bear it.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    found: dict[int, RegionFit] = {}
    for wall, sides in _walls(label, fits, evidence, options):
        own = label == wall
        if not fits[wall].is_accepted:
            before = _cost(fits[wall], own, evidence, options)
            for piece, fit in _pieces(own, before - options.face_cost, sides, evidence, options):
                name = wall if wall not in found else int(label.max()) + 1
                label[piece] = name
                found[name] = fit
        elif isinstance(fits[wall].surface, Plane):
            upright = _upright(own, sides, evidence)
            if upright is not None and _is_noise(upright, evidence, options):
                found[wall] = upright
    for own, pair, sides in list(_shared(label, fits, evidence)):
        before = sum(_cost(fits[side], own & (label == side), evidence, options) for side in pair)
        for piece, fit in _pieces(own, before, sides, evidence, options):
            name = int(label.max()) + 1
            label[piece] = name
            found[name] = fit
    return label, found


def _walls(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> Iterator[tuple[int, tuple[Plane, Plane]]]:
    """Small regions between the two sides of a plate, and these."""
    ends = np.sort(label[evidence.graph.pairs], axis=1)
    borders, lengths = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0, return_counts=True)
    size = np.bincount(label)
    for wall in np.flatnonzero((size > 0) & (size <= options.max_pruned_patches)).tolist():
        own = (borders == wall).any(axis=1)
        beside, sides = borders[own].sum(axis=1) - wall, lengths[own]
        order = np.argsort(-sides, kind="stable")[:2]
        if len(order) < 2 or sides[order].sum() < _BESIDE * sides.sum():
            continue
        sides_of_plate = _plate(*(fits[int(beside[k])] for k in order))
        if sides_of_plate is not None:
            yield wall, sides_of_plate


def _shared(
    label: Labels, fits: Fits, evidence: Evidence
) -> Iterator[tuple[Mask, tuple[int, int], tuple[Plane, Plane]]]:
    """Patches of the two sides of a plate that face along it, where the two share a border."""
    graph = evidence.graph
    borders = Borders.of(label, graph)
    for first, second in borders.regions.tolist():
        if first not in fits or second not in fits:
            continue  # a wall that has just been cut
        sides = _plate(fits[first], fits[second])
        if sides is None:
            continue
        touching = np.zeros(len(label), dtype=bool)
        touching[graph.pairs[borders.sides(first, second)].ravel()] = True
        near = graph.rings(touching, _AROUND) & np.isin(label, (first, second))
        near &= np.abs(graph.normals @ sides[0].normal) < _ALONG
        piece = components(graph.adjacency, near)
        for name in np.unique(piece[near & touching]).tolist():
            yield near & (piece == name), (first, second), sides


def _plate(first: RegionFit, second: RegionFit) -> tuple[Plane, Plane] | None:
    """Two planes that face away from each other, a few spacings apart; else None."""
    one, other = first.surface, second.surface
    if not (isinstance(one, Plane) and isinstance(other, Plane)):
        return None
    facing = first.orientation * second.orientation * float(one.normal @ other.normal)
    depth = first.orientation * float((one.origin - other.origin) @ one.normal)
    is_plate = facing < -np.cos(_MAX_TILT) and 0.0 < depth < _THICKEST
    return (one, other) if is_plate and first.is_accepted and second.is_accepted else None


def _cost(fit: RegionFit, own: Mask, evidence: Evidence, options: RegionOptions) -> float:
    return float(Claim(fit, evidence, options).patch_costs(own)[own].sum())


def _upright(own: Mask, sides: tuple[Plane, Plane], evidence: Evidence) -> RegionFit | None:
    """The plane through the points of some patches that stands on both sides of a plate."""
    graph, rows = evidence.graph, own[evidence.patch]
    inner = _inner(evidence.points[rows], sides)
    if len(inner) < _MIN_POINTS:  # the net is closed over a place with few points
        inner = _inner(graph.points[own], sides)
    if len(inner) < _MIN_POINTS:
        return None
    sigma = float(np.median(evidence.noise))
    sweep = Translation(sides[0].normal)
    line = fit_line(sweep.flattened(inner), sigma)
    if line is None:
        return None
    return held_fit(sweep.surface(line), np.flatnonzero(own), evidence)


def _inner(points: Array, sides: tuple[Plane, Plane]) -> Array:
    """Points of a wall that neither side of the plate may claim."""
    away = np.min([np.abs(side.signed_distance(points)) for side in sides], axis=0)
    return np.asarray(points[away > _MARGIN])


def _is_noise(fit: RegionFit, evidence: Evidence, options: RegionOptions) -> bool:
    """Whether a wall leaves nothing but noise in its points, rounded as the net is at its rim."""
    sigma = max(float(np.median(evidence.noise)), options.swallowed_floor)
    middle = np.abs(fit.residuals) < np.quantile(np.abs(fit.residuals), 0.9)
    return is_pure_noise(rms(fit.residuals[middle]), int(middle.sum()), sigma)


def _pieces(
    own: Mask, before: float, sides: tuple[Plane, Plane], evidence: Evidence, options: RegionOptions
) -> list[tuple[Labels, RegionFit]]:
    """The patches of a wall by the upright planes that explain them.

    None if these and what the faces cost come to more than ``before``.
    """
    graph = evidence.graph
    flat = unit(graph.normals @ frame_about(sides[0].normal)[:2].T)
    first, second = graph.pairs.T
    turns = np.einsum("ij,ij->i", flat[first], flat[second]) < _MAX_TURN
    straight = graph.adjacency.copy()
    straight[first[turns], second[turns]] = 0.0
    straight[second[turns], first[turns]] = 0.0
    straight.eliminate_zeros()
    piece = components(straight, own)
    members = np.flatnonzero(own)
    names = np.unique(piece[members])
    parts = [own & (piece == name) for name in names]
    for _ in range(_ROUNDS):
        planes = [
            _upright(part, sides, evidence) if part.sum() >= _MIN_PATCHES else None
            for part in parts
        ]
        upright = [plane for plane in planes if plane is not None]
        if not upright:
            return []
        costs = [Claim(plane, evidence, options).patch_costs(own)[members] for plane in upright]
        nearest = np.argmin(costs, axis=0)
        parts = [np.zeros(len(graph), dtype=bool) for _ in upright]
        for index, part in enumerate(parts):
            part[members[nearest == index]] = True
    is_whole = all(part.sum() >= _MIN_PATCHES for part in parts)
    after = float(np.min(costs, axis=0).sum()) + options.face_cost * len(upright)
    if not is_whole or after > before:
        return []
    return [(np.flatnonzero(part), plane) for part, plane in zip(parts, upright, strict=True)]
