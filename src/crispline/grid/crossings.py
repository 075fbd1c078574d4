"""Step four on a grid: where a feature crosses the links between neighbouring points."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.grid.assign import depth
from crispline.grid.lattice import Mask
from crispline.grid.localfit import Sides, Support
from crispline.options import SharpenOptions
from crispline.surface.base import Array
from crispline.surface.intersect import newton_step

Index = NDArray[np.int64]
_MAX_STEPS = 12
_CONVERGED = 1e-13


@dataclass(frozen=True)
class Crossings:
    """Links between neighbouring points that a sharp edge crosses.

    Attributes
    ----------
    start : row and column of the first point of each link, shape ``(k, 2)``.
    axis : 0 if the link runs to the next row, 1 to the next column, ``(k,)``.
    share : where the edge crosses it, 0 at the first point, 1 at the next, ``(k,)``.
    points : located points of the edge, spacings, ``(k, 3)``.
    sides : the side of the first and of the other point, ``(k, 2)``.
    normals : unit normals of both sides there, ``(k, 2, 3)``.
    """

    start: Index
    axis: Index
    share: Array
    points: Array
    sides: Index
    normals: Array

    def __getitem__(self, rows: Index | Mask) -> Crossings:
        return Crossings(
            self.start[rows],
            self.axis[rows],
            self.share[rows],
            self.points[rows],
            self.sides[rows],
            self.normals[rows],
        )

    @property
    def at(self) -> Array:
        """Row and column of the crossings, as fractions, shape ``(k, 2)``."""
        at = self.start.astype(float)
        at[np.arange(len(at)), self.axis] += self.share
        return at


def locate_crossings(side: Index, support: Support, options: SharpenOptions) -> Crossings:
    """Locate the edge on every link whose two points are on different sides.

    Parameters
    ----------
    side : of every point, 0 where unknown, shape ``(m, n)``.
    support : what the sides are fitted to.

    Returns
    -------
    The crossings at which the two sides meet at an angle, close to the link.
    """
    start, axis = _links(side)
    rows = np.arange(len(start))
    end = start + np.eye(2, dtype=np.int64)[axis]
    pair = np.stack([side[tuple(start.T)], side[tuple(end.T)]], axis=1)
    u, v = support.lattice.u, support.lattice.v

    def parameters(at: Array) -> Array:
        return np.stack(
            [np.interp(at[:, 0], np.arange(len(u)), u), np.interp(at[:, 1], np.arange(len(v)), v)],
            axis=1,
        )

    # Both sides about both ends of the link: the fits of the first end come first.
    shape, course = support.fit(np.concatenate([start, start]), pair.T.ravel())
    k = len(start)
    shapes, courses = (shape[rows], shape[rows + k]), (course[rows], course[rows + k])
    inside = [depth(shapes, courses, parameters(point.astype(float))) for point in (start, end)]
    drop = inside[0] - inside[1]
    share = np.clip(np.where(drop > 0.0, inside[0] / np.where(drop > 0.0, drop, 1.0), 0.5), 0, 1)
    at = start.astype(float)
    at[rows, axis] += share
    points, normals, is_edge = meet(shapes, courses, parameters(at), options)
    return Crossings(start, axis, share, points, pair, normals)[is_edge]


def meet(
    shapes: Sequence[Sides], courses: Sequence[Sides], uv: Array, options: SharpenOptions
) -> tuple[Array, Array, Mask]:
    """Where two sides meet near the parameters ``uv``: points, normals, whether at an edge.

    Along the edge the point stays where the courses of the sides have it.
    """
    expected = np.mean([course.at(uv)[0] for course in courses], axis=0)
    points, normals, gap = common_points(shapes, uv, expected)
    moved = np.linalg.norm(points - expected, axis=1)
    angle = angle_between(normals[:, 0], normals[:, 1])
    is_edge = (
        np.isfinite(points).all(axis=1)
        & (angle > np.radians(options.spread_deg))
        & (gap < options.max_gap)
        & (moved < options.max_move)
    )
    return points, normals, is_edge


def common_points(sides: Sequence[Sides], uv: Array, start: Array) -> tuple[Array, Array, Array]:
    """Points common to two or more sides, one of each a row, nearest to ``start``.

    Feet are sought from the parameters ``uv``.

    Returns
    -------
    points : shape ``(k, 3)``.
    normals : of each side there, shape ``(k, n_sides, 3)``.
    gap : largest distance to a side, shape ``(k,)``.
    """
    constraints = [_Followed(side, uv) for side in sides]
    points = start
    for _ in range(_MAX_STEPS):
        step = newton_step(points, constraints)
        length = np.linalg.norm(step, axis=1)
        points = points + step * np.minimum(1.0, 2.0 / np.maximum(length, 2.0))[:, None]
        if not len(length) or length.max() < _CONVERGED:
            break
    pairs = [constraint.project(points) for constraint in constraints]
    gap = np.max([np.linalg.norm(foot - points, axis=1) for foot, _ in pairs], axis=0)
    return points, np.stack([normal for _, normal in pairs], axis=1), gap


class _Followed:
    """Sides as a constraint; the foot is sought from where it was last."""

    def __init__(self, sides: Sides, uv: Array) -> None:
        self._sides, self._uv = sides, uv

    def project(self, points: Array) -> tuple[Array, Array]:
        feet, normals, self._uv = self._sides.foot(points, self._uv)
        return feet, normals


def angle_between(first: Array, second: Array) -> Array:
    """Angle between unit vectors, radians, shape ``(k,)``."""
    sine = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(sine, np.einsum("ki,ki->k", first, second)))


def _links(side: Index) -> tuple[Index, Index]:
    """First points and directions of the links between different sides."""
    starts, axes = [], []
    for axis in (0, 1):
        first = side[:-1] if axis == 0 else side[:, :-1]
        other = side[1:] if axis == 0 else side[:, 1:]
        found = np.argwhere((first != other) & (first > 0) & (other > 0))
        starts.append(found)
        axes.append(np.full(len(found), axis, dtype=np.int64))
    return np.concatenate(starts), np.concatenate(axes)
