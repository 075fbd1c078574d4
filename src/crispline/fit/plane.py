"""Plane through noisy points."""

from __future__ import annotations

import numpy as np

from crispline.fit.frame import frame_about, tilted
from crispline.fit.robust import DistanceModel, fit_distances
from crispline.surface import Plane
from crispline.surface.base import Array

MIN_POINTS = 3


def fit_plane(
    points: Array,
    normals: Array,
    sigma: float,
    start: Plane | None = None,
    is_draft: bool = False,
) -> Plane | None:
    """Robust orthogonal-distance plane.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : oriented unit normals, shape ``(n, 3)``; they choose the side only.
    sigma : noise along the normal, spacings.
    start : start value; by default the total least-squares plane.
    is_draft : see :func:`crispline.fit.robust.fit_distances`.

    Returns
    -------
    The plane, with its origin at the foot of the centroid and its normal on the
    side of ``normals``; None for fewer than three points or points on a line.
    """
    if len(points) < MIN_POINTS:
        return None
    centroid = points.mean(axis=0)
    _, spread, directions = np.linalg.svd(points - centroid, full_matrices=False)
    if spread[1] <= 1e-9 * spread[0]:
        return None
    starts = [Plane(centroid, directions[2]) if start is None else start]
    plane = fit_distances(MODEL, starts, points, sigma, is_draft)
    if plane is None:
        return None
    side = 1.0 if float(np.sum(normals @ plane.normal)) >= 0.0 else -1.0
    foot = centroid - ((centroid - plane.origin) @ plane.normal) * plane.normal
    return Plane(foot, side * plane.normal)


def linearise(plane: Plane, points: Array) -> tuple[Array, Array]:
    """Signed distances ``(n,)`` and derivatives by two tilts and the offset ``(n, 3)``."""
    local = (points - plane.origin) @ frame_about(plane.normal).T
    jacobian = np.column_stack([local[:, :2], np.full(len(points), -1.0)])
    return local[:, 2], jacobian


def move(plane: Plane, step: Array) -> Plane:
    """Tilt about the origin by ``step[:2]`` (radians), shift along the normal by ``step[2]``."""
    frame = frame_about(plane.normal)
    return Plane(plane.origin + step[2] * frame[2], tilted(frame, step[0], step[1]))


MODEL = DistanceModel(linearise, move)
