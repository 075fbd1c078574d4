"""The paper's model: a box with a cylinder on top."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from crispline.shapes.shape import Shape, ShapeEdge, circle, cylinder_face, line, plane_face
from crispline.surface.base import Array

SIDE = 70.0
RADIUS = 25.0
HEIGHT = 29.0
_HALF = SIDE / 2.0
_TOP = _HALF + HEIGHT
_AXES = np.eye(3)


def box_cylinder() -> Shape:
    """Cube of side 70 about the origin; on its top a cylinder of radius 25 and height 29.

    8 faces, 14 sharp edges (12 ``straight``, a ``lower circle`` and an ``upper
    circle``) and 8 corners; the area of 33,955 gives 34,000 points a spacing
    of 1.
    """
    origin = np.zeros(3)
    sides = [
        plane_face(
            sign * _HALF * _AXES[axis],
            sign * _AXES[axis - 2],
            _AXES[axis - 1],
            (-_HALF, _HALF),
            (-_HALF, _HALF),
            _outside_circle if axis == 2 and sign > 0.0 else _on_square,
        )
        for axis in range(3)
        for sign in (-1.0, 1.0)
    ]
    wall = cylinder_face(origin, _AXES[0], _AXES[1], RADIUS, (_HALF, _TOP))
    cap = plane_face(
        _TOP * _AXES[2], _AXES[0], _AXES[1], (-RADIUS, RADIUS), (-RADIUS, RADIUS), _inside_circle
    )
    rims = [
        circle(kind, height * _AXES[2], RADIUS * _AXES[0], RADIUS * _AXES[1])
        for kind, height in (("lower circle", _HALF), ("upper circle", _TOP))
    ]
    corners = _HALF * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    edges = (*_box_edges(corners), *rims)
    return Shape("box-cylinder", SIDE, (*sides, wall, cap), edges, corners)


def distance_to_box_cylinder(points: Array) -> Array:
    """Exact distance of points, shape ``(n, 3)``, to the shape's surface, shape ``(n,)``."""
    height = points[:, 2]
    rho = np.hypot(points[:, 0], points[:, 1])
    distances = [
        np.hypot(rho - RADIUS, height - np.clip(height, _HALF, _TOP)),
        np.hypot(np.maximum(rho - RADIUS, 0.0), height - _TOP),
    ]
    for axis, sign in itertools.product(range(3), (-1.0, 1.0)):
        foot = np.clip(points, -_HALF, _HALF)
        foot[:, axis] = sign * _HALF
        distance = np.linalg.norm(points - foot, axis=1)
        if axis == 2 and sign > 0.0:  # over the hole of the top, its rim is nearest
            distance = np.where(rho < RADIUS, np.hypot(RADIUS - rho, height - _HALF), distance)
        distances.append(distance)
    return np.asarray(np.min(distances, axis=0))


def _box_edges(corners: Array) -> list[ShapeEdge]:
    """Lines between the corners that differ in one coordinate."""
    return [
        line("straight", a, b)
        for a, b in itertools.combinations(corners, 2)
        if np.count_nonzero(a != b) == 1
    ]


def _on_square(u: Array, v: Array) -> NDArray[np.bool_]:
    return np.maximum(np.abs(u), np.abs(v)) <= _HALF


def _outside_circle(u: Array, v: Array) -> NDArray[np.bool_]:
    return np.hypot(u, v) >= RADIUS


def _inside_circle(u: Array, v: Array) -> NDArray[np.bool_]:
    return np.hypot(u, v) <= RADIUS
