"""A curve that runs where its surfaces are, in the mean: they need not meet there."""

from __future__ import annotations

import numpy as np

from crispline.curve import Curve, interpolated, line_through, resampled
from crispline.sharp.trace import MAX_MOVE, Guide, forward
from crispline.surface.base import Array

N_ROUNDS = 3
"""How often the points of such a curve move to the mean of their feet on the surfaces."""


def points_along(guide: Guide) -> Array:
    """Points of a guide, about three spacings apart, from which a smooth curve is made."""
    return resampled(guide.points, int(np.clip(guide.length / 3.0 + 2.0, 5, 60)))


def curve_through(
    guide: Guide, start: Array, points: Array, ends: tuple[Array, Array] | None
) -> Curve:
    """The curve through points that were moved off a guide.

    Parameters
    ----------
    guide : where the curve runs.
    start : the points on the guide, shape ``(n, 3)``; they count where moving them took them
        too far.
    points : where they are now, shape ``(n, 3)``.
    ends : positions of the first and last vertex; None if the curve is closed.
    """
    if np.linalg.norm(points - start, axis=1).max() > MAX_MOVE:
        points = start
    if guide.is_closed:
        points = np.concatenate([points[:-1], points[:1]])
    directions = Guide(points, guide.is_closed).directions()
    if ends is None:
        ordered = forward(points, directions, None)
        return interpolated(ordered if len(ordered) >= 5 else start, is_closed=True)
    return open_curve(guide, points[1:-1], directions[1:-1], ends)


def open_curve(guide: Guide, inner: Array, directions: Array, ends: tuple[Array, Array]) -> Curve:
    """The curve from end to end through those of some points that do not run backwards.

    Parameters
    ----------
    guide : its middle holds the curve if no point is left and the ends are no line apart.
    inner, directions : points and unit directions of the curve there, shape ``(n, 3)``.
    ends : positions of the first and last vertex.
    """
    ordered = forward(inner, directions, ends)
    if len(ordered) > 2:
        return interpolated(ordered, is_closed=False)
    middle = guide.points[len(guide.points) // 2]
    bent = np.stack([ends[0], middle, ends[1]])
    return line_through(ordered, 0.0) or interpolated(bent, is_closed=False)
