"""Ends of narrow bores and pins: what closes a tube that the net closes but no face does.

The floor of a blind hole a few patches across has fewer patches than a seed needs: it stays with
the wall, or floor and wall become some ring together. But a piece of a cylinder cannot go round
its axis at one end only, so the missing face shows in the border of the region. The axis is
known; a line in the half plane of it, fitted to the points off the wall, is a flat floor or a
drill tip.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.frame import frame_about
from crispline.fit.swept import Revolution, fit_line
from crispline.net.graph import components
from crispline.net.halfedge import HalfEdges
from crispline.options import RegionOptions
from crispline.region.claim import Claim
from crispline.region.cleanup import tidy
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Cylinder, Plane, Surface, Torus
from crispline.surface.base import Array

Mask = NDArray[np.bool_]
Fits = Mapping[int, RegionFit]

_OFF = 3.0  # sigmas; points farther from the wall than this are on its end
_MIN_POINTS = 6
_MIN_PATCHES = 3
_RINGS = 2  # of the wall, beside a crumb that is no end
_TIP_REACH = 1.5  # a cone whose tip lies this near to its patches ends there, in edge lengths
_CLEARLY = 8.0  # by which a cone must lower the chi-square more than a plane


@dataclass(frozen=True)
class _Tube:
    """A wall that an end is missing from.

    Attributes
    ----------
    wall : label of the cylinder or cone.
    field : patches that the end is among, shape ``(m,)``.
    axis : of the wall.
    """

    wall: int
    field: Mask
    axis: Revolution


def with_ends(
    label: Labels,
    fits: Fits,
    net_vertices: Array,
    quads: HalfEdges,
    evidence: Evidence,
    options: RegionOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the ends of tubes that go round their axis at one end only, and their surfaces.

    Parameters
    ----------
    label, fits : regions, each in one piece, and the surface of each.
    net_vertices : shape ``(n, 3)``.

    Returns
    -------
    The labels and the surface of each; nothing changes where neither a plane nor a cone closes
    the wall.
    """
    found = dict(fits)
    for region in np.unique(label).tolist():
        tube = _tube(region, label, found, net_vertices, quads, evidence, options)
        if tube is None:
            continue
        wall = found[tube.wall]
        surface = _end(tube, wall.surface, evidence)
        if surface is None:
            continue
        members = _members(tube, surface, wall, evidence, options)
        if len(members) < _MIN_PATCHES:
            continue
        name = int(label.max()) + 1
        trial = np.where(tube.field, tube.wall, label)
        trial[members] = name
        trial = tidy(trial, quads, min(len(members), options.min_patches))
        is_whole = {tube.wall, name} == set(np.unique(trial[tube.field]).tolist())
        own = trial == tube.wall
        if is_whole and _turns(own, tube.axis, net_vertices, quads) == 0:
            label = trial
            found[name] = held_fit(surface, np.flatnonzero(label == name), evidence)
            found[tube.wall] = held_fit(wall.surface, np.flatnonzero(own), evidence)
    return label, {region: found[region] for region in np.unique(label).tolist()}


def _tube(
    region: int,
    label: Labels,
    fits: Fits,
    net_vertices: Array,
    quads: HalfEdges,
    evidence: Evidence,
    options: RegionOptions,
) -> _Tube | None:
    """The tube that a region shows to lack an end; None if it is sound."""
    own, surface = label == region, fits[region].surface
    graph = evidence.graph
    match surface:
        case Cylinder():
            tube = _Tube(region, own, Revolution(surface.origin, surface.axis))
        case Cone():
            reach = _TIP_REACH * graph.edge_length
            if np.linalg.norm(graph.points[own] - surface.apex, axis=1).min() < reach:
                return None
            tube = _Tube(region, own, Revolution(surface.apex, surface.axis))
        case Torus() if np.count_nonzero(own) <= options.crumb_patches:
            beside = np.setdiff1d(label[graph.rings(own, 1)], [region])
            wall = fits[int(beside[0])].surface if len(beside) == 1 else None
            if not isinstance(wall, Cylinder):
                return None
            near = graph.rings(own, _RINGS) & (own | (label == beside[0]))
            tube = _Tube(int(beside[0]), near, Revolution(wall.origin, wall.axis))
        case _:
            return None
    return tube if _turns(own, tube.axis, net_vertices, quads) != 0 else None


def _turns(own: Mask, axis: Revolution, net_vertices: Array, quads: HalfEdges) -> int:
    """How often the border of a region goes round an axis; the ends of a tube cancel out."""
    inside = own[quads.quad]
    rim = inside & ~((quads.twin >= 0) & inside[np.maximum(quads.twin, 0)])
    first, second = frame_about(axis.axis)[:2]
    spokes = net_vertices - axis.origin
    angle = np.arctan2(spokes @ second, spokes @ first)
    step = angle[quads.target[rim]] - angle[quads.origin[rim]]
    return round(float((np.remainder(step + np.pi, 2.0 * np.pi) - np.pi).sum() / (2.0 * np.pi)))


def _end(tube: _Tube, wall: Surface, evidence: Evidence) -> Surface | None:
    """The plane or cone that the points off the wall lie on; None if there are hardly any."""
    rows = np.flatnonzero(tube.field[evidence.patch])
    points, noise = evidence.points[rows], evidence.noise[rows]
    off = np.abs(wall.signed_distance(points)) > _OFF * noise
    if np.count_nonzero(off) < _MIN_POINTS:
        return None
    points, sigma = points[off], float(np.median(noise[off]))
    height = tube.axis.flattened(points)[:, 1]
    middle = float(np.median(height))
    flat = Plane(tube.axis.origin + middle * tube.axis.axis, tube.axis.axis)
    profile = fit_line(tube.axis.flattened(points), sigma)
    leaning = None if profile is None else tube.axis.surface(profile)
    if not isinstance(leaning, Cone):
        return flat
    gain = _misfit(flat, points, sigma) - _misfit(leaning, points, sigma)
    return leaning if gain > _CLEARLY else flat


def _misfit(surface: Surface, points: Array, sigma: float) -> float:
    squared = np.square(surface.signed_distance(points) / sigma)
    return float(np.minimum(squared, _OFF**2).sum())


def _members(
    tube: _Tube, surface: Surface, wall: RegionFit, evidence: Evidence, options: RegionOptions
) -> NDArray[np.int64]:
    """Patches of the end: those nearer to it than to the wall, as far as they hang together."""
    field = np.flatnonzero(tube.field)
    end = held_fit(surface, field, evidence)
    costs = [Claim(fit, evidence, options).patch_costs(tube.field)[field] for fit in (wall, end)]
    own = np.zeros(len(tube.field), dtype=bool)
    own[field[costs[1] < costs[0]]] = True
    piece = components(evidence.graph.adjacency, own)
    if not own.any():
        return np.flatnonzero(own)
    names, sizes = np.unique(piece[own], return_counts=True)
    return np.flatnonzero(own & (piece == names[np.argmax(sizes)]))
