"""Rounds that go on where their wall bends.

The round between a floor and a wall goes on round the corner of the wall: along a plane it is a
cylinder, along a cylinder a torus. The piece on a short wall is no wider than long, and what the
rounds at its ends leave of it passes for a cone, a sphere or anything else. But the ball that
rolls there is that of the rounds beside it, and where it goes the wall tells: nothing is unknown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.residual import clipped, rms, rms_limit
from crispline.net.graph import components
from crispline.options import FitOptions, RegionOptions
from crispline.region.claim import Claim
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.narrow.rounds import ball_radius
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane, Torus
from crispline.surface.base import Array, unit

Fits = Mapping[int, RegionFit]
Mask = NDArray[np.bool_]

_MAX_TILT = np.radians(3.0)  # of what counts as along or across a floor
_ALIKE = 0.15  # by which radii of one ball may differ, and its height be off its radius
_NEAR = 0.5  # of patches to the round that takes them, spacings
_MAX_TURN = np.radians(35.0)  # of their normals from its own
_TOUCH = 2  # rings over which the floor and the wall are beside the round
_LEAST_MAJOR = 0.5  # of a torus that is no ball, spacings
_LOST = 2.0  # misfit of a patch that noise hardly gives to one in its own region
_SHARED = 0.5  # of the patches of a crumb that must be in the place of the round


@dataclass(frozen=True)
class _Ball:
    """What rolls along a floor, inside (``side`` -1) or outside of the part.

    Attributes
    ----------
    floor : label of the plane.
    side : of the floor on which the ball is, outside positive.
    radius : that of the rounds it has left, the larger counting more.
    rounds : labels of these.
    """

    floor: int
    side: float
    radius: float
    rounds: tuple[int, ...]


def with_turns(
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
    fit_options: FitOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the rounds that known ones become where their wall is a cylinder.

    Such a round is a torus about the wall's axis. It is put in place if it leaves nothing but
    noise at the points where it must be, and explains them better than what is there.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label, graph = label.copy(), evidence.graph
    turns: dict[int, RegionFit] = {}
    for ball in _balls(label, fits, graph):
        for wall in _walls(ball, label, fits):
            surface = _torus(ball, fits[ball.floor], fits[wall])
            if surface is None:
                continue
            place = _place(surface, ball, wall, label, fits, graph)
            known = {**fits, **turns}
            if not place.any() or _is_alone(ball, place, label):
                continue
            beside = (ball.floor, wall)
            taken, lost, gain = _taken(surface, place, beside, label, known, evidence, options)
            patches = np.flatnonzero(lost)
            if len(patches) < options.min_patches or gain <= 0.0:
                continue
            if not _is_borne(surface, patches, evidence, fit_options):
                continue
            name = int(label.max()) + 1
            label[taken] = name
            turns[name] = held_fit(surface, np.flatnonzero(taken), evidence)
    present = np.unique(label)
    return label, {name: fit for name, fit in turns.items() if name in present}


def _balls(label: Labels, fits: Fits, graph: PatchGraph) -> Iterator[_Ball]:
    """The balls that have left rounds along planes, every one once."""
    sides = np.unique(np.sort(label[graph.pairs], axis=1), axis=0)
    sides = sides[sides[:, 0] != sides[:, 1]]
    size = np.bincount(label)
    rolled: dict[tuple[int, float], list[tuple[float, int, int]]] = {}
    for a, b in np.concatenate([sides, sides[:, ::-1]]).tolist():
        side = _side(fits[a], fits[b])
        if side:
            rolled.setdefault((a, side), []).append((ball_radius(fits[b].surface), int(size[b]), b))
    for (floor, side), rounds in sorted(rolled.items()):
        radii, weights, names = np.array(sorted(rounds)).T
        # One ball's radii lie close together; a gap parts them from those of the next.
        for own in np.split(np.arange(len(radii)), _gaps(radii)):
            half = np.searchsorted(np.cumsum(weights[own]), 0.5 * weights[own].sum())
            left = tuple(map(int, names[own]))
            yield _Ball(floor, side, float(radii[own][half]), left)


def _gaps(radii: Array) -> NDArray[np.int64]:
    """Where sorted radii go up by more than those of one ball."""
    return np.flatnonzero(radii[1:] > (1.0 + _ALIKE) * radii[:-1]) + 1


def _side(floor: RegionFit, rolled: RegionFit) -> float:
    """On which side of a floor the ball is that has left a round beside it; 0 if it is none."""
    surface = rolled.surface
    if not (floor.is_accepted and rolled.is_accepted and isinstance(floor.surface, Plane)):
        return 0.0
    match surface:
        case Cylinder():
            place, tilt = surface.origin, abs(float(surface.axis @ floor.surface.normal))
        case Torus():
            place = surface.centre
            tilt = float(np.linalg.norm(np.cross(surface.axis, floor.surface.normal)))
        case _:
            return 0.0
    height = float(floor.surface.signed_distance(place[None])[0]) * floor.orientation
    side = float(np.sign(height))
    touches = abs(abs(height) - ball_radius(surface)) < _ALIKE * ball_radius(surface)
    return side if touches and tilt < np.sin(_MAX_TILT) and rolled.orientation == -side else 0.0


def _walls(ball: _Ball, label: Labels, fits: Fits) -> list[int]:
    """Labels of the cylinders that stand upright on the floor, the larger regions first."""
    floor = fits[ball.floor].surface
    names, sizes = np.unique(label, return_counts=True)
    return [
        name
        for name in names[np.lexsort((names, -sizes))].tolist()
        if name in fits
        and fits[name].is_accepted
        and isinstance(floor, Plane)
        and isinstance(wall := fits[name].surface, Cylinder)
        and abs(float(wall.axis @ floor.normal)) > np.cos(_MAX_TILT)
    ]


def _torus(ball: _Ball, floor: RegionFit, wall: RegionFit) -> Torus | None:
    """What the ball sweeps along the wall; None if it has no way round."""
    if not (isinstance(floor.surface, Plane) and isinstance(wall.surface, Cylinder)):
        return None
    axis = floor.orientation * floor.surface.normal
    offset = float((floor.surface.origin - wall.surface.origin) @ axis) + ball.side * ball.radius
    centre = wall.surface.origin + offset / float(wall.surface.axis @ axis) * wall.surface.axis
    major = wall.surface.radius + ball.side * wall.orientation * ball.radius
    return None if major < _LEAST_MAJOR else Torus(centre, axis, major, ball.radius)


def _place(
    torus: Torus, ball: _Ball, wall: int, label: Labels, fits: Fits, graph: PatchGraph
) -> Mask:
    """Patches on the part of a torus between the wall and the floor, shape ``(m,)``."""
    feet, normals = torus.project(graph.points)
    radial = graph.points - torus.centre
    radial = unit(radial - (radial @ torus.axis)[:, None] * torus.axis)
    near = np.abs(np.einsum("ij,ij->i", graph.points - feet, normals)) < _NEAR
    near &= -ball.side * (normals @ torus.axis) > 0.0
    near &= -ball.side * fits[wall].orientation * np.einsum("ij,ij->i", normals, radial) > 0.0
    facing = -ball.side * np.einsum("ij,ij->i", normals, graph.normals)
    near &= facing > np.cos(_MAX_TURN)
    piece = components(graph.adjacency, near)
    beside = [graph.rings(label == name, _TOUCH) & near for name in (ball.floor, wall)]
    return np.asarray(near & np.isin(piece, piece[beside[0]]) & np.isin(piece, piece[beside[1]]))


def _taken(
    torus: Torus,
    place: Mask,
    beside: tuple[int, int],
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> tuple[Mask, Mask, float]:
    """Patches for the torus, those that speak for it, and by how much more than a face it explains.

    The first are those of crumbs in its place, and what it explains better of other regions.
    Of the latter noise lets any surface explain some better, so only patches that are clearly
    lost where they are speak for it.
    """
    fit = held_fit(torus, np.flatnonzero(place), evidence)
    cost = Claim(fit, evidence, options).patch_costs(place)
    taken, lost = np.zeros((2, len(label)), dtype=bool)
    gain = -options.face_cost
    names, within = np.unique(label[place], return_counts=True)
    for name, count in zip(names.tolist(), within.tolist(), strict=True):
        own = place & (label == name)
        before = Claim(fits[name], evidence, options).patch_costs(own)
        is_crumb = name not in beside and count > _SHARED * np.count_nonzero(label == name)
        own &= is_crumb | (cost < before)
        taken |= own
        own &= is_crumb | (before > _LOST)
        lost |= own
        gain += float((before - cost)[own].sum())
        if is_crumb:  # it pays for the face that takes its place, and had parameters to fit
            freedom = 0.5 * fits[name].surface.n_parameters * np.log(max(count, 2))
            gain += options.face_cost + float(freedom)
    return taken, lost, gain


def _is_alone(ball: _Ball, place: Mask, label: Labels) -> bool:
    """Whether the ball is known from nothing but what is in the place of the round itself."""
    return all(place[label == name].mean() > _SHARED for name in ball.rounds if name in label)


def _is_borne(
    torus: Torus, patches: NDArray[np.int64], evidence: Evidence, options: FitOptions
) -> bool:
    """Whether the points of patches are no farther from a torus than noise takes them.

    A wall may be misled a little by what it has taken of the round, so residuals may drift.
    """
    fit = held_fit(torus, patches, evidence)
    sigma = max(float(np.median(evidence.patch_noise[patches])), options.sigma_floor)
    return rms(clipped(fit.residuals, sigma, options)) < rms_limit(sigma, options)
