"""Values of the package as OCCT objects, and the few OCCT idioms that every module needs.

OCCT has no type information for mypy, so its objects are ``Any`` here; the
functions that take and return them say in words what they are.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import OCP.Standard
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepTools import BRepTools
from OCP.collections import (
    Array1_double,
    Array1_gp_Pnt,
    Array1_gp_Pnt2d,
    Array1_int,
    Array2_gp_Pnt,
    IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher,
)
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_BSplineSurface,
    Geom_Circle,
    Geom_Line,
    Geom_TrimmedCurve,
)
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Ax1, gp_Ax2, gp_Ax3, gp_Dir, gp_Dir2d, gp_Pnt, gp_Pnt2d, gp_Trsf
from OCP.ShapeFix import ShapeFix_ShapeTolerance
from OCP.TopAbs import TopAbs_ShapeEnum
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS, TopoDS_Shape

from crispline.curve import BSplineCurve, Circle, Curve, Line
from crispline.surface import BSplineSurface, Similarity
from crispline.surface.base import Array

SHELL = TopAbs_ShapeEnum.TopAbs_SHELL
SOLID = TopAbs_ShapeEnum.TopAbs_SOLID
FACE = TopAbs_ShapeEnum.TopAbs_FACE
WIRE = TopAbs_ShapeEnum.TopAbs_WIRE
EDGE = TopAbs_ShapeEnum.TopAbs_EDGE
VERTEX = TopAbs_ShapeEnum.TopAbs_VERTEX

CONFUSION = 1e-7
"""OCCT's absolute resolution: two points closer than this are one."""

FAILURES: tuple[type[Exception], ...] = tuple(
    kind
    for kind in vars(OCP.Standard).values()
    if isinstance(kind, type) and issubclass(kind, Exception)
)
"""What OCCT raises; the bindings do not tell that these have a common base."""

_CASTS = {
    SOLID: TopoDS.Solid,
    SHELL: TopoDS.Shell,
    FACE: TopoDS.Face,
    WIRE: TopoDS.Wire,
    EDGE: TopoDS.Edge,
    VERTEX: TopoDS.Vertex,
}


def point(position: Array) -> Any:
    """``gp_Pnt`` of a position, shape ``(3,)``."""
    return gp_Pnt(float(position[0]), float(position[1]), float(position[2]))


def direction(vector: Array) -> Any:
    """``gp_Dir`` of a vector, shape ``(3,)``."""
    return gp_Dir(float(vector[0]), float(vector[1]), float(vector[2]))


def frame(origin: Array, axis: Array, x_axis: Array) -> Any:
    """``gp_Ax3``: right-handed frame with ``axis`` as its z axis."""
    return gp_Ax3(point(origin), direction(axis), direction(x_axis))


def axis(origin: Array, heading: Array) -> Any:
    """``gp_Ax1``: the line through ``origin`` along a unit vector, both shape ``(3,)``."""
    return gp_Ax1(point(origin), direction(heading))


def curve_to_occt(curve: Curve) -> Any:
    """``Geom_Curve`` with the same parameter as the curve."""
    match curve:
        case Line():
            return Geom_Line(point(curve.origin), direction(curve.direction))
        case Circle():
            axes = gp_Ax2(point(curve.centre), direction(curve.normal), direction(curve.x_axis))
            return Geom_Circle(axes, float(curve.radius))
        case BSplineCurve():
            poles = Array1_gp_Pnt(1, len(curve.control_points))
            for i, position in enumerate(curve.control_points, start=1):
                poles.SetValue(i, point(position))
            return Geom_BSplineCurve(poles, *_knots(curve.knots), 3)
    raise TypeError(f"no OCCT curve for {type(curve).__name__}")


def untrimmed(curve: Any) -> Any:
    """The whole of a ``Geom_Curve``: the circle, not an arc of it."""
    return curve.BasisCurve() if isinstance(curve, Geom_TrimmedCurve) else curve


