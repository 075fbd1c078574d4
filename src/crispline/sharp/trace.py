"""Ordered points along the curve on which two surfaces meet, next to a ragged chain."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from crispline.curve import arc_length, resampled, smoothed
from crispline.surface.base import Array, unit
from crispline.surface.intersect import Constraint, intersect, tangents

MAX_MOVE = 3.0
"""A ragged chain lies this close to the curve it stands for, spacings."""

_SMOOTHING_ROUNDS = 12
_DIRECTION_REACH = 4
_MIN_ADVANCE = 0.2
_LENGTH_SLACK = 0.25
_MAX_STRENGTHLESS = 0.02


@dataclass(frozen=True)
class Guide:
    """A smoothed chain, roughly where a curve runs.

    Attributes
    ----------
    points : at even steps of about one spacing, shape ``(n, 3)``, ``n >= 5``;
        the last repeats the first if closed.
    is_closed : whether the chain has no corner.
    """

    points: Array
    is_closed: bool

    @property
    def length(self) -> float:
        """Length of the polyline, spacings."""
        return float(arc_length(self.points)[-1])

    def directions(self) -> Array:
        """Unit directions along the guide, shape ``(n, 3)``, over a reach that no zig-zag spans."""
        points, reach = self.points, _DIRECTION_REACH
        n = len(points)
        index = np.arange(n)
        if self.is_closed:
            reach = min(reach, (n - 1) // 4)
            return unit(points[(index + reach) % (n - 1)] - points[(index - reach) % (n - 1)])
        return unit(points[np.minimum(index + reach, n - 1)] - points[np.maximum(index - reach, 0)])


def smoothing_rounds(n_points: int) -> int:
    """Rounds that smooth a polyline over at most a twelfth of its length."""
    return int(np.clip(2.0 * (n_points / 12.0) ** 2, 2, _SMOOTHING_ROUNDS))


def guide_along(chain: Array, is_closed: bool) -> Guide:
    """Smooth a chain of net vertices, shape ``(k, 3)``, over at most a twelfth of its length."""
    smooth = smoothed(chain, smoothing_rounds(len(chain)), is_closed)
    n = max(5, int(np.ceil(arc_length(smooth)[-1])) + 1)
    return Guide(resampled(smooth, n), is_closed)


def traced(
    guide: Guide,
    constraints: Sequence[Constraint],
    ends: tuple[Array, Array] | None,
    max_gap: float,
) -> Iterator[Array]:
    """Candidates for the ordered points of a curve, the cheapest first.

    Parameters
    ----------
    guide : where the curve runs.
    constraints : what it lies on.
    ends : its first and last point, both on the constraints; None if closed.
    max_gap : largest distance of a point to its constraints, spacings.

    Yields
    ------
    Points on the constraints, shape ``(n, 3)``, from end to end; closed curves
    repeat their first point. None of them is sure to be sane, see :func:`is_sane`.
    """
    points = _projected(guide, constraints, ends, max_gap)
    if points is not None:
        yield points
    start, end = ends if ends is not None else (None, None)
    if start is None or end is None:
        first, gap = intersect(guide.points[:1], constraints)
        if gap[0] > max_gap:
            return
        start = end = first[0]
    direction = tangents(start[None], constraints)[0][0]
    # A chain whose end is far off may set out in the wrong direction: try both.
    if direction @ guide.directions()[0] < 0.0:
        direction = -direction
    for sign in (1.0, -1.0):
        points = _marched(guide, constraints, start, end, sign * direction, max_gap)
        if points is not None:
            yield points


def is_sane(points: Array, guide: Guide, slack: float, cloud: cKDTree, max_distance: float) -> bool:
    """Whether ordered points run once, without a fold, along the guide and the cloud.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    guide : where they should run.
    slack : how far the curve may leave the guide beyond :data:`MAX_MOVE`,
        because its ends did, spacings.
    cloud : the raw points.
    max_distance : largest distance of a point to the cloud, spacings.
    """
    steps = np.diff(points, axis=0)
    if np.any(np.einsum("ij,ij->i", steps[1:], steps[:-1]) <= 0.0):
        return False
    length = float(np.linalg.norm(steps, axis=1).sum())
    if abs(length - guide.length) > _LENGTH_SLACK * guide.length + 2.0 * (1.0 + slack):
        return False
    reach = MAX_MOVE + slack
    dense = resampled(guide.points, 4 * len(guide.points))
    leaves_guide = np.max(cKDTree(dense).query(points)[0]) > reach
    misses_guide = np.max(cKDTree(points).query(dense)[0]) > reach + length / len(points)
    leaves_cloud = np.max(cloud.query(points)[0]) > max_distance
    return not (leaves_guide or misses_guide or leaves_cloud)


def forward(points: Array, directions: Array, ends: tuple[Array, Array] | None) -> Array:
    """Drop the points that run backwards; shape ``(k, 3)``.

    Parameters
    ----------
    points : in the order of the chain, which may locally run backwards, ``(n, 3)``.
    directions : in which the curve runs at each point, unit, ``(n, 3)``.
    ends : first and last point of the curve, which replace what lies beyond
        them; None for a closed curve, which starts at ``points[0]``.
    """
    first, last = ends if ends is not None else (points[0], points[0])
    kept, heading = [first], [directions[0]]
    for point, direction in zip(points, directions, strict=True):
        if (point - kept[-1]) @ direction > _MIN_ADVANCE:
            kept.append(point)
            heading.append(direction)
    # A closed chain's tail overlaps its head, an open one's may run past its end.
    while len(kept) > 1 and (last - kept[-1]) @ heading[-1] <= _MIN_ADVANCE:
        kept.pop()
        heading.pop()
    return np.array([*kept, last])


def _projected(
    guide: Guide,
    constraints: Sequence[Constraint],
    ends: tuple[Array, Array] | None,
    max_gap: float,
) -> Array | None:
    """The guide's points moved to the constraints, those that run backwards dropped."""
    points, gap = intersect(guide.points, constraints)
    close = np.linalg.norm(points - guide.points, axis=1) <= MAX_MOVE
    good = close & (gap <= max_gap)
    if good.sum() < 2:
        return None
    heading, strength = tangents(points, constraints)
    is_told = good & (strength > _MAX_STRENGTHLESS)
    if len(constraints) > 2 and is_told.sum() >= 2:  # a contact may say nothing in places
        good = is_told
    points, heading = points[good], heading[good]
    along = np.einsum("ij,ij->i", heading, guide.directions()[good])
    ordered = forward(points, np.where(along < 0.0, -1.0, 1.0)[:, None] * heading, ends)
    if len(ordered) < 2 + guide.is_closed:
        return None
    # Dropped points leave holes; even steps over the holes fill them.
    even = resampled(ordered, max(len(guide.points), 9))
    filled, gap = intersect(even, constraints)
    filled[0], filled[-1] = ordered[0], ordered[-1]
    return filled if gap[1:-1].max() <= max_gap else None


