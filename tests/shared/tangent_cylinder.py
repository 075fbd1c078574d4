"""Refits that make a smooth join exact."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from crispline.fit.cylinder import MAX_RADIUS
from crispline.fit.robust import DistanceModel, fit_distances
from crispline.fit.starts import extent
from crispline.surface import Cylinder, Plane
from crispline.surface.base import Array, unit

MIN_PLANE_ANGLE = np.radians(3.0)
"""Two planes closer to parallel do not fix the direction of an axis."""
MAX_AXIS_TURN = np.radians(15.0)
"""Farthest that tangency may turn the axis of the free fit."""


def fit_cylinder_tangent_to_planes(
    points: Array,
    sigma: float,
    planes: Sequence[Plane],
    start: Cylinder,
) -> Cylinder | None:
    """Robust cylinder that touches one or two planes exactly: a fillet.

    The constraints are eliminated, not weighted. The axis is parallel to every
    plane, a radius away, on the side of ``start``. One plane leaves the turn
    within it, the place along it and the radius; two planes leave the radius.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    sigma : noise along the normal, spacings.
    planes : one or two.
    start : the cylinder fitted without constraints.

    Returns
    -------
    The cylinder; None if the planes are nearly parallel, are not nearly
    parallel to the axis of ``start``, or leave no radius within 20 extents.

    Raises
    ------
    ValueError
        For no plane or more than two, which in general no cylinder touches.
    """
    if len(planes) not in (1, 2):
        raise ValueError(f"expected one or two tangent planes, got {len(planes)}")
    plane_normals = np.stack([plane.normal for plane in planes])
    offsets = np.array([plane.normal @ plane.origin for plane in planes])
    axis = _parallel_axis(plane_normals, start.axis)
    if axis is None:
        return None
    sides = np.where(plane_normals @ start.origin >= offsets, 1.0, -1.0)
    middle = start.origin + ((points.mean(axis=0) - start.origin) @ axis) * axis
    model = _tangent_model(plane_normals, offsets, sides)
    touching = _touching(plane_normals, offsets, sides, Cylinder(middle, axis, start.radius))
    cylinder = fit_distances(model, [touching], points, sigma)
    if cylinder is None or not 0.0 < cylinder.radius < MAX_RADIUS * extent(points):
        return None
    return cylinder


def _parallel_axis(plane_normals: Array, axis: Array) -> Array | None:
    """The direction parallel to all planes nearest to ``axis``; None if there is none near."""
    if len(plane_normals) == 1:
        parallel = unit(axis - (axis @ plane_normals[0]) * plane_normals[0])
    else:
        cross = np.cross(*plane_normals)
        if np.linalg.norm(cross) < np.sin(MIN_PLANE_ANGLE):
            return None
        parallel = unit(cross) * (1.0 if cross @ axis >= 0.0 else -1.0)
    return parallel if parallel @ axis > np.cos(MAX_AXIS_TURN) else None


def _touching(plane_normals: Array, offsets: Array, sides: Array, cylinder: Cylinder) -> Cylinder:
    """The cylinder moved straight across its axis until it touches the planes."""
    gaps = offsets + sides * cylinder.radius - plane_normals @ cylinder.origin
    return Cylinder(
        cylinder.origin + _across(plane_normals, cylinder.axis, gaps),
        cylinder.axis,
        cylinder.radius,
    )


def _across(plane_normals: Array, axis: Array, heights: Array) -> Array:
    """Shortest vector across the axis that rises by ``heights`` over the planes."""
    matrix = np.vstack([plane_normals, axis])
    return np.asarray(np.linalg.lstsq(matrix, np.append(heights, 0.0), rcond=None)[0])


def _tangent_model(plane_normals: Array, offsets: Array, sides: Array) -> DistanceModel[Cylinder]:
    """Distances to tangent cylinders by radius and, with one plane, shift and turn within it."""
    is_single = len(plane_normals) == 1

    def linearise(cylinder: Cylinder, points: Array) -> tuple[Array, Array]:
        offset = points - cylinder.origin
        height = offset @ cylinder.axis
        across = offset - height[:, None] * cylinder.axis
        rho = np.sqrt(np.einsum("ij,ij->i", across, across))
        inward = across * (-1.0 / np.where(rho > 0.0, rho, 1.0))[:, None]
        with_radius = _across(plane_normals, cylinder.axis, sides)
        columns = [inward @ with_radius - 1.0]
        if is_single:
            sideways = inward @ np.cross(plane_normals[0], cylinder.axis)
            columns += [sideways, height * sideways]
        return rho - cylinder.radius, np.column_stack(columns)

    def move(cylinder: Cylinder, step: Array) -> Cylinder:
        axis, origin = cylinder.axis, cylinder.origin
        if is_single:
            sideways = np.cross(plane_normals[0], axis)
            axis, origin = unit(axis + step[2] * sideways), origin + step[1] * sideways
        radius = cylinder.radius + float(step[0])
        return _touching(plane_normals, offsets, sides, Cylinder(origin, axis, radius))

    return DistanceModel(linearise, move)
