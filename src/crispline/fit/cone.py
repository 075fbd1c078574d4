"""Cone through noisy points."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from crispline.fit.frame import frame_about, radial, tilted
from crispline.fit.robust import DistanceModel, coarse, fit_distances
from crispline.fit.starts import (
    axis_by_normal_circle,
    axis_by_normals,
    axis_of_revolution,
    local_quadric,
)
from crispline.surface import Cone
from crispline.surface.base import Array

MIN_POINTS = 7
MIN_HALF_ANGLE = np.radians(1.5)
"""A slimmer cone is a cylinder to the points."""
MAX_HALF_ANGLE = np.radians(88.0)
"""A flatter cone is a plane to the points."""

_MAX_OTHER_NAPPE = 0.02


@dataclass(frozen=True)
class Frustum:
    """A cone seen from a point of its axis beside the data; regular from cylinder to plane.

    The signed distance of a point at height ``h`` along ``axis`` and distance
    ``rho`` from it is ``rho cos(half_angle) - h sin(half_angle) - offset``.
    """

    origin: Array
    axis: Array
    half_angle: float
    offset: float


def fit_cone(
    points: Array,
    normals: Array,
    sigma: float,
    start: Cone | None = None,
    is_draft: bool = False,
) -> Cone | None:
    """Robust orthogonal-distance cone.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals, shape ``(n, 3)``; used for start values only.
    sigma : noise along the normal, spacings.
    start : start value; by default the best of several.
    is_draft : see :func:`crispline.fit.robust.fit_distances`.

    Returns
    -------
    The cone; None for fewer than seven points, a half angle outside 1.5 to 88
    degrees, or points on both sides of the apex.
    """
    if len(points) < MIN_POINTS:
        return None
    kept = coarse(len(points))
    starts = _starts(points[kept], normals[kept]) if start is None else iter([_frustum(start)])
    frustum = fit_distances(MODEL, (_anchored(s, points) for s in starts), points, sigma, is_draft)
    if frustum is None or not MIN_HALF_ANGLE <= abs(frustum.half_angle) <= MAX_HALF_ANGLE:
        return None
    cone = as_cone(frustum)
    heights = (points - cone.apex) @ cone.axis
    return cone if np.mean(heights < 0.0) <= _MAX_OTHER_NAPPE else None


def _starts(points: Array, normals: Array) -> Iterator[Frustum]:
    """Axes from the normals, as a cone and as a cylinder, and from a quadric."""
    axes = [
        axis_by_normal_circle(normals),
        axis_by_normals(normals),
        axis_of_revolution(points, normals)[1],
        local_quadric(points, normals).directions[0],
    ]
    for axis in axes:
        yield _algebraic_frustum(points, axis)


def _algebraic_frustum(points: Array, axis: Array) -> Frustum:
    """Cone about a known direction: ``|p - c|^2 = (r + h tan)^2`` is linear in its products."""
    centroid = points.mean(axis=0)
    frame = frame_about(axis)
    p, q, height = ((points - centroid) @ frame.T).T
    columns = np.stack([2.0 * p, 2.0 * q, np.ones_like(p), 2.0 * height, height**2], axis=1)
    a, b, c, radius_times_slope, _ = np.linalg.lstsq(columns, p * p + q * q, rcond=None)[0]
    radius = np.sqrt(max(c + a * a + b * b, 1e-12))
    half_angle = float(np.arctan(radius_times_slope / radius))
    origin = centroid + np.array([a, b]) @ frame[:2]
    return Frustum(origin, axis, half_angle, float(radius * np.cos(half_angle)))


def frustum_beside(cone: Cone, points: Array) -> Frustum:
    """The same cone as :func:`linearise` sees it, with its origin beside the points."""
    return _anchored(_frustum(cone), points)


def _frustum(cone: Cone) -> Frustum:
    return Frustum(cone.apex, cone.axis, cone.half_angle, 0.0)


def as_cone(frustum: Frustum) -> Cone:
    """The same cone by its apex; the axis points into the nappe with the data."""
    apex = frustum.origin - frustum.offset / np.sin(frustum.half_angle) * frustum.axis
    side = 1.0 if frustum.half_angle >= 0.0 else -1.0
    return Cone(apex, side * frustum.axis, abs(frustum.half_angle))


def _anchored(frustum: Frustum, points: Array) -> Frustum:
    """The same cone with its origin beside the data, where tilts do not act as shifts."""
    height = float((points.mean(axis=0) - frustum.origin) @ frustum.axis)
    return Frustum(
        frustum.origin + height * frustum.axis,
        frustum.axis,
        frustum.half_angle,
        frustum.offset + height * float(np.sin(frustum.half_angle)),
    )


def linearise(frustum: Frustum, points: Array) -> tuple[Array, Array]:
    """Signed distances and derivatives by two shifts, two tilts, angle, offset ``(n, 6)``."""
    local = (points - frustum.origin) @ frame_about(frustum.axis).T
    height = local[:, 2]
    rho, inward = radial(local, 2)
    cos_half, sin_half = np.cos(frustum.half_angle), np.sin(frustum.half_angle)
    # Distance along the ruling: the lever arm of both the tilts and the half angle.
    along = height * cos_half + rho * sin_half
    jacobian = np.empty((len(points), 6))
    jacobian[:, :2] = cos_half * inward
    jacobian[:, 2:4] = along[:, None] * inward
    jacobian[:, 4] = -along
    jacobian[:, 5] = -1.0
    return rho * cos_half - height * sin_half - frustum.offset, jacobian


def move(frustum: Frustum, step: Array) -> Frustum:
    """Shift across the axis, tilt about the origin, change half angle and offset."""
    frame = frame_about(frustum.axis)
    return Frustum(
        frustum.origin + step[:2] @ frame[:2],
        tilted(frame, step[2], step[3]),
        frustum.half_angle + float(step[4]),
        frustum.offset + float(step[5]),
    )


MODEL = DistanceModel(linearise, move)
