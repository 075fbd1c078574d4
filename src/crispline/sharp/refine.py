"""From ordered points on surfaces to the simplest curve that stays on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crispline.curve import Curve, circle_through, interpolated, line_through, resampled
from crispline.options import LocateOptions
from crispline.sharp.intersect import Constraint, distance, intersect, tangents
from crispline.surface.base import Array

_MAX_NODES = 200
_MIN_SPAN = 0.1
_MIN_STRENGTH = 0.05
_LOOSE_REACH = 3.0


def curve_along(
    points: Array,
    ends: tuple[Array, Array] | None,
    constraints: Sequence[Constraint],
    options: LocateOptions,
) -> Curve:
    """The simplest curve through ordered points on the constraints that stays on them.

    Parameters
    ----------
    points : shape ``(n, 3)``, ``n >= 5``; closed curves repeat the first.
    ends : vertices that the curve should reach; None for a closed curve.
    constraints : what the points lie on.
    options : tolerances.

    Returns
    -------
    Curve
        A line or a circular arc if the points lie on one; else a cubic B-spline
        refined where it leaves the constraints.
    """
    is_closed = ends is None
    points = _even(points, int(np.clip(len(points), 24, 60)), constraints)
    reached = _reached_ends(points, ends, options.corner_gap)
    if reached.all():
        exact_tolerance = 0.1 * options.curve_tolerance
        line = None if is_closed else line_through(points, exact_tolerance)
        curve = line or circle_through(points, exact_tolerance, is_closed)
        if curve is not None:
            return curve
    nodes = _refined(points, is_closed, constraints, options.curve_tolerance)
    slopes = _end_tangents(nodes, constraints)
    if ends is not None and not reached.all():
        for side, index in enumerate((0, -1)):
            if not reached[side]:
                nodes[index], slopes[side] = ends[side], 0.0
    return interpolated(nodes, is_closed, slopes)


def _reached_ends(
    points: Array, ends: tuple[Array, Array] | None, corner_gap: float
) -> NDArray[np.bool_]:
    """Whether each end of the points is close enough to its vertex, shape ``(2,)``."""
    if ends is None:
        return np.ones(2, dtype=np.bool_)
    away = np.linalg.norm(points[[0, -1]] - np.stack(ends), axis=1)
    return np.asarray(away <= corner_gap)


def _even(points: Array, n: int, constraints: Sequence[Constraint]) -> Array:
    """``n`` points at nearly even steps on the constraints; the ends stay."""
    even, _ = intersect(resampled(points, n), constraints)
    even[0], even[-1] = points[0], points[-1]
    return even


def _refined(
    points: Array, is_closed: bool, constraints: Sequence[Constraint], tolerance: float
) -> Array:
    """Interpolation nodes, halved wherever the curve between two leaves the constraints."""
    ends = points[[0, -1]]
    end_gaps = _loose_gaps(ends, constraints, tolerance)

    def allowed_gap(at: Array) -> Array:
        """What the surfaces leave undecided near an end at which they touch, else 0."""
        near = np.linalg.norm(at[:, None] - ends, axis=2) < _LOOSE_REACH
        return np.asarray(2.0 * np.max(near * end_gaps, axis=1))

    nodes = _even(points, int(np.clip(len(points) // 3, 5, 20)), constraints)
    is_free = allowed_gap(nodes[1:-1]) == 0.0
    if is_free.sum() >= 2:
        nodes = np.concatenate([nodes[:1], nodes[1:-1][is_free], nodes[-1:]])
    while True:
        curve = interpolated(nodes, is_closed, _end_tangents(nodes, constraints))
        knots = np.unique(curve.knots)
        middle = curve.evaluate(0.5 * (knots[:-1] + knots[1:]))
        feet, _ = intersect(middle, constraints)
        # The deviation peaks in the middle of a span; keep a margin for where it does not.
        is_off = np.linalg.norm(feet - middle, axis=1) > 0.5 * tolerance
        gap = allowed_gap(middle)
        is_off &= (gap == 0.0) | (distance(middle, constraints) > gap)
        is_off &= np.diff(knots) > _MIN_SPAN
        if not is_off.any() or len(nodes) + is_off.sum() > _MAX_NODES:
            return nodes
        nodes = np.insert(nodes, np.flatnonzero(is_off) + 1, feet[is_off], axis=0)


def _loose_gaps(ends: Array, constraints: Sequence[Constraint], tolerance: float) -> Array:
    """Gaps at both ends if the surfaces touch but miss each other there, else 0, shape ``(2,)``.

    Next to such an end the exact intersection turns away from it sharply, by no
    more than what the noise of the fits moves it.
    """
    gaps = distance(ends, constraints)
    _, strength = tangents(ends, constraints)
    return np.where((strength < _MIN_STRENGTH) & (gaps > tolerance), gaps, 0.0)


def _end_tangents(nodes: Array, constraints: Sequence[Constraint]) -> Array:
    """Unit tangents at both ends, shape ``(2, 3)``; zero where the surfaces touch."""
    directions, strength = tangents(nodes[[0, -1]], constraints)
    chords = np.stack([nodes[1] - nodes[0], nodes[-1] - nodes[-2]])
    along = np.einsum("ij,ij->i", directions, chords)
    sign = np.where(strength > _MIN_STRENGTH, np.sign(along), 0.0)
    return np.asarray(sign[:, None] * directions)