def bspline_surface(surface: BSplineSurface) -> Any:
    """``Geom_BSplineSurface`` with the same parameters as the surface."""
    n_u, n_v = surface.control_points.shape[:2]
    poles = Array2_gp_Pnt(1, n_u, 1, n_v)
    for i in range(n_u):
        for j in range(n_v):
            poles.SetValue(i + 1, j + 1, point(surface.control_points[i, j]))
    knots_u, multiplicities_u = _knots(surface.knots_u)
    knots_v, multiplicities_v = _knots(surface.knots_v)
    return Geom_BSplineSurface(poles, knots_u, knots_v, multiplicities_u, multiplicities_v, 3, 3)


def line_2d(start: Array, heading: Array) -> Any:
    """``Geom2d_Line`` through ``start`` along unit ``heading``, both shape ``(2,)``."""
    return Geom2d_Line(
        gp_Pnt2d(float(start[0]), float(start[1])), gp_Dir2d(float(heading[0]), float(heading[1]))
    )


def bspline_2d(knots: Array, control_points: Array, degree: int) -> Any:
    """``Geom2d_BSplineCurve``; ``control_points`` has shape ``(n, 2)``."""
    poles = Array1_gp_Pnt2d(1, len(control_points))
    for i, (u, v) in enumerate(control_points, start=1):
        poles.SetValue(i, gp_Pnt2d(float(u), float(v)))
    return Geom2d_BSplineCurve(poles, *_knots(knots), degree)


def _knots(knots: Array) -> tuple[Any, Any]:
    """Distinct knots and their multiplicities."""
    distinct, counts = np.unique(knots, return_counts=True)
    values, multiplicities = Array1_double(1, len(distinct)), Array1_int(1, len(distinct))
    for i, (knot, count) in enumerate(zip(distinct, counts, strict=True), start=1):
        values.SetValue(i, float(knot))
        multiplicities.SetValue(i, int(count))
    return values, multiplicities


def subshapes(shape: Any, kind: Any) -> list[Any]:
    """Distinct subshapes of one kind (``FACE``, ``EDGE``, ...), in exploration order."""
    found = IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapes_s(shape, kind, found)
    return [_CASTS[kind](found.FindKey(i)) for i in range(1, found.Size() + 1)]


def as_edge(shape: Any) -> Any:
    """A ``TopoDS_Shape`` that is known to be an edge, as a ``TopoDS_Edge``."""
    return TopoDS.Edge(shape)


def largest_tolerance(shape: Any, kind: Any) -> float:
    """Largest tolerance of the subshapes of one kind; 0 if there is none."""
    return float(BRep_Tool.MaxTolerance_s(shape, kind))


def transform(shape: Any, similarity: Similarity) -> Any:
    """The image of a shape under a similarity, with geometry of its own.

    A shape is best built where its point spacing is about 1, since OCCT's
    tolerances are absolute, and then brought to the user's unit with this.
    Tolerances follow the scale but never fall below ``CONFUSION``.
    """
    matrix = similarity.scale * similarity.rotation
    shift = similarity.translation
    rows = np.column_stack([matrix, shift]).ravel()
    trsf = gp_Trsf()
    trsf.SetValues(*(float(value) for value in rows))
    image = BRepBuilderAPI_Transform(shape, trsf, True).Shape()
    ShapeFix_ShapeTolerance().LimitTolerance(image, CONFUSION)
    return image


def to_text(shape: Any) -> bytes:
    """The shape in OCCT's own text format; exact, and the same for equal shapes."""
    stream = io.BytesIO()
    BRepTools.Write_s(shape, stream)
    return stream.getvalue()


def from_text(text: bytes) -> Any:
    """Inverse of :func:`to_text`."""
    shape = TopoDS_Shape()
    BRepTools.Read_s(shape, io.BytesIO(text), BRep_Builder())
    return shape
