"""From ordered points on surfaces to the simplest curve that stays on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from crispline.curve import (
    Curve,
    circle_through,
    interpolated,
    line_through,
    resampled,
    straight_at,
)
from crispline.options import LocateOptions
from crispline.surface.base import Array
from crispline.surface.intersect import (
    Constraint,
    distance,
    intersect,
    newton_step,
    tangents,
)

_MAX_NODES = 200
_SAME = 1e-9
_MIN_OPEN, _MIN_CLOSED = 2, 4  # nodes of a curve
_MIN_SPAN = 0.1
_MAX_PARTS = 8
_MIN_STRENGTH = 0.05
_LOOSE = 0.05  # ends so far from the surfaces lie aside of them, spacings
_LOOSE_REACH = 3.0
_CUSP_REACH = 2.0  # so near to a cusp curves are drawn straight to it, spacings


def curve_along(
    points: Array,
    ends: tuple[Array, Array] | None,
    constraints: Sequence[Constraint],
    options: LocateOptions,
    cusps: Sequence[bool] = (False, False),
) -> Curve | None:
    """The simplest curve through ordered points on the constraints that stays on them.

    Parameters
    ----------
    points : shape ``(n, 3)``, ``n >= 5``; closed curves repeat the first.
    ends : vertices that the curve should reach; None for a closed curve.
    constraints : what the points lie on.
    options : tolerances.
    cusps : of the two ends those at which another curve leaves in the same direction: there the
        curve goes all the way to its vertex, and leaves it at an angle.

    Returns
    -------
    Curve
        A line or a circular arc if the points lie on one; else a cubic B-spline
        refined where it leaves the constraints. None if the constraints draw the points
        together into one.
    """
    is_closed = ends is None
    points = _even(points, int(np.clip(len(points), 24, 60)), constraints)
    reached = _reached_ends(points, ends, np.where(cusps, 0.0, options.corner_gap))
    if reached.all():
        exact_tolerance = 0.1 * options.curve_tolerance
        line = None if is_closed else line_through(points, exact_tolerance)
        curve = line or circle_through(points, exact_tolerance, is_closed)
        if curve is not None:
            return curve
    nodes = _refined(points, is_closed, constraints, options.curve_tolerance)
    if nodes is None:
        return None
    slopes = _end_tangents(nodes, constraints)
    if ends is not None and not reached.all():
        for side, index in enumerate((0, -1)):
            if reached[side]:
                continue
            nodes[index], slopes[side] = ends[side], 0.0
            if cusps[side]:
                # What the fits leave undecided is more than what parts the two curves there.
                nodes, slopes[side] = straight_at(nodes, side == 0, _CUSP_REACH)
    return interpolated(nodes, is_closed, slopes)


def _reached_ends(
    points: Array, ends: tuple[Array, Array] | None, corner_gap: Array
) -> NDArray[np.bool_]:
    """Whether each end of the points is close enough to its vertex, shape ``(2,)``."""
    if ends is None:
        return np.ones(2, dtype=np.bool_)
    away = np.linalg.norm(points[[0, -1]] - np.stack(ends), axis=1)
    return np.asarray(away <= corner_gap)


def _even(points: Array, n: int, constraints: Sequence[Constraint]) -> Array:
    """At most ``n`` points at nearly even steps on the constraints; the ends stay."""
    even, _ = intersect(resampled(points, n), constraints)
    even[0], even[-1] = points[0], points[-1]
    return _distinct(even)


def _distinct(points: Array) -> Array:
    """The points without inner ones that repeat the one before or the last."""
    step = np.linalg.norm(np.diff(points, axis=0), axis=1)
    kept = points[np.append(True, step > _SAME)]
    kept[-1] = points[-1]
    return np.asarray(kept)


def _refined(
    points: Array, is_closed: bool, constraints: Sequence[Constraint], tolerance: float
) -> Array | None:
    """Interpolation nodes, denser wherever the curve between two leaves the constraints.

    None if there are too few for a curve.
    """
    ends = points[[0, -1]]
    end_gaps = _loose_gaps(ends, constraints, tolerance)

    def allowed_gap(at: Array) -> Array:
        """What the surfaces leave undecided near an end that they miss, else 0."""
        near = np.linalg.norm(at[:, None] - ends, axis=2) < _LOOSE_REACH
        return np.asarray(2.0 * np.max(near * end_gaps, axis=1))

    nodes = _even(points, int(np.clip(len(points) // 3, 5, 20)), constraints)
    is_free = allowed_gap(nodes[1:-1]) == 0.0
    if is_free.sum() >= 2:
        nodes = np.concatenate([nodes[:1], nodes[1:-1][is_free], nodes[-1:]])
    if len(nodes) < (_MIN_CLOSED if is_closed else _MIN_OPEN):
        return None
    while True:
        curve = interpolated(nodes, is_closed, _end_tangents(nodes, constraints))
        knots = np.unique(curve.knots)
        spans = np.diff(knots)
        middle = curve.evaluate(knots[:-1] + 0.5 * spans)
        deviation = np.linalg.norm(newton_step(middle, constraints), axis=1)
        gap = allowed_gap(middle)
        is_decided = (gap == 0.0) | (distance(middle, constraints) > gap)
        # The deviation peaks in the middle of a span; half keeps a margin for where it does
        # not. It falls with the fourth power of the span, except next to a loose end.
        ratio = np.where(is_decided, deviation / (0.5 * tolerance), 0.0)
        most = np.where(gap > 0.0, 2, _MAX_PARTS)
        n_parts = np.clip(np.ceil(ratio**0.25), 1, most).astype(int)
        n_parts[spans < _MIN_SPAN] = 1
        if len(nodes) + (n_parts - 1).sum() > _MAX_NODES:
            n_parts = np.minimum(n_parts, 2)
        if n_parts.max() == 1 or len(nodes) + (n_parts - 1).sum() > _MAX_NODES:
            return nodes
        added = [
            start + span * np.arange(1, n) / n
            for start, span, n in zip(knots[:-1], spans, n_parts, strict=True)
        ]
        feet, _ = intersect(curve.evaluate(np.concatenate(added)), constraints)
        after = np.repeat(np.arange(len(spans)) + 1, n_parts - 1)
        finer = _distinct(np.insert(nodes, after, feet, axis=0))
        if len(finer) <= len(nodes):  # the feet of all new points are old ones
            return nodes
        nodes = finer


def _loose_gaps(ends: Array, constraints: Sequence[Constraint], tolerance: float) -> Array:
    """Gaps at both ends if the curve of the surfaces misses them, else 0, shape ``(2,)``.

    Next to an end at which they touch but miss each other the exact intersection turns away
    sharply, by no more than what the noise of the fits moves it; next to one that lies aside,
    nodes on it would lead there and back in a hook.
    """
    gaps = distance(ends, constraints)
    _, strength = tangents(ends, constraints)
    touches = strength < _MIN_STRENGTH
    return np.where(touches & (gaps > tolerance) | (gaps > _LOOSE), gaps, 0.0)


def _end_tangents(nodes: Array, constraints: Sequence[Constraint]) -> Array:
    """Unit tangents at both ends, shape ``(2, 3)``; zero where the surfaces touch."""
    directions, strength = tangents(nodes[[0, -1]], constraints)
    chords = np.stack([nodes[1] - nodes[0], nodes[-1] - nodes[-2]])
    along = np.einsum("ij,ij->i", directions, chords)
    sign = np.where(strength > _MIN_STRENGTH, np.sign(along), 0.0)
    return np.asarray(sign[:, None] * directions)
