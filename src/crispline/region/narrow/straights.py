"""Straight ends of bent tubes and rounds, which the arc covers.

A torus leaves the cylinder that goes on from it along the tangent so slowly that a straight end a
few patches long lies on it but for little more than the noise, and crumbs stand where it does
not. What is known is that the tube goes on straight, so what all points together must tell is
only where: one bend explains the torus, its crumbs, and pieces of the cylinders beside it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crispline.fit.bend import Bend, fit_bend
from crispline.fit.robust import thinned
from crispline.options import RegionOptions
from crispline.region.claim import misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Surface, Torus
from crispline.surface.base import Array

Fits = Mapping[int, RegionFit]

_MAX_POINTS = 4000
_ALIKE = 0.15  # by which the radius of a piece of a straight end may differ
_MAX_TILT = np.sin(np.radians(20.0))  # of its axis out of the plane of the arc
_SHARED = 0.5  # share of the points of a piece that must be beyond the arc
_ALONE = 2.0  # times the cost of a face that a straight end must gain


@dataclass(frozen=True)
class _End:
    """A straight end: the regions that are pieces of it, and what it gains over them."""

    side: int
    pieces: tuple[int, ...]
    gain: float


def with_straights(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels in which bent tubes end straight where the points ask for it, and the surfaces.

    The straight ends are cylinders exactly tangent to the torus. An end must explain the points
    better than the torus and the pieces do, each of these a face, by what two faces cost.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label, found = label.copy(), dict(fits)
    bends: dict[int, RegionFit] = {}
    names, sizes = np.unique(label, return_counts=True)
    large = sizes > options.crumb_patches
    for arc in names[large][np.argsort(-sizes[large], kind="stable")].tolist():
        torus = found[arc].surface
        if not isinstance(torus, Torus) or not found[arc].is_accepted or arc in bends:
            continue
        bent = _bent(arc, label, found, evidence, options)
        if bent is None:
            continue
        bend, ends = bent
        surfaces: dict[int, Surface] = {arc: bend.torus}
        for end in ends:
            name = int(label.max()) + 1
            own = np.isin(label, (arc, *end.pieces))
            beyond = bend.is_on_straight(evidence.graph.points, end.side)
            label[np.isin(label, end.pieces)] = arc
            label[own & beyond] = name
            surfaces[name] = bend.straight(end.side)
        for name, surface in surfaces.items():
            fit = held_fit(surface, np.flatnonzero(label == name), evidence)
            found[name] = bends[name] = fit
    return label, bends


def _bent(
    arc: int, label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Bend, tuple[_End, ...]] | None:
    """The bend that a torus is the arc of, and those of its straight ends that pay."""
    pieces = _pieces(arc, label, fits, evidence.graph, options)
    owner = label[evidence.patch]
    torus = fits[arc].surface
    assert isinstance(torus, Torus)
    while True:
        rows = np.flatnonzero(np.isin(owner, (arc, *pieces)))
        kept = rows[thinned(len(rows), _MAX_POINTS)]
        noise = np.maximum(evidence.noise[rows], options.swallowed_floor)
        bend = fit_bend(evidence.points[kept], float(np.median(noise)), torus)
        if bend is None:
            return None
        points, own = evidence.points[rows], owner[rows]
        known = misfit(_distances(points, own, fits), noise)
        beyond = [bend.is_on_straight(points, side) for side in (0, 1)]
        straight = [misfit(bend.straight(side).signed_distance(points), noise) for side in (0, 1)]
        side_of = {
            piece: side
            for piece in pieces
            for side in (0, 1)
            if (beyond[side] & (own == piece)).sum() > _SHARED * (own == piece).sum()
            and (straight[side] - known)[own == piece].sum() < options.face_cost
        }
        if len(side_of) == len(pieces):
            break
        pieces = sorted(side_of)
    ends = []
    for side in (0, 1):
        here = tuple(piece for piece in pieces if side_of[piece] == side)
        covered = np.isin(own, here) | ((own == arc) & beyond[side])
        gain = float((known - straight[side])[covered].sum()) + len(here) * options.face_cost
        if gain > _ALONE * options.face_cost:
            ends.append(_End(side, here, gain))
    return (bend, tuple(ends)) if ends else None


def _pieces(
    arc: int, label: Labels, fits: Fits, graph: PatchGraph, options: RegionOptions
) -> list[int]:
    """Crumbs beside a torus, and cylinders that may go on from it; crumbs beside these too."""
    torus, size = fits[arc].surface, np.bincount(label)
    assert isinstance(torus, Torus)
    found = {arc}
    while True:
        beside = np.unique(label[graph.rings(np.isin(label, list(found)), 1)]).tolist()
        new = {
            region
            for region in beside
            if region not in found
            and (size[region] <= options.crumb_patches or _may_go_on(torus, fits[region]))
        }
        if not new:
            return sorted(found - {arc})
        found |= new


def _may_go_on(torus: Torus, fit: RegionFit) -> bool:
    """Whether a region is a cylinder as wide as a torus, and along its arc."""
    surface = fit.surface
    return (
        isinstance(surface, Cylinder)
        and abs(surface.radius - torus.minor_radius) < _ALIKE * torus.minor_radius
        and abs(float(surface.axis @ torus.axis)) < _MAX_TILT
    )


def _distances(points: Array, owner: Labels, fits: Fits) -> Array:
    """Of points from the surfaces of their own regions, shape ``(n,)``."""
    distance = np.empty(len(points))
    for region in np.unique(owner).tolist():
        own = owner == region
        distance[own] = fits[region].surface.signed_distance(points[own])
    return distance
