"""Polylines, of which closed ones repeat their first point: length, steps, smoothing, ends."""

from __future__ import annotations

import numpy as np

from crispline.surface.base import Array, unit


def arc_length(points: Array) -> Array:
    """Length from the first point to each, shape ``(n,)``."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def resampled(points: Array, n: int) -> Array:
    """``n`` points at equal steps along the polyline, shape ``(n, 3)``; the ends stay."""
    length = arc_length(points)
    at = np.linspace(0.0, length[-1], n)
    even = np.stack([np.interp(at, length, column) for column in points.T], axis=1)
    even[0], even[-1] = points[0], points[-1]
    return even


def smoothed(points: Array, n_rounds: int, is_closed: bool) -> Array:
    """Weights 1/4, 1/2, 1/4 applied ``n_rounds`` times, shape ``(n, 3)``.

    The ends of an open polyline stay. After ``k`` rounds the points are averaged
    with a standard deviation of ``sqrt(k / 2)`` points.
    """
    smooth = np.array(points, dtype=np.float64)
    if len(smooth) < 4:
        return smooth
    for _ in range(n_rounds):
        if is_closed:
            ring = smooth[:-1]
            ring = 0.25 * (np.roll(ring, 1, axis=0) + 2.0 * ring + np.roll(ring, -1, axis=0))
            smooth = np.vstack([ring, ring[:1]])
        else:
            smooth[1:-1] = 0.25 * (smooth[:-2] + 2.0 * smooth[1:-1] + smooth[2:])
    return smooth


def straight_at(points: Array, is_start: bool, reach: float) -> tuple[Array, Array]:
    """A polyline that goes straight to one of its ends from a distance.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    is_start : whether it is its first point, or else its last.
    reach : from that end; inner points nearer to it go.

    Returns
    -------
    The other points, shape ``(k, 3)``, and the unit direction at that end, along the polyline.
    """
    tip = points[0 if is_start else -1]
    is_kept = np.linalg.norm(points - tip, axis=1) > reach
    is_kept[[0, -1]] = True
    kept = points[is_kept]
    return kept, unit(kept[1] - kept[0] if is_start else kept[-1] - kept[-2])
