"""Walls of low steps: the faces that must be between a plane and what shares a border with it.

Parallel planes do not meet, nor do a plane and a curved face that runs along beside it. Where the
regions of two do all the same, the wall between them is a row or two of patches high, which no
seed fits into, or what is left of it are crumbs that lean any way. But its direction is known,
the normal of the plane, and where it stands the border tells: a line or a circle across that
direction holds it well.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crispline.fit.choose import PrimitiveFit
from crispline.fit.swept import (
    Profile,
    ProfileFit,
    Translation,
    concentric,
    fit_circle,
    fit_line,
)
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.claim import Claim
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.grow import Ground
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane, Surface
from crispline.surface.base import Array

_MAX_TILT = np.radians(3.0)  # between directions that count as parallel
_MAX_LEAN = np.radians(15.0)  # of a curved face from the plane, along the border that they share
_LOWEST = 0.1  # quantile of the height that must be a step: at some places the border is ragged
_RAGGED = 0.35  # scatter of the patches along a border about the true one, spacings
_BESIDE = 0.7  # share of a crumb's border that is with the two planes
_CLEARLY_MORE = 1.05  # worth of a curve with more parameters over that of one with fewer ...
_ONE_PATCH = 1.0  # ... beyond what one patch adds by chance
_KEPT = 0.8  # share of the patches along a border that its wall must explain
_GROWTH_STEPS = 6
_RINGS = 2  # patches so near to a wall may be its own
_ANY_NORMAL = -2.0  # the net rounds a low wall


@dataclass(frozen=True)
class _Step:
    """A plane and another face that touch but do not meet.

    Attributes
    ----------
    planes, crumbs : labels of the two and of what else stands between them.
    sweep : along the plane's normal.
    centres : of round faces beside them with axes along it, across it, each of shape ``(2,)``.
    touching : patches with a side between the planes, shape ``(m,)``.
    """

    planes: tuple[int, int]
    crumbs: tuple[int, ...]
    sweep: Translation
    centres: tuple[Array, ...]
    touching: NDArray[np.bool_]


def with_step_walls(
    label: Labels,
    fits: Mapping[int, RegionFit],
    evidence: Evidence,
    options: RegionOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the walls between planes and faces along them, and the surfaces of these walls.

    Crumbs that stand between the two give way where a wall passes. Pieces of border that
    neither a line nor a circle explains stay as they are.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    walls: dict[int, RegionFit] = {}
    for step in _steps(label, fits, evidence.graph, options):
        for surface, patches in _walls(step, label, evidence.graph, options):
            name = int(label.max()) + 1
            walls[name] = held_fit(surface, patches, evidence)
            parts = {**{plane: fits[plane] for plane in step.planes}, name: walls[name]}
            near = np.zeros(len(label), dtype=bool)
            near[patches] = True
            near = evidence.graph.rings(near, _RINGS)
            near &= np.isin(label, (*step.planes, *step.crumbs))
            costs = [
                Claim(fit, evidence, options).patch_costs(near)[near] for fit in parts.values()
            ]
            label[near] = np.array(list(parts))[np.argmin(costs, axis=0)]
            label[patches] = name  # all of them: no gap may remain
    return label, walls


def _steps(
    label: Labels,
    fits: Mapping[int, RegionFit],
    graph: PatchGraph,
    options: RegionOptions,
) -> Iterator[_Step]:
    """Every plane and face of different height with a border."""
    ends = np.sort(label[graph.pairs], axis=1)
    is_border = ends[:, 0] != ends[:, 1]
    borders, lengths = np.unique(ends[is_border], axis=0, return_counts=True)
    size = np.bincount(label)
    for (a, b), n_sides in zip(borders.tolist(), lengths.tolist(), strict=True):
        if n_sides < options.step_sides or min(size[a], size[b]) < options.crumb_patches:
            continue
        sides = graph.pairs[(ends == (a, b)).all(axis=1)]
        direction = _rise(fits[a], fits[b], graph.points[sides].mean(axis=1), options)
        if direction is None:
            continue
        beside = np.setdiff1d(borders[np.isin(borders, (a, b)).any(axis=1)], (a, b)).tolist()
        crumbs = tuple(
            region
            for region in beside
            if size[region] < options.crumb_patches
            and _is_between(region, (a, b), borders, lengths)
        )
        sweep = Translation(direction)
        centres = tuple(
            sweep.flattened(axis[None])[0]
            for region in beside
            if (axis := _upright_axis(fits[region], sweep.direction)) is not None
        )
        touching = np.zeros(len(label), dtype=bool)
        touching[sides.ravel()] = True
        yield _Step((a, b), crumbs, sweep, centres, touching)


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


def _is_between(region: int, planes: tuple[int, int], borders: Labels, lengths: Labels) -> bool:
    """Whether a region touches both planes and little else."""
    own = (borders == region).any(axis=1)
    sides = [int(lengths[own & (borders == plane).any(axis=1)].sum()) for plane in planes]
    return min(sides) > 0 and sum(sides) > _BESIDE * int(lengths[own].sum())


def _upright_axis(fit: RegionFit, direction: Array) -> Array | None:
    """A point on the axis of a cylinder along a direction; None for any other surface."""
    surface = fit.surface
    if not (isinstance(surface, Cylinder) and fit.is_accepted):
        return None
    is_upright = abs(float(surface.axis @ direction)) > np.cos(_MAX_TILT)
    return surface.origin if is_upright else None


def _walls(
    step: _Step, label: Labels, graph: PatchGraph, options: RegionOptions
) -> Iterator[tuple[Surface, Labels]]:
    """A wall for every piece of the border, and its patches."""
    along = step.touching | np.isin(label, step.crumbs)
    piece = components(graph.adjacency, along)
    kinds = [*(concentric(centre) for centre in step.centres), fit_line, fit_circle]
    for name in np.unique(piece[step.touching]):
        members = np.flatnonzero(along & (piece == name))
        ground = Ground(
            graph.points[members],
            graph.normals[members],
            csr_array(graph.adjacency[members][:, members]),
            np.ones(len(members), dtype=bool),
            _RAGGED,
            _ANY_NORMAL,
            _KEPT,
            _GROWTH_STEPS,
        )
        growths = [
            growth
            for kind in kinds
            if (growth := ground.grown(_swept(kind, step.sweep), np.arange(len(members))))
        ]
        most = max((growth.worth for growth in growths), default=0.0)
        for growth in growths:
            # The first is the one of fewest parameters: what a few patches add is chance.
            if _CLEARLY_MORE * growth.worth + _ONE_PATCH >= most:
                if len(members) >= options.min_patches:
                    yield growth.surface, members
                break


def _swept(fit_profile: ProfileFit, sweep: Translation) -> PrimitiveFit:
    """The fit of a profile as that of a surface."""

    def fit(
        points: Array,
        _normals: Array,
        sigma: float,
        _start: Any = None,
        _draft: bool = False,
        /,
    ) -> Surface | None:
        profile: Profile | None = fit_profile(sweep.flattened(points), sigma)
        return None if profile is None else sweep.surface(profile)

    return fit
