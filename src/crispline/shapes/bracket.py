"""The example part: an angle bracket with a bulged back."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from crispline.shapes.shape import (
    Shape,
    ShapeEdge,
    ShapeFace,
    circle,
    cylinder_face,
    edge,
    line,
    plane_face,
)
from crispline.surface.base import Array, unit

LENGTH = 80.0
HEIGHT = 60.0
WALL = 16.0
FILLET = 12.0
_HALF = 30.0
_BASE_BORE = 12.0
_BASE_BORE_X = 54.0
_WALL_BORE = 10.0
_WALL_BORE_Z = 44.0
_BULGE = 6.0
_FOOT = WALL + FILLET
_X, _Y, _Z = np.eye(3)


def bracket() -> Shape:
    """L-shaped bracket, 80 x 60 x 60: base plate and wall, 16 thick, 7 planes in all.

    A fillet of radius 12 joins plate and wall; a bore of radius 12 goes through
    the plate and one of radius 10 through the wall. The back of the wall is
    free-form, so five of the 23 sharp edges are space curves (kind ``curve``),
    the rim of the wall bore among them. 11 faces, 10 corners.
    """
    corners = np.array(
        [
            corner
            for y in (-_HALF, _HALF)
            for corner in (
                (LENGTH, y, 0.0),
                (LENGTH, y, WALL),
                (WALL, y, HEIGHT),
                (_back(y, HEIGHT), y, HEIGHT),
                (_back(y, 0.0), y, 0.0),
            )
        ]
    )
    return Shape("bracket", LENGTH, tuple(_faces()), tuple(_edges()), corners)


def _back(y: Array | float, z: Array | float) -> Array:
    """The free-form back ``x = -g(y, z)``: a bulge that leans to one side."""
    lean = 1.0 + 0.4 * np.sin(np.pi * np.asarray(z) / 45.0 + np.asarray(y) / 40.0)
    return np.asarray(-_BULGE * np.cos(np.pi * np.asarray(y) / 90.0) * lean)


def _back_gradient(y: Array, z: Array) -> tuple[Array, Array]:
    phase = np.pi * z / 45.0 + y / 40.0
    arch, lean = np.cos(np.pi * y / 90.0), 1.0 + 0.4 * np.sin(phase)
    slope = 0.4 * np.cos(phase)
    by_y = -_BULGE * (-np.pi / 90.0 * np.sin(np.pi * y / 90.0) * lean + arch * slope / 40.0)
    by_z = -_BULGE * arch * slope * np.pi / 45.0
    return by_y, by_z


def _faces() -> list[ShapeFace]:
    x_range = (-1.5 * _BULGE, LENGTH)
    y_range = (-_HALF, _HALF)

    def on_bottom(y: Array, x: Array) -> NDArray[np.bool_]:
        return (x >= _back(y, 0.0)) & _clear_of_base_bore(x, y)

    def on_top(x: Array, y: Array) -> NDArray[np.bool_]:
        return x >= _back(y, HEIGHT)

    def on_side(y: float) -> Callable[[Array, Array], NDArray[np.bool_]]:
        return lambda x, z: _in_profile(x, z) & (x >= _back(y, z))

    def on_wall_bore(u: Array, x: Array) -> NDArray[np.bool_]:
        angle = u / _WALL_BORE
        return x >= _back(_WALL_BORE * np.cos(angle), _WALL_BORE_Z + _WALL_BORE * np.sin(angle))

    def on_side_from_behind(z: Array, x: Array) -> NDArray[np.bool_]:
        return on_side(_HALF)(x, z)

    zero = np.zeros(3)
    return [
        plane_face(zero, _Y, _X, y_range, x_range, on_bottom),
        plane_face(WALL * _Z, _X, _Y, (_FOOT, LENGTH), y_range, _clear_of_base_bore),
        plane_face(LENGTH * _X, _Y, _Z, y_range, (0.0, WALL)),
        plane_face(WALL * _X, _Y, _Z, y_range, (_FOOT, HEIGHT), _clear_of_wall_bore),
        plane_face(HEIGHT * _Z, _X, _Y, (x_range[0], WALL), y_range, on_top),
        plane_face(-_HALF * _Y, _X, _Z, x_range, (0.0, HEIGHT), on_side(-_HALF)),
        plane_face(_HALF * _Y, _Z, _X, (0.0, HEIGHT), x_range, on_side_from_behind),
        cylinder_face(
            np.array([_FOOT, 0.0, _FOOT]),
            -_X,
            -_Z,
            FILLET,
            y_range,
            angle=(0.0, np.pi / 2.0),
            is_hole=True,
        ),
        cylinder_face(_BASE_BORE_X * _X, _X, _Y, _BASE_BORE, (0.0, WALL), is_hole=True),
        cylinder_face(
            _WALL_BORE_Z * _Z,
            _Y,
            _Z,
            _WALL_BORE,
            (x_range[0], WALL),
            is_hole=True,
            contains=on_wall_bore,
        ),
        ShapeFace(
            "free-form",
            y_range,
            (0.0, HEIGHT),
            _evaluate_back,
            _clear_of_wall_bore,
            _stretch_of_back,
        ),
    ]


def _edges() -> list[ShapeEdge]:
    def back_across(z: float) -> ShapeEdge:
        return edge(
            "curve",
            lambda y: np.column_stack([_back(y, z), y, np.full_like(y, z)]),
            -_HALF,
            _HALF,
        )

    def wall_bore_rim(t: Array) -> Array:
        y, z = _WALL_BORE * np.cos(t), _WALL_BORE_Z + _WALL_BORE * np.sin(t)
        return np.column_stack([_back(y, z), y, z])

    def across(x: float, z: float) -> ShapeEdge:
        return line("straight", np.array([x, -_HALF, z]), np.array([x, _HALF, z]))

    edges = [
        across(LENGTH, 0.0),
        across(LENGTH, WALL),
        across(WALL, HEIGHT),
        back_across(0.0),
        back_across(HEIGHT),
        *(
            circle("circle", _BASE_BORE_X * _X + z * _Z, _BASE_BORE * _X, _BASE_BORE * _Y)
            for z in (0.0, WALL)
        ),
        circle("circle", WALL * _X + _WALL_BORE_Z * _Z, _WALL_BORE * _Y, _WALL_BORE * _Z),
        edge("curve", wall_bore_rim, 0.0, 2.0 * np.pi, is_closed=True),
    ]
    for y in (-_HALF, _HALF):
        edges += _side_edges(y)
    return edges


def _side_edges(y: float) -> list[ShapeEdge]:
    """The outline of one side; the fillet's arc joins its neighbours smoothly."""

    def straight(x_start: float, z_start: float, x_end: float, z_end: float) -> ShapeEdge:
        return line("straight", np.array([x_start, y, z_start]), np.array([x_end, y, z_end]))

    def arc(t: Array) -> Array:
        centre = np.array([_FOOT, y, _FOOT])
        return centre - FILLET * (np.cos(t)[:, None] * _X + np.sin(t)[:, None] * _Z)

    return [
        straight(float(_back(y, 0.0)), 0.0, LENGTH, 0.0),
        straight(LENGTH, 0.0, LENGTH, WALL),
        straight(LENGTH, WALL, _FOOT, WALL),
        edge("circle", arc, 0.0, np.pi / 2.0),
        straight(WALL, _FOOT, WALL, HEIGHT),
        straight(WALL, HEIGHT, float(_back(y, HEIGHT)), HEIGHT),
        edge(
            "curve",
            lambda z: np.column_stack([_back(y, z), np.full_like(z, y), z]),
            0.0,
            HEIGHT,
        ),
    ]


def _evaluate_back(y: Array, z: Array) -> tuple[Array, Array]:
    by_y, by_z = _back_gradient(y, z)
    return np.column_stack([_back(y, z), y, z]), unit(
        np.column_stack([-np.ones_like(y), by_y, by_z])
    )


def _stretch_of_back(y: Array, z: Array) -> Array:
    by_y, by_z = _back_gradient(y, z)
    return np.sqrt(1.0 + by_y**2 + by_z**2)


def _clear_of_base_bore(x: Array, y: Array) -> NDArray[np.bool_]:
    return np.hypot(x - _BASE_BORE_X, y) >= _BASE_BORE


def _clear_of_wall_bore(y: Array, z: Array) -> NDArray[np.bool_]:
    return np.hypot(y, z - _WALL_BORE_Z) >= _WALL_BORE


def _in_profile(x: Array, z: Array) -> NDArray[np.bool_]:
    """Whether (x, z) is in the L with its inner corner filleted."""
    in_fillet = (np.maximum(x, z) <= _FOOT) & (np.hypot(x - _FOOT, z - _FOOT) >= FILLET)
    return (x <= WALL) | (z <= WALL) | in_fillet
