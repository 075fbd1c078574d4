"""Knot insertion and degree elevation along one axis of a control net, exact for any degree.

All functions act on axis 0 of the control points; further axes are carried along,
so homogeneous coordinates of a rational surface work as well.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array

_SAME = 1e-12


def inserted(degree: int, knots: Array, control_points: Array, knot: float) -> tuple[Array, Array]:
    """Knots and control points after a knot goes in once more; the spline stays the same.

    Parameters
    ----------
    knots : nondecreasing, shape ``(n + degree + 1,)``.
    control_points : shape ``(n, ...)``. Only those whose support holds ``knot``
        change; the others are handed on untouched.
    knot : inside the domain ``[knots[degree], knots[n]]``.

    Returns
    -------
    knots, control_points : one more of each. At an end of an open domain the
        control point that no longer reaches the domain is dropped again.

    References
    ----------
    W. Boehm, Inserting new knots into B-spline curves, CAD 12 (1980).
    """
    n = len(control_points)
    start, end = knots[degree], knots[n]
    # Control point i moves if knots[i] < knot < knots[i + degree].
    first = int(np.searchsorted(knots, knot, side="right")) - degree
    place = int(np.searchsorted(knots, knot, side="left"))
    moved = np.arange(first, place)
    share = (knot - knots[moved]) / (knots[moved + degree] - knots[moved])
    share = share.reshape(-1, *(1 for _ in control_points.shape[1:]))
    between = share * control_points[moved] + (1.0 - share) * control_points[moved - 1]
    control_points = np.concatenate(
        [control_points[:first], between, control_points[place - 1 :]], axis=0
    )
    knots = np.insert(knots, place, knot)
    if knot == start:
        return knots[1:], control_points[1:]
    if knot == end:
        return knots[:-1], control_points[:-1]
    return knots, control_points


def with_multiplicity(
    degree: int, knots: Array, control_points: Array, knot: float, multiplicity: int
) -> tuple[Array, Array]:
    """Knots and control points in which ``knot`` stands at least ``multiplicity`` times.

    A knot that differs from ``knot`` by rounding only (1e-12 of the domain) is
    the same knot. Other arguments as for :func:`inserted`.

    >>> line = np.array([[0.0], [2.0]])
    >>> knots, points = with_multiplicity(1, np.array([0.0, 0.0, 2.0, 2.0]), line, 0.5, 1)
    >>> knots.tolist(), points.ravel().tolist()
    ([0.0, 0.0, 0.5, 2.0, 2.0], [0.0, 0.5, 2.0])
    """
    length = knots[len(control_points)] - knots[degree]
    nearest = float(knots[np.argmin(np.abs(knots - knot))])
    if abs(nearest - knot) <= _SAME * length:
        knot = nearest
    for _ in range(multiplicity - int(np.count_nonzero(knots == knot))):
        knots, control_points = inserted(degree, knots, control_points, knot)
    return knots, control_points


def restricted(
    degree: int, knots: Array, control_points: Array, low: float, high: float
) -> tuple[Array, Array]:
    """The part of the spline between two parameters of the domain, over clamped knots.

    The ends stand ``degree + 1`` times each, so that the first and last control
    points lie on the spline. A clamped spline between its own ends comes back
    as it is.
    """
    for end in (low, high):
        knots, control_points = with_multiplicity(degree, knots, control_points, end, degree)
    # Rounding may have moved the ends onto knots.
    low, high = (float(knots[np.argmin(np.abs(knots - end))]) for end in (low, high))
    # Control point i belongs to the knots i + 1 ... i + degree: the end knots for the outermost.
    first = int(np.searchsorted(knots, low, side="right")) - degree - 1
    last = int(np.searchsorted(knots, high, side="left")) - 1
    knots = knots[first : last + degree + 2].copy()
    knots[0], knots[-1] = low, high
    return knots, control_points[first : last + 1]


def elevated(degree: int, knots: Array, control_points: Array) -> tuple[Array, Array]:
    """The same spline with the degree raised by one.

    Every distinct knot gains one in multiplicity, so that no smoothness is added.

    Parameters
    ----------
    knots : clamped.

    References
    ----------
    The polar form of the elevated spline is the mean of the old ones with one
    argument left out each: L. Ramshaw, Blossoms are polar forms, CAGD 6 (1989).
    """
    distinct, counts = np.unique(knots, return_counts=True)
    raised = np.repeat(distinct, counts + 1)
    n = len(raised) - degree - 2
    arguments = raised[np.arange(n) + np.arange(1, degree + 2)[:, None]]
    span = np.searchsorted(knots, raised[:n], side="right") - 1
    total = sum(
        _blossom(degree, knots, control_points, span, np.delete(arguments, left_out, axis=0))
        for left_out in range(degree + 1)
    )
    return raised, np.asarray(total / (degree + 1))


def _blossom(
    degree: int, knots: Array, control_points: Array, span: NDArray[np.intp], arguments: Array
) -> Array:
    """Polar form of the polynomial pieces on ``span``, shape ``(m, ...)``.

    ``span`` has shape ``(m,)`` and counts knots; ``arguments`` is ``(degree, m)``.
    """
    trailing = (1,) * (control_points.ndim - 1)
    points = [control_points[span - degree + i] for i in range(degree + 1)]
    for step, argument in enumerate(arguments, start=1):
        for i in range(degree, step - 1, -1):
            left, right = knots[span - degree + i], knots[span + i - step + 1]
            share = ((argument - left) / (right - left)).reshape(-1, *trailing)
            points[i] = (1.0 - share) * points[i - 1] + share * points[i]
    return points[degree]