def _marched(
    guide: Guide,
    constraints: Sequence[Constraint],
    start: Array,
    end: Array,
    direction: Array,
    max_gap: float,
) -> Array | None:
    """Step along the curve from start to end, correcting each step with Newton's method."""
    step = float(np.clip(guide.length / 10.0, 0.05, 1.0))
    is_loop = bool(np.linalg.norm(end - start) < step)
    points, heading = [start], direction
    for n_steps in range(int(2.0 * (guide.length + 2.0 * MAX_MOVE) / step)):
        here = points[-1]
        is_under_way = not is_loop or n_steps > 3
        if is_under_way and np.linalg.norm(end - here) <= 1.2 * step:
            if n_steps and (end - here) @ heading > 0.0:
                return np.array([*points, end])
            return np.array([*points[:-1], end]) if n_steps > 1 else None
        found, gap = intersect((here + step * heading)[None], constraints)
        moved = found[0] - here
        if gap[0] > max_gap or not 0.2 * step < np.linalg.norm(moved) < 2.0 * step:
            return None
        tangent, strength = tangents(found, constraints)
        if strength[0] < _MAX_STRENGTHLESS:
            return None
        heading = tangent[0] if tangent[0] @ moved > 0.0 else -tangent[0]
        points.append(found[0])
    return None
