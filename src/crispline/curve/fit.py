"""Curves through ordered points: line, circular arc, cubic B-spline interpolation."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import make_interp_spline

from crispline.curve.curves import BSplineCurve, Circle, Line
from crispline.curve.polyline import arc_length
from crispline.surface.base import Array, unit

_MAX_RADIUS = 1e4
"""Flatter arcs, in lengths of the arc, are left to lines and B-splines."""


def line_through(points: Array, tolerance: float) -> Line | None:
    """The line from the first to the last point, if all lie on it.

    Parameters
    ----------
    points : in order, shape ``(n, 3)``.
    tolerance : largest distance of a point to the line.

    Examples
    --------
    >>> line_through(np.array([[0.0, 0, 0], [1.0, 0, 0], [3.0, 0, 0]]), 1e-9).end
    3.0
    """
    offset = points - points[0]
    length = float(np.linalg.norm(offset[-1]))
    if length == 0.0:
        return None
    direction = offset[-1] / length
    away = offset - (offset @ direction)[:, None] * direction
    if np.linalg.norm(away, axis=1).max() > tolerance:
        return None
    return Line(points[0], direction, 0.0, length)


def circle_through(points: Array, tolerance: float, is_closed: bool) -> Circle | None:
    """The circular arc from the first to the last point, if all lie on it.

    Parameters
    ----------
    points : in order, closely enough that neighbours are less than half a turn
        apart, shape ``(n, 3)``; the last repeats the first if closed.
    tolerance : largest distance of a point to the circle.
    is_closed : whether to return the full circle.

    The arc runs anticlockwise about its normal and starts at angle 0.
    """
    ring = points[:-1] if is_closed else points
    if len(ring) < 3:
        return None
    mean = ring.mean(axis=0)
    scale = float(np.linalg.norm(ring - mean, axis=1).max())
    _, spread, axes = np.linalg.svd(ring - mean, full_matrices=False)
    if scale == 0.0 or spread[1] < 1e-9 * spread[0]:
        return None
    # In the plane, |q|^2 = 2 c.q + (r^2 - |c|^2) is linear in the unknowns.
    flat = (ring - mean) @ axes[:2].T / scale
    rows = np.column_stack([2.0 * flat, np.ones(len(flat))])
    solution = np.linalg.lstsq(rows, np.einsum("ij,ij->i", flat, flat), rcond=None)[0]
    radius = float(np.sqrt(max(solution[2] + solution[:2] @ solution[:2], 0.0)) * scale)
    if not 0.0 < radius < _MAX_RADIUS * scale:
        return None
    centre = mean + scale * solution[:2] @ axes[:2]
    normal = unit(np.cross(points[0] - centre, points[1] - centre))
    normal = axes[2] if normal @ axes[2] > 0.0 else -axes[2]
    x_axis = points[0] - centre
    x_axis = unit(x_axis - (x_axis @ normal) * normal)
    offset = points - centre
    height = offset @ normal
    x, y = offset @ x_axis, offset @ np.cross(normal, x_axis)
    if np.hypot(height, np.hypot(x, y) - radius).max() > tolerance:
        return None
    angle = np.unwrap(np.arctan2(y, x))
    end = 2.0 * np.pi if is_closed else float(angle[-1])
    if not 0.0 < end < 2.0 * np.pi + 1e-9:
        return None
    return Circle(centre, normal, x_axis, radius, 0.0, end)


def interpolated(points: Array, is_closed: bool, ends: Array | None = None) -> BSplineCurve:
    """The cubic B-spline through the points, with chord lengths as parameters.

    Parameters
    ----------
    points : in order, no two neighbours equal, shape ``(n, 3)``, ``n >= 2``; if
        closed the last repeats the first and ``n >= 4``.
    is_closed : whether to join the ends with continuous second derivative.
    ends : unit tangents at both ends, shape ``(2, 3)``, a zero vector for an
        unknown one; ignored if closed.

    Returns
    -------
    BSplineCurve
        Fourth-order accurate in the distance between the points.
    """
    chord = arc_length(points)
    if is_closed:
        periodic = make_interp_spline(chord, points, k=3, bc_type="periodic")
        slope = np.asarray(periodic(chord[0], 1))
        slopes = np.stack([slope, slope])
    else:
        slopes = _end_slopes(points, chord)
        if ends is not None:
            is_known = np.linalg.norm(ends, axis=1, keepdims=True) > 0.0
            slopes = np.where(is_known, ends, slopes)
    # A periodic spline is the clamped one with the same nodes and the same end slopes.
    clamped = make_interp_spline(
        chord,
        points,
        k=3,
        bc_type=([(1, slopes[0])], [(1, slopes[1])]),  # type: ignore[arg-type]  # stubs lag
    )
    return BSplineCurve(np.asarray(clamped.t), np.asarray(clamped.c))


def _end_slopes(points: Array, chord: Array) -> Array:
    """Slopes of the parabolas through the first and the last three points (Bessel)."""
    slopes = np.diff(points, axis=0) / np.diff(chord)[:, None]
    if len(points) == 2:
        return np.repeat(slopes, 2, axis=0)
    step = np.diff(chord)
    first = slopes[0] - (slopes[1] - slopes[0]) * step[0] / (step[0] + step[1])
    last = slopes[-1] + (slopes[-1] - slopes[-2]) * step[-1] / (step[-1] + step[-2])
    return np.stack([first, last])
