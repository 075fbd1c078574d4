"""Turned parts: cylinders, cones, spheres, tori, spline profiles."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
from OCP.gp import gp_Ax1, gp_Ax2, gp_Circ, gp_Dir, gp_Pnt

from parts.modelling import (
    X,
    box,
    chamfer,
    cone,
    cut,
    cylinder,
    disc,
    fillet,
    fuse,
    line,
    polygon,
    prism,
    revolution,
    ring,
    sphere,
    spline,
    torus,
    wire,
)


def flange() -> Any:
    """A disc (radius 40) with a hub, a bore, and six holes on a bolt circle."""
    body = fuse(cylinder(40, 10), cylinder(20, 30))
    holes = [cylinder(4, 20, at) for at in ring(6, 30, -5)]
    return cut(body, cylinder(12, 50, (0, 0, -5)), *holes)


def cone_hub() -> Any:
    """A conical hub on a disc, bored from above; the blind bore ends in a drill tip."""
    body = fuse(cylinder(32, 8), cone(26, 14, 30, (0, 0, 8)))
    return cut(body, cylinder(8, 30, (0, 0, 15)), cone(0, 8, 5, (0, 0, 10)))


def ball_rod() -> Any:
    """A rod (radius 8) with a ball (radius 15) at one end and a round end at the other."""
    return fuse(cylinder(8, 60, axis=X), sphere(15, (65, 0, 0)), sphere(8))


def ring_groove() -> Any:
    """A piston: a cylinder with two O-ring grooves of torus shape, 6 and 8 wide, and a bore."""
    body = cylinder(30, 50)
    return cut(
        body, torus(30, 3, (0, 0, 15)), torus(30, 4, (0, 0, 34)), cylinder(10, 70, (0, 0, -5))
    )


def filleted_boss() -> Any:
    """A plate (80 x 60) with a boss whose foot and top are rounded: tori between tangents."""
    body = fuse(box((80, 60, 12), (-40, -30, 0)), cylinder(16, 28, (0, 0, 12)))
    body = fillet(body, 6.0, lambda m: bool(abs(np.hypot(m[0], m[1]) - 16) < 1e-6 and m[2] < 13))
    return fillet(body, 4.0, lambda m: bool(m[2] > 39.9))


def hex_bolt() -> Any:
    """A bolt M20 x 60: chamfered head on a washer face, fillet under it, chamfered end."""
    turns = np.arange(6) * np.pi / 3
    corners = polygon([(20 * np.cos(t), 20 * np.sin(t), 0.0) for t in turns])
    corner = disc(polygon([(17, 0, 14), (30, 0, 14), (30, 0, 14 - 13 * 0.45)]))
    head = cut(prism(disc(corners), (0, 0, 14)), revolution(corner))
    bolt = fuse(head, cylinder(16, 1.2, (0, 0, -1.2)), cylinder(10, 60, (0, 0, -60)))
    bolt = fillet(bolt, 2.0, lambda m: bool(abs(m[2] + 1.2) < 0.01 and np.hypot(*m[:2]) < 11))
    return chamfer(bolt, 2.0, lambda m: bool(m[2] < -59.9))


def stepped_shaft() -> Any:
    """Three diameters, chamfered ends and a keyway."""
    shaft = fuse(
        cylinder(12, 30, axis=X), cylinder(20, 35, (30, 0, 0), X), cylinder(15, 35, (65, 0, 0), X)
    )
    shaft = chamfer(shaft, 3.0, lambda m: bool(m[0] < 0.1 or m[0] > 99.9))
    return cut(shaft, box((22, 8, 10), (70, -4, 9)))


def keyed_shaft() -> Any:
    """Two diameters with a rounded shoulder, a keyway with round ends, a groove, and a centre."""
    shaft = fuse(cylinder(14, 50, axis=X), cylinder(20, 40, (50, 0, 0), X))
    shaft = fillet(shaft, 3.0, lambda m: bool(abs(m[0] - 50) < 0.1 and np.hypot(*m[1:]) < 15))
    shaft = chamfer(shaft, 2.0, lambda m: bool(m[0] < 0.1 or m[0] > 89.9))
    ends = [cylinder(4, 10, (x, 0, 8)) for x in (12, 32)]
    groove = cut(cylinder(25, 3, (42, 0, 0), X), cylinder(11.5, 3, (42, 0, 0), X))
    return cut(shaft, fuse(box((20, 8, 10), (12, -4, 8)), *ends), groove, cone(5, 0, 5, axis=X))


def spline_vase() -> Any:
    """A turned body with a spline profile between flat ends."""
    z = np.linspace(0.0, 70.0, 8)
    radius = 22.0 + 8.0 * np.sin(z / 11.0)
    profile = spline([(float(r), 0.0, float(height)) for r, height in zip(radius, z, strict=True)])
    low, high = float(radius[0]), float(radius[-1])
    border = wire(
        line((0, 0, 0), (low, 0, 0)),
        profile,
        line((high, 0, 70), (0, 0, 70)),
        line((0, 0, 70), (0, 0, 0)),
    )
    return revolution(disc(border))


def elbow() -> Any:
    """A pipe (radius 12, bore 7) that turns by 90 degrees on radius 30, with two flanges."""
    low = _elbow_half(12.0)
    return cut(
        fuse(low, cylinder(22, 8, (30, 0, -28)), cylinder(22, 8, (-28, 0, 30), X)),
        _elbow_half(7.0),
    )


def _elbow_half(radius: float) -> Any:
    """A solid pipe: straight, a quarter of a torus, straight."""
    upright = cylinder(radius, 28, (30, 0, -28))
    level = cylinder(radius, 28, (-28, 0, 30), X)
    end = disc(wire(_circle((30, 0, 0), radius)))
    bend = BRepPrimAPI_MakeRevol(
        end, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, -1, 0)), float(np.pi / 2)
    ).Shape()
    return fuse(upright, bend, level)


def _circle(at: tuple[float, float, float], radius: float) -> Any:
    return BRepBuilderAPI_MakeEdge(gp_Circ(gp_Ax2(gp_Pnt(*at), gp_Dir(0, 0, 1)), radius)).Edge()
