"""Low steps: where a plane and a face along it share a border, or nearly, but do not meet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.swept import Translation
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane
from crispline.surface.base import Array

Fits = Mapping[int, RegionFit]
Mask = NDArray[np.bool_]

_MAX_TILT = np.radians(3.0)  # between directions that count as parallel
_MAX_LEAN = np.radians(15.0)  # of a curved face from the plane, along the border that they share
_LOWEST = 0.1  # quantile of the height that must be a step: at some places the border is ragged
_BESIDE = 0.7  # share of a crumb's border that is with the two planes


@dataclass(frozen=True)
class LowStep:
    """A plane and another face that touch but do not meet.

    Attributes
    ----------
    planes, crumbs : labels of the two and of what else stands between them.
    sweep : along the plane's normal.
    centres : of round faces beside them with axes along it, across it, each of shape ``(2,)``.
    touching : patches with a side between the planes, shape ``(m,)``.
    must_be : whether these are so many that there is a wall; else crumbs may be the better one.
    """

    planes: tuple[int, int]
    crumbs: tuple[int, ...]
    sweep: Translation
    centres: tuple[Array, ...]
    touching: Mask
    must_be: bool


def low_steps(
    label: Labels,
    fits: Fits,
    graph: PatchGraph,
    options: RegionOptions,
) -> Iterator[LowStep]:
    """Every plane and face of different height with a border, or crumbs that lean between."""
    known = Borders.of(label, graph)
    borders, lengths = known.regions, known.lengths
    size = np.bincount(label)
    n_sides = dict(zip(map(tuple, borders.tolist()), lengths.tolist(), strict=True))
    between = _crumbs_between(size, borders, lengths, options)
    for a, b in sorted(n_sides.keys() | between.keys()):
        crumbs = tuple(between.get((a, b), ()))
        is_long = n_sides.get((a, b), 0) >= options.step_sides
        if not (is_long or crumbs) or min(size[a], size[b]) < options.crumb_patches:
            continue
        touching = graph.pairs[known.sides(a, b)]
        places = graph.points[touching].mean(axis=1)
        if not is_long:
            places = graph.points[np.isin(label, crumbs)]
        direction = _rise(fits[a], fits[b], places, options)
        if direction is None:
            continue
        if not is_long and all(_is_upright(fits[crumb], direction) for crumb in crumbs):
            continue
        beside = np.setdiff1d(borders[np.isin(borders, (a, b)).any(axis=1)], (a, b)).tolist()
        sweep = Translation(direction)
        centres = tuple(
            sweep.flattened(axis[None])[0]
            for region in beside
            if (axis := _upright_axis(fits[region], sweep.direction)) is not None
        )
        is_touching = np.zeros(len(label), dtype=bool)
        is_touching[touching.ravel()] = True
        yield LowStep((a, b), crumbs, sweep, centres, is_touching, is_long)


def _crumbs_between(
    size: Labels, borders: Labels, lengths: Labels, options: RegionOptions
) -> dict[tuple[int, int], list[int]]:
    """Small regions that touch two others and little else, by these two in ascending order."""
    found: dict[tuple[int, int], list[int]] = {}
    for region in np.flatnonzero((size > 0) & (size < options.crumb_patches)).tolist():
        own = (borders == region).any(axis=1)
        beside, sides = borders[own].sum(axis=1) - region, lengths[own]
        most = np.argsort(-sides, kind="stable")[:2]
        if len(most) == 2 and sides[most].sum() > _BESIDE * sides.sum():
            first, second = sorted(beside[most].tolist())
            found.setdefault((first, second), []).append(region)
    return found


def _rise(
    first: RegionFit, second: RegionFit, places: Array, options: RegionOptions
) -> Array | None:
    """The direction of a low wall between two faces along their border; None if there is none.

    Parameters
    ----------
    places : along the border, shape ``(n, 3)``.
    """
    if not (first.is_accepted and second.is_accepted):
        return None
    normals = [fit.surface.normal for fit in (first, second) if isinstance(fit.surface, Plane)]
    if not normals:
        return None
    feet, facing = zip(*(fit.surface.project(places) for fit in (first, second)), strict=True)
    lean = _MAX_TILT if len(normals) == 2 else _MAX_LEAN
    outward = first.orientation * second.orientation * np.einsum("ij,ij->i", *facing)
    if np.min(outward) < np.cos(lean):
        return None
    height = np.abs((feet[0] - feet[1]) @ normals[0])
    is_low = np.median(height) < options.max_step_height
    return normals[0] if is_low and np.quantile(height, _LOWEST) > options.step_height else None


def _is_upright(fit: RegionFit, direction: Array) -> bool:
    """Whether a region is a wall along a direction."""
    if isinstance(fit.surface, Plane) and fit.is_accepted:
        return bool(abs(fit.surface.normal @ direction) < np.sin(_MAX_TILT))
    return _upright_axis(fit, direction) is not None


def _upright_axis(fit: RegionFit, direction: Array) -> Array | None:
    """A point on the axis of a cylinder along a direction; None for any other surface."""
    surface = fit.surface
    if not (isinstance(surface, Cylinder) and fit.is_accepted):
        return None
    is_upright = abs(float(surface.axis @ direction)) > np.cos(_MAX_TILT)
    return surface.origin if is_upright else None
