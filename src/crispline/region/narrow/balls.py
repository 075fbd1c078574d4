"""Corners where rounds of one ball meet: a piece of the ball itself.

An eighth of a small sphere tells little of its shape once its rim, where it leaves the cylinders
beside it slowly, is theirs: a cone or torus explains the rest as well. But the axes of the
cylinders meet in the place where the ball has turned from one edge to the next.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from crispline.options import RegionOptions
from crispline.region.claim import misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Sphere
from crispline.surface.base import Array

Fits = Mapping[int, RegionFit]

_ALIKE = 0.05  # by which the radii of rounds of one ball may differ
_OFFSET = 0.5  # by which their axes may miss each other, spacings
_LEAST_VOLUME = 0.3  # of the directions of the axes; three at right angles span 1
_NEAR = 0.5  # of patches to the ball that takes them, spacings


@dataclass(frozen=True)
class _Corner:
    """A ball, and the half spaces of the rounds that end at it.

    Attributes
    ----------
    rounds : labels of the cylinders.
    ball : where they end.
    outward : unit axes of the rounds, leading to the corner, shape ``(3, 3)``.
    """

    rounds: tuple[int, ...]
    ball: Sphere
    outward: Array


def with_balls(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels in which crumbs between rounds of one radius are spheres, and their surfaces.

    The ball must explain the points of the crumb as well as the crumb's own surface does, but
    for less than what a face costs.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label, graph = label.copy(), evidence.graph
    balls: dict[int, RegionFit] = {}
    names, sizes = np.unique(label, return_counts=True)
    for crumb in names[sizes <= options.max_pruned_patches].tolist():
        corner = _corner(crumb, label, fits, graph)
        if corner is None:
            continue
        rows = np.flatnonzero(label[evidence.patch] == crumb)
        noise = np.maximum(evidence.noise[rows], options.swallowed_floor)
        held = misfit(corner.ball.signed_distance(evidence.points[rows]), noise)
        known = misfit(fits[crumb].surface.signed_distance(evidence.points[rows]), noise)
        if held.sum() - known.sum() > options.face_cost:
            continue
        octant = ((graph.points - corner.ball.centre) @ corner.outward.T > 0.0).all(axis=1)
        octant &= np.abs(corner.ball.signed_distance(graph.points)) < _NEAR
        label[octant & np.isin(label, corner.rounds)] = crumb
        balls[crumb] = held_fit(corner.ball, np.flatnonzero(label == crumb), evidence)
    return label, balls


def _corner(crumb: int, label: Labels, fits: Fits, graph: PatchGraph) -> _Corner | None:
    """The corner of three rounds beside a crumb; None if there are no such three."""
    own = label == crumb
    beside = np.setdiff1d(label[graph.rings(own, 1)], [crumb]).tolist()
    rounds = {
        name: surface
        for name in beside
        if fits[name].is_accepted and isinstance(surface := fits[name].surface, Cylinder)
    }
    for names in combinations(rounds, 3):
        three = [rounds[name] for name in names]
        if len({fits[name].orientation for name in names}) > 1:
            continue
        radii = np.array([surface.radius for surface in three])
        axes = np.stack([surface.axis for surface in three])
        if np.ptp(radii) > _ALIKE * radii.mean() or abs(np.linalg.det(axes)) < _LEAST_VOLUME:
            continue
        centre = _meeting(three)
        if max(_offset(surface, centre) for surface in three) > _OFFSET:
            continue
        middles = np.stack([graph.points[label == name].mean(axis=0) for name in names])
        inward = np.sign(np.einsum("ij,ij->i", middles - centre, axes))
        ball = Sphere(centre, float(radii.mean()))
        return _Corner(names, ball, -inward[:, None] * axes)
    return None


def _meeting(rounds: list[Cylinder]) -> Array:
    """The point nearest to all axes, least squares."""
    across = [np.eye(3) - np.outer(surface.axis, surface.axis) for surface in rounds]
    right = sum(m @ surface.origin for m, surface in zip(across, rounds, strict=True))
    return np.asarray(np.linalg.solve(np.sum(across, axis=0), right))


def _offset(surface: Cylinder, point: Array) -> float:
    """Distance of a point from an axis."""
    return float(np.linalg.norm(np.cross(point - surface.origin, surface.axis)))
