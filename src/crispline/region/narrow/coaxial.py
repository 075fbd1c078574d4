"""Faces about one axis, and where a narrow face may be lost between two of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from crispline.fit.frame import frame_about
from crispline.fit.residual import rms
from crispline.fit.swept import Line, Revolution, fit_line
from crispline.fit.verdict import is_pure_noise
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Cylinder, Plane
from crispline.surface.base import Array

Fits = Mapping[int, RegionFit]

_MAX_TILT = np.radians(3.0)  # between axes that count as one ...
_MAX_OFFSET = 0.5  # ... and between where they stand, spacings
_APART = 1.0  # parallel profiles so far from each other do not touch, spacings
_LOOSE_TILT = np.radians(10.0)  # of an axis that a few points tell
_MIN_POINTS = 10
_BESIDE = 0.8  # share of a crumb's border that is with the two faces about the axis
_ONE_SIDED = 0.2  # a neighbour with less border than this, relative to the other, is none
_MAX_WIDTH = 8.0  # of what stands for a groove, along its profile, spacings
_COVERED = 0.75  # share of the circumference that must have points of a face that goes round
_BIN = 3.0  # length of the pieces of the circumference that are asked, spacings
_ROUND = 0.75  # share of the circumference that a border of two such faces must have, at least


@dataclass(frozen=True)
class Site:
    """Two faces about an axis and what is between them.

    Attributes
    ----------
    sweep : about the axis.
    first, last : labels of the two, which may be one.
    crumb : the region between them; None where they touch.
    lines : profiles of the two.
    """

    sweep: Revolution
    first: int
    last: int
    crumb: int | None
    lines: tuple[Line, Line]


def coaxial_sites(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> Iterator[Site]:
    """Crumbs between faces about an axis, then borders between two such faces."""
    size, graph = np.bincount(label), evidence.graph
    doubtful = {
        name
        for name, fit in fits.items()
        if not _is_explained(fit, float(np.median(evidence.patch_noise[label == name])), options)
    }
    large = set(np.flatnonzero(size > options.max_pruned_patches).tolist())
    known = Borders.of(label, graph)
    borders, sides = known.regions, known.lengths
    for sweep in axes(fits, size, options):
        about = {
            name: line
            for name, fit in fits.items()
            if fit.is_accepted
            and (name in large or name not in doubtful)
            and (line := straight_profile(fit, sweep)) is not None
        }
        for crumb in sorted(doubtful & _narrow(label, size, sweep, graph)):
            own = (borders == crumb).any(axis=1)
            beside = borders[own].sum(axis=1) - crumb
            order = np.argsort(-sides[own], kind="stable")
            names = [name for name in beside[order].tolist() if name in about][:2]
            lengths = [int(sides[own][beside == name].sum()) for name in names]
            # A piece of surface that hangs together with nothing has no border at all.
            if not names or sum(lengths) < _BESIDE * int(sides[own].sum()):
                continue
            if len(names) == 1 or lengths[1] < _ONE_SIDED * lengths[0]:
                names = [names[0], names[0]]
            lines = about[names[0]], about[names[1]]
            yield Site(sweep, names[0], names[1], crumb, lines)
        for (a, b), n_sides in zip(borders.tolist(), sides.tolist(), strict=True):
            if a not in about or b not in about or min(size[a], size[b]) < options.crumb_patches:
                continue
            touching = graph.pairs[known.sides(a, b), 0]
            radius = np.median(sweep.flattened(graph.points[touching])[:, 0])
            if n_sides > _ROUND * 2.0 * np.pi * radius:
                yield Site(sweep, a, b, None, (about[a], about[b]))


def broken_rings(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> dict[int, RegionFit]:
    """Faces about an axis through which those on their two sides touch, though they are parallel.

    As the floor of a counterbore, which is the only one that can be between its wall and the bore.
    """
    known = Borders.of(label, evidence.graph)
    pairs = {(int(a), int(b)) for a, b in known.regions}
    found: dict[int, RegionFit] = {}
    for sweep in axes(fits, np.bincount(label), options):
        about = {
            name: line
            for name, fit in fits.items()
            if fit.is_accepted and (line := straight_profile(fit, sweep)) is not None
        }
        for a, b in sorted(pairs):
            if a not in about or b not in about or not _is_beside(about[a], about[b]):
                continue
            for name in about.keys() - {a, b}:
                touches = {(min(name, side), max(name, side)) for side in (a, b)}
                if touches <= pairs and not _is_along(about[name], about[a]):
                    found[name] = fits[name]
    return dict(sorted(found.items()))


def _is_along(first: Line, second: Line) -> bool:
    return bool(abs(float(first.normal @ second.normal)) > np.cos(_MAX_TILT))


def _is_beside(first: Line, second: Line) -> bool:
    """Whether two lines are parallel and apart."""
    sign = 1.0 if float(first.normal @ second.normal) > 0.0 else -1.0
    return _is_along(first, second) and abs(first.offset - sign * second.offset) > _APART


def _narrow(label: Labels, size: Labels, sweep: Revolution, graph: PatchGraph) -> set[int]:
    """Regions that would be no wider than a groove if they went round the axis."""
    away = sweep.flattened(graph.points)[:, 0]
    radius = np.bincount(label, away, minlength=len(size)) / np.maximum(size, 1)
    is_narrow = (size > 0) & (size * graph.edge_length**2 < _MAX_WIDTH * 2.0 * np.pi * radius)
    return set(np.flatnonzero(is_narrow).tolist())


def _is_explained(fit: RegionFit, noise: float, options: RegionOptions) -> bool:
    """Whether a surface leaves nothing but noise in its points."""
    sigma = max(noise, options.swallowed_floor)
    n_points = len(fit.residuals)
    return n_points > 0 and is_pure_noise(rms(fit.residuals), n_points, sigma)


def axes(fits: Fits, size: Labels, options: RegionOptions) -> Iterator[Revolution]:
    """Axes of the larger faces, each once."""
    known: list[Revolution] = []
    for name in sorted(fits, key=lambda name: (-size[name], name)):
        surface = fits[name].surface
        if size[name] < options.crumb_patches or not fits[name].is_accepted:
            continue
        if not isinstance(surface, Cylinder | Cone):
            continue
        # A chamfer hardly tells its own axis: that of a larger face may do as well for it.
        if all(straight_profile(fits[name], other) is None for other in known):
            origin = surface.origin if isinstance(surface, Cylinder) else surface.apex
            known.append(Revolution(origin, surface.axis))
            yield known[-1]


def is_on_axis(place: Array, direction: Array, sweep: Revolution) -> bool:
    """Whether an axis through a place is that of a sweep."""
    offset = np.cross(place - sweep.origin, sweep.axis)
    cosine = abs(float(direction @ sweep.axis))
    return bool(np.linalg.norm(offset) < _MAX_OFFSET and cosine > np.cos(_MAX_TILT))


def straight_profile(fit: RegionFit, sweep: Revolution) -> Line | None:
    """The line that sweeps a face; None if it is not about the axis, or no line does.

    It is about the axis if its own says so, or if about this one it explains its points as well.
    """
    surface = fit.surface
    match surface:
        case Plane() if abs(float(surface.normal @ sweep.axis)) > np.cos(_MAX_TILT):
            away = float((surface.origin - sweep.origin) @ surface.normal)
            return Line(np.pi / 2.0, away / float(surface.normal @ sweep.axis))
        case Cylinder() if is_on_axis(surface.origin, surface.axis, sweep):
            return Line(0.0, surface.radius)
        case Cone() if is_on_axis(surface.apex, surface.axis, sweep):
            side = float(np.sign(surface.axis @ sweep.axis))
            height = float((surface.apex - sweep.origin) @ sweep.axis)
            rise = side * float(np.sin(surface.half_angle))
            return Line(
                float(np.arctan2(-rise, np.cos(surface.half_angle))),
                -rise * height,
            )
        case Cylinder() | Cone() if abs(float(surface.axis @ sweep.axis)) > np.cos(_LOOSE_TILT):
            return _line_about(fit, sweep)
    return None


def _line_about(fit: RegionFit, sweep: Revolution) -> Line | None:
    """The line that sweeps what its points cannot tell from a face; None if they can."""
    n_points = len(fit.residuals)
    flat, sigma = sweep.flattened(fit.points), rms(fit.residuals)
    line = fit_line(flat, sigma) if n_points > _MIN_POINTS and sigma > 0.0 else None
    if line is None:
        return None
    off = flat @ line.normal - line.offset
    return line if is_pure_noise(rms(off), n_points, sigma) else None


def goes_round(sweep: Revolution, points: Array) -> bool:
    """Whether there are points ``(n, 3)`` all round the axis."""
    if not len(points):
        return False
    x, y = ((points - sweep.origin) @ frame_about(sweep.axis)[:2].T).T
    n_bins = max(int(2.0 * np.pi * float(np.median(np.hypot(x, y))) / _BIN), 6)
    bins = np.floor((np.arctan2(y, x) / (2.0 * np.pi) % 1.0) * n_bins)
    return len(np.unique(bins)) >= _COVERED * n_bins
