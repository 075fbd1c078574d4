"""Sphere through noisy points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crispline.fit.frame import radial
from crispline.fit.robust import DistanceModel, coarse, fit_distances
from crispline.fit.starts import extent, local_quadric
from crispline.surface import Sphere
from crispline.surface.base import Array

MIN_POINTS = 5
MAX_RADIUS = 20.0
"""In extents of the data; a larger radius is a plane to the points."""


def fit_sphere(
    points: Array,
    normals: Array,
    sigma: float,
    start: Sphere | None = None,
    is_draft: bool = False,
) -> Sphere | None:
    """Robust orthogonal-distance sphere.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals, shape ``(n, 3)``; used for start values only.
    sigma : noise along the normal, spacings.
    start : start value; by default the better of two.
    is_draft : see :func:`crispline.fit.robust.fit_distances`.

    Returns
    -------
    The sphere; None for fewer than five points or a radius beyond 20 extents.
    """
    if len(points) < MIN_POINTS:
        return None
    kept = coarse(len(points))
    starts = _starts(points[kept], normals[kept]) if start is None else iter([start])
    sphere = fit_distances(MODEL, starts, points, sigma, is_draft)
    if sphere is None or not 0.0 < sphere.radius < MAX_RADIUS * extent(points):
        return None
    return sphere


def _starts(points: Array, normals: Array) -> Iterator[Sphere]:
    """The algebraic sphere, and the mean curvature of a local quadric for shallow caps."""
    centroid = points.mean(axis=0)
    offset = points - centroid
    squared = np.sum(offset**2, axis=1)
    *centre, c = np.linalg.lstsq(
        np.column_stack([2.0 * offset, np.ones(len(offset))]), squared, rcond=None
    )[0]
    yield Sphere(centroid + centre, float(np.sqrt(max(c + np.dot(centre, centre), 1e-12))))
    quadric = local_quadric(points, normals)
    curvature = float(quadric.curvatures.mean())
    if curvature != 0.0:  # zero for a saddle
        yield Sphere(quadric.origin + quadric.normal / curvature, 1.0 / abs(curvature))


def linearise(sphere: Sphere, points: Array) -> tuple[Array, Array]:
    """Signed distances ``(n,)`` and derivatives by centre and radius ``(n, 4)``."""
    offset = points - sphere.centre
    length, inward = radial(offset, 3)
    jacobian = np.column_stack([inward, np.full(len(points), -1.0)])
    return length - sphere.radius, jacobian


def move(sphere: Sphere, step: Array) -> Sphere:
    """Shift the centre, change the radius."""
    return Sphere(sphere.centre + step[:3], sphere.radius + float(step[3]))


MODEL = DistanceModel(linearise, move)
