"""Parts with free-form faces, fillets of changing radius, creases that fade, open sheets."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
from OCP.collections import Array2_gp_Pnt
from OCP.Geom import Geom_BezierSurface
from OCP.gp import gp_Pnt

from crispline.surface.base import Array
from parts.modelling import box, cut, fillet, line, prism, spline, tapered_fillet, wire


def lofted_body() -> Any:
    """A twisted free-form body between two flat ends: one lofted face all round."""
    sections = BRepOffsetAPI_ThruSections(True, False)
    for height, a, b, turn in ((0, 30, 18, 0.0), (25, 24, 20, 0.3), (50, 22, 14, 0.6)):
        t = 2.0 * np.pi * np.arange(24) / 24
        x, y = a * np.cos(t), b * np.sin(t) * (1.0 + 0.15 * np.cos(t))
        places = np.column_stack(
            [
                x * np.cos(turn) - y * np.sin(turn),
                x * np.sin(turn) + y * np.cos(turn),
                np.full(24, float(height)),
            ]
        )
        sections.AddWire(wire(spline(places.tolist(), is_closed=True)))
    sections.Build()
    return sections.Shape()


def wavy_block() -> Any:
    """A block (80 x 50) under a free-form roof of waves 3 high."""
    x, y = np.meshgrid(np.linspace(-10, 90, 9), np.linspace(-10, 60, 7), indexing="ij")
    roof = bezier_face(np.stack([x, y, 30.0 + 12.0 * np.sin(x / 12.0) * np.cos(y / 14.0)], -1))
    return cut(box((80, 50, 60)), prism(roof, (0, 0, 60)))


def variable_fillet() -> Any:
    """A block (70 x 40 x 30) with one edge rounded by a radius from 3 to 12."""
    return tapered_fillet(box((70, 40, 30)), 3.0, 12.0, lambda m: bool(m[1] < 0.1 and m[2] > 29.9))


def fading_crease() -> Any:
    """A block (80 x 50 x 30) with a crease of 31 degrees in its roof that fades out at x = 56."""
    x = np.array([-8.0, 24.0, 56.0])
    # z = 30 - 0.6 ((56 - x) / 56)^2 (y - 20), quadratic in x (Bezier ordinates), linear in y.
    slope = 0.6 * np.array([(64 / 56) ** 2, 0.0, 0.0])
    y = np.array([20.0, 60.0])
    points = np.zeros((3, 2, 3))
    points[..., 0], points[..., 1] = x[:, None], y
    points[..., 2] = 30.0 - slope[:, None] * (y - 20.0)
    return cut(box((80, 50, 30)), prism(bezier_face(points), (0, 0, 40)))


def bent_sheet() -> Any:
    """An open sheet without thickness: flat, bent on radius 12, flat again, with a waved end."""
    corner = [(40.0, 0.0, 0.0), (50.0, 0.0, 10.0)]
    flat, rise = line((0, 0, 0), corner[0]), line(corner[1], (50, 0, 40))
    sharp = line(corner[0], corner[1])
    wave = spline([(50, 0, 40), (53, 0, 50), (50, 0, 60), (53, 0, 72)])
    shell = prism(wire(flat, sharp, rise, wave), (0, 50, 0))
    return fillet(shell, 12.0, lambda m: bool(abs(m[0] - 40) < 1e-6 and abs(m[2]) < 1e-6))


def bezier_face(control_points: Array) -> Any:
    """A whole Bezier surface, control points of shape ``(n_u, n_v, 3)``, as a face."""
    n_u, n_v, _ = control_points.shape
    poles = Array2_gp_Pnt(1, n_u, 1, n_v)
    for i in range(n_u):
        for j in range(n_v):
            poles.SetValue(i + 1, j + 1, gp_Pnt(*map(float, control_points[i, j])))
    return BRepBuilderAPI_MakeFace(Geom_BezierSurface(poles), 1e-7).Face()
