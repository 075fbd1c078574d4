"""Short names for the few OCCT operations that the parts are made with.

Lengths are in the unit of the part, angles in radians. A shape is a ``TopoDS_Shape``;
the bindings have no type information, so it is ``Any`` here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
from OCP.BRepBuilderAPI import (
    BRepBuilderAPI_MakeEdge,
    BRepBuilderAPI_MakeFace,
    BRepBuilderAPI_MakePolygon,
    BRepBuilderAPI_MakeWire,
)
from OCP.BRepFilletAPI import BRepFilletAPI_MakeChamfer, BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakePrism,
    BRepPrimAPI_MakeRevol,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.collections import HArray1_gp_Pnt
from OCP.GeomAPI import GeomAPI_Interpolate
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Vec
from OCP.ShapeUpgrade import ShapeUpgrade_UnifySameDomain

from crispline import occt
from crispline.surface.base import Array

Place = Sequence[float]
X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
ORIGIN = (0.0, 0.0, 0.0)


def box(size: Place, at: Place = ORIGIN) -> Any:
    """A box with its lowest corner at ``at``."""
    return BRepPrimAPI_MakeBox(gp_Pnt(*at), *size).Shape()


def cylinder(radius: float, height: float, at: Place = ORIGIN, axis: Place = Z) -> Any:
    """A cylinder from ``at`` along ``axis``."""
    return BRepPrimAPI_MakeCylinder(_frame(at, axis), radius, height).Shape()


def cone(low: float, high: float, height: float, at: Place = ORIGIN, axis: Place = Z) -> Any:
    """A cone whose radius goes from ``low`` at ``at`` to ``high``; 0 is a tip."""
    return BRepPrimAPI_MakeCone(_frame(at, axis), low, high, height).Shape()


def sphere(radius: float, at: Place = ORIGIN) -> Any:
    """A whole ball."""
    return BRepPrimAPI_MakeSphere(gp_Pnt(*at), radius).Shape()


def torus(major: float, minor: float, at: Place = ORIGIN, axis: Place = Z) -> Any:
    """A whole ring."""
    return BRepPrimAPI_MakeTorus(_frame(at, axis), major, minor).Shape()


def polygon(points: Iterable[Place]) -> Any:
    """A closed wire of straight edges."""
    maker = BRepBuilderAPI_MakePolygon()
    for point in points:
        maker.Add(gp_Pnt(*point))
    maker.Close()
    return maker.Wire()


def spline(points: Iterable[Place], is_closed: bool = False) -> Any:
    """An edge on the cubic B-spline that interpolates points; C2, closed ones too."""
    places = np.asarray(list(points), dtype=float)
    poles = HArray1_gp_Pnt(1, len(places))
    for index, place in enumerate(places, start=1):
        poles.SetValue(index, gp_Pnt(*map(float, place)))
    fit = GeomAPI_Interpolate(poles, is_closed, 1e-9)
    fit.Perform()
    return BRepBuilderAPI_MakeEdge(fit.Curve()).Edge()


def line(start: Place, end: Place) -> Any:
    """A straight edge."""
    return BRepBuilderAPI_MakeEdge(gp_Pnt(*start), gp_Pnt(*end)).Edge()


def wire(*edges: Any) -> Any:
    """A wire of edges in their order."""
    return BRepBuilderAPI_MakeWire(*edges).Wire()


def disc(border: Any) -> Any:
    """The planar face inside a closed wire."""
    return BRepBuilderAPI_MakeFace(border, True).Face()


def prism(profile: Any, along: Place) -> Any:
    """What a profile sweeps: a face gives a solid, a wire a shell."""
    return BRepPrimAPI_MakePrism(profile, gp_Vec(*along)).Shape()


def revolution(profile: Any, axis: Place = Z) -> Any:
    """What a profile sweeps in a whole turn about an axis through the origin."""
    return BRepPrimAPI_MakeRevol(profile, gp_Ax1(gp_Pnt(*ORIGIN), gp_Dir(*axis))).Shape()


def fuse(first: Any, *others: Any) -> Any:
    """The union, faces on one surface made one."""
    for other in others:
        first = BRepAlgoAPI_Fuse(first, other).Shape()
    return unified(first)


def cut(first: Any, *tools: Any) -> Any:
    """The first without the tools, faces on one surface made one."""
    for tool in tools:
        first = BRepAlgoAPI_Cut(first, tool).Shape()
    return unified(first)


def unified(shape: Any) -> Any:
    """Neighbouring faces on one surface as one face, edges on one curve as one edge."""
    upgrade = ShapeUpgrade_UnifySameDomain(shape, True, True, False)
    upgrade.Build()
    return upgrade.Shape()


def edges_where(shape: Any, is_chosen: Callable[[Array], bool]) -> list[Any]:
    """Edges whose middle (in parameter) fulfils a condition."""
    return [edge for edge in occt.subshapes(shape, occt.EDGE) if is_chosen(_middle(edge))]


def fillet(shape: Any, radius: float, is_chosen: Callable[[Array], bool]) -> Any:
    """Round the edges that fulfil a condition."""
    maker = BRepFilletAPI_MakeFillet(shape)
    for edge in edges_where(shape, is_chosen):
        maker.Add(radius, edge)
    return maker.Shape()


def tapered_fillet(shape: Any, start: float, end: float, is_chosen: Callable[[Array], bool]) -> Any:
    """Round edges with a radius that goes evenly from ``start`` to ``end``."""
    maker = BRepFilletAPI_MakeFillet(shape)
    for edge in edges_where(shape, is_chosen):
        maker.Add(start, end, edge)
    return maker.Shape()


def chamfer(shape: Any, width: float, is_chosen: Callable[[Array], bool]) -> Any:
    """Break the edges that fulfil a condition."""
    maker = BRepFilletAPI_MakeChamfer(shape)
    for edge in edges_where(shape, is_chosen):
        maker.Add(width, edge)
    return maker.Shape()


def ring(count: int, radius: float, height: float, phase: float = 0.0) -> list[tuple[float, ...]]:
    """Places evenly on a circle about the z axis."""
    turns = phase + 2.0 * np.pi * np.arange(count) / count
    return [(radius * np.cos(t), radius * np.sin(t), height) for t in map(float, turns)]


def _middle(edge: Any) -> Array:
    curve = BRepAdaptor_Curve(edge)
    point = curve.Value(0.5 * (curve.FirstParameter() + curve.LastParameter()))
    return np.array([point.X(), point.Y(), point.Z()])


def _frame(at: Place, axis: Place) -> Any:
    return gp_Ax2(gp_Pnt(*at), gp_Dir(*axis))
