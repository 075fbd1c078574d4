"""Cylinder through noisy points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crispline.fit.frame import frame_about, radial, tilted
from crispline.fit.robust import DistanceModel, coarse, fit_distances
from crispline.fit.starts import axis_by_normals, circle_about, extent, local_quadric
from crispline.surface import Cylinder
from crispline.surface.base import Array

MIN_POINTS = 6
MAX_RADIUS = 20.0
"""In extents of the data; a larger radius is a plane to the points."""


def fit_cylinder(
    points: Array,
    normals: Array,
    sigma: float,
    start: Cylinder | None = None,
    is_draft: bool = False,
) -> Cylinder | None:
    """Robust orthogonal-distance cylinder.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals, shape ``(n, 3)``; used for start values only.
    sigma : noise along the normal, spacings.
    start : start value; by default the best of several.
    is_draft : see :func:`crispline.fit.robust.fit_distances`.

    Returns
    -------
    The cylinder, with its origin at the foot of the centroid on the axis; None
    for fewer than six points or a radius beyond 20 extents of the data.
    """
    if len(points) < MIN_POINTS:
        return None
    kept = coarse(len(points))
    starts = _starts(points[kept], normals[kept]) if start is None else iter([start])
    cylinder = fit_distances(MODEL, (_anchored(s, points) for s in starts), points, sigma, is_draft)
    if cylinder is None or not 0.0 < cylinder.radius < MAX_RADIUS * extent(points):
        return None
    return _anchored(cylinder, points)


def _starts(points: Array, normals: Array) -> Iterator[Cylinder]:
    """Axis across the normals, then along either principal direction of a quadric."""
    quadric = local_quadric(points, normals)
    for axis in (axis_by_normals(normals), *quadric.directions):
        origin, radius = circle_about(points, axis)
        yield Cylinder(origin, axis, radius)
    curvature = float(quadric.curvatures[1])
    # Unlike the algebraic circle this start is not biased on shallow arcs.
    centre = quadric.origin + quadric.normal / curvature
    yield Cylinder(centre, quadric.directions[0], 1.0 / abs(curvature))


def _anchored(cylinder: Cylinder, points: Array) -> Cylinder:
    """The same cylinder with its origin beside the data, where tilts do not act as shifts."""
    offset = points.mean(axis=0) - cylinder.origin
    origin = cylinder.origin + (offset @ cylinder.axis) * cylinder.axis
    return Cylinder(origin, cylinder.axis, cylinder.radius)


def linearise(cylinder: Cylinder, points: Array) -> tuple[Array, Array]:
    """Signed distances ``(n,)`` and derivatives by two shifts, two tilts, radius ``(n, 5)``."""
    local = (points - cylinder.origin) @ frame_about(cylinder.axis).T
    rho, inward = radial(local, 2)
    jacobian = np.empty((len(points), 5))
    jacobian[:, :2] = inward
    jacobian[:, 2:4] = local[:, 2:] * inward
    jacobian[:, 4] = -1.0
    return rho - cylinder.radius, jacobian


def move(cylinder: Cylinder, step: Array) -> Cylinder:
    """Shift across the axis, tilt about the origin, change the radius."""
    frame = frame_about(cylinder.axis)
    return Cylinder(
        cylinder.origin + step[:2] @ frame[:2],
        tilted(frame, step[2], step[3]),
        cylinder.radius + float(step[4]),
    )


MODEL = DistanceModel(linearise, move)
