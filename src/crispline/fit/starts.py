"""Start values for primitive fits: from normals, from a local quadric, from algebraic fits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from crispline.surface.base import Array, perpendicular_frame, unit


@dataclass(frozen=True)
class LocalQuadric:
    """A height field of degree two over the plane across the mean normal.

    Attributes
    ----------
    origin : the surface point above the centroid, shape ``(3,)``.
    normal : unit normal there, shape ``(3,)``, on the side of the given normals.
    directions : principal directions, rows, shape ``(2, 3)``.
    curvatures : normal curvatures along them, shape ``(2,)``, 1/spacing,
        positive where the surface bends towards the normal; the first has the
        smaller magnitude. Flat directions have 1/1000 of the extent's inverse
        instead of zero, so that every curvature has a centre.
    """

    origin: Array
    normal: Array
    directions: Array
    curvatures: Array


def local_quadric(points: Array, normals: Array) -> LocalQuadric:
    """Least-squares quadric of a patch.

    Meaningful only where the patch is a height field; elsewhere finite but useless.
    """
    centroid = points.mean(axis=0)
    z = unit(normals.mean(axis=0))
    x, y = perpendicular_frame(z)
    local = (points - centroid) @ np.stack([x, y, z]).T
    p, q, height = local.T
    columns = np.stack([np.ones_like(p), p, q, 0.5 * p * p, p * q, 0.5 * q * q], axis=1)
    c, slope_x, slope_y, xx, xy, yy = np.linalg.lstsq(columns, height, rcond=None)[0]
    normal = unit(z - slope_x * x - slope_y * y)
    # First and second fundamental forms of the graph at the origin.
    tangents = np.stack([x + slope_x * z, y + slope_y * z])
    second = np.array([[xx, xy], [xy, yy]]) / np.sqrt(1.0 + slope_x**2 + slope_y**2)
    root = np.linalg.cholesky(tangents @ tangents.T)
    inverse = np.linalg.inv(root)
    curvatures, vectors = np.linalg.eigh(inverse @ second @ inverse.T)
    directions = unit((inverse.T @ vectors).T @ tangents)
    by_size = np.argsort(np.abs(curvatures))
    least = 1e-3 / max(extent(points), 1e-300)
    curvatures = np.where(np.abs(curvatures) < least, np.copysign(least, curvatures), curvatures)
    return LocalQuadric(centroid + c * z, normal, directions[by_size], curvatures[by_size])


def axis_by_normals(normals: Array) -> Array:
    """Direction most nearly perpendicular to all normals: the axis of a cylinder."""
    return _least_direction(normals)


def axis_by_normal_circle(normals: Array) -> Array:
    """Axis of the circle that the normals of a cone describe on the unit sphere."""
    return _least_direction(normals - normals.mean(axis=0))


def axis_of_revolution(points: Array, normals: Array) -> tuple[Array, Array]:
    """Line that all surface normals meet best: a point on it and its unit direction.

    The normal lines of a surface of revolution lie in a linear line complex
    whose axis is the axis of revolution (Pottmann and Randrup 1998, Rotational
    and helical surface approximation for reverse engineering, section 3).
    """
    centroid = points.mean(axis=0)
    offsets = points - centroid
    size = float(np.sqrt(np.mean(np.sum(offsets**2, axis=1)))) or 1.0
    moments = np.cross(offsets / size, normals)
    # The part of the moments that no choice of the axis' own moment can explain.
    explained = np.linalg.lstsq(normals, moments, rcond=None)[0]
    axis = _least_direction(moments - normals @ explained)
    moment = -(explained @ axis) * size
    return centroid + np.cross(axis, moment), axis


def circle_about(points: Array, axis: Array) -> tuple[Array, float]:
    """Algebraic circle of the points seen along ``axis``: a point on the axis, the radius.

    Kasa's fit; biased to small radii on short arcs, which a start value may be.
    """
    centroid = points.mean(axis=0)
    x, y = perpendicular_frame(axis)
    plane = (points - centroid) @ np.stack([x, y]).T
    squared = np.sum(plane**2, axis=1)
    a, b, c = np.linalg.lstsq(
        np.column_stack([2.0 * plane, np.ones(len(plane))]), squared, rcond=None
    )[0]
    return centroid + a * x + b * y, float(np.sqrt(max(c + a * a + b * b, 1e-12)))


def _least_direction(vectors: Array) -> Array:
    """Unit vector with the smallest sum of squared products with ``vectors`` ``(n, 3)``."""
    return np.asarray(np.linalg.eigh(vectors.T @ vectors)[1][:, 0])


def extent(points: Array) -> float:
    """Twice the largest distance from the centroid; the same however the part is turned."""
    return 2.0 * float(np.max(np.linalg.norm(points - points.mean(axis=0), axis=1)))
