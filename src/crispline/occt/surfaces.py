"""B-spline surfaces as OCCT faces, and back."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepTools import BRepTools
from OCP.collections import Array1_double, Array1_int, Array2_double, Array2_gp_Pnt
from OCP.Geom import Geom_BezierSurface, Geom_BSplineSurface, Geom_RectangularTrimmedSurface
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS_Compound

from crispline import occt
from crispline.errors import ReconstructionError
from crispline.spline.checked import checked_spline
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array

_SAMPLES = 9
_SAME = 1e-6


def surface_to_occt(spline: TensorSpline) -> Any:
    """``Geom_BSplineSurface`` over clamped knots, with the same parameters.

    Knots inside may stand up to ``degree`` times; OCCT takes such a crease for
    what it is, a surface that is only C0 there.
    """
    spline = spline.clamped()
    n_u, n_v = spline.control_points.shape[:2]
    poles = Array2_gp_Pnt(1, n_u, 1, n_v)
    for i, row in enumerate(spline.control_points.tolist(), start=1):
        for j, (x, y, z) in enumerate(row, start=1):
            poles.SetValue(i, j, gp_Pnt(x, y, z))
    net = [poles]
    if spline.weights is not None:
        weights = Array2_double(1, n_u, 1, n_v)
        for i, row in enumerate(spline.weights.tolist(), start=1):
            for j, weight in enumerate(row, start=1):
                weights.SetValue(i, j, weight)
        net.append(weights)
    knots_u, multiplicities_u = _distinct(spline.knots_u)
    knots_v, multiplicities_v = _distinct(spline.knots_v)
    return Geom_BSplineSurface(
        *net,
        *(knots_u, knots_v, multiplicities_u, multiplicities_v),
        *(spline.degree_u, spline.degree_v),
    )


def _distinct(knots: Array) -> tuple[Any, Any]:
    distinct, counts = np.unique(knots, return_counts=True)
    values, multiplicities = Array1_double(1, len(distinct)), Array1_int(1, len(distinct))
    for i, (knot, count) in enumerate(zip(distinct.tolist(), counts.tolist(), strict=True), 1):
        values.SetValue(i, knot)
        multiplicities.SetValue(i, count)
    return values, multiplicities


def surface_from_occt(surface: Any, where: str = "the surface") -> TensorSpline | None:
    """The value of a ``Geom_Surface`` that is a B-spline or Bezier surface, else None.

    Periodic surfaces are opened at their seam and rectangular pieces of surfaces
    cut out; both are exact.

    Raises
    ------
    InputError
        The surface's numbers make no sense; ``where`` begins the sentence.
    """
    basis = surface
    while isinstance(basis, Geom_RectangularTrimmedSurface):
        basis = basis.BasisSurface()
    if not isinstance(basis, Geom_BSplineSurface | Geom_BezierSurface):
        return None
    spline = GeomConvert.SurfaceToBSplineSurface_s(surface)
    is_periodic = spline.IsUPeriodic() or spline.IsVPeriodic()
    if is_periodic:
        spline = Geom_BSplineSurface(spline)  # the file's own is left as it is
        spline.SetUNotPeriodic()
        spline.SetVNotPeriodic()
    poles = [
        [spline.Pole(i, j) for j in _upto(spline.NbVPoles())] for i in _upto(spline.NbUPoles())
    ]
    weights = None
    if spline.IsURational() or spline.IsVRational():
        weights = [
            [spline.Weight(i, j) for j in _upto(spline.NbVPoles())]
            for i in _upto(spline.NbUPoles())
        ]
    value = checked_spline(
        spline.UDegree(),
        spline.VDegree(),
        _values(spline.UKnotSequence()),
        _values(spline.VKnotSequence()),
        [[(p.X(), p.Y(), p.Z()) for p in row] for row in poles],
        weights,
        where,
    )
    # OCCT opens a seam with knots beyond the domain, and closes every closed face it reads.
    return value.clamped() if is_periodic else value


def _values(array: Any) -> list[float]:
    # The bindings can iterate over an array, but thirty times more slowly.
    return [array.Value(i) for i in range(array.Lower(), array.Upper() + 1)]


def _upto(n: int) -> range:
    return range(1, n + 1)


def face_shape(splines: Sequence[TensorSpline]) -> Any:
    """One face for each surface, bounded by the ends of its domain; several form a compound.

    Raises
    ------
    ReconstructionError
        OCCT makes no valid face of a surface.
    """
    faces = [_face(spline, i) for i, spline in enumerate(splines)]
    if len(faces) == 1:
        return faces[0]
    compound, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(compound)
    for face in faces:
        builder.Add(compound, face)
    return compound


def _face(spline: TensorSpline, index: int) -> Any:
    try:
        maker = BRepBuilderAPI_MakeFace(surface_to_occt(spline), occt.CONFUSION)
        face = maker.Face() if maker.IsDone() else None
    except occt.FAILURES:
        face = None
    if face is None or not BRepCheck_Analyzer(face).IsValid():
        size = float(np.ptp(spline.control_points, axis=(0, 1)).max())
        raise ReconstructionError(
            f"surface {index + 1} gives no valid face: expected one that is larger than "
            f"{occt.CONFUSION:g} mm and does not fold onto itself, got one of {size:.3g} mm; "
            "scale it up, or write NPZ or JSON instead"
        )
    return face


@dataclass(frozen=True)
class FoundFaces:
    """The B-spline faces of a shape.

    Attributes
    ----------
    splines : the surface of each, its normal on the face's outer side.
    n_trimmed : how many faces cover a part of their surface that no parameter
        rectangle bounds; of these ``splines`` holds the whole rectangle about it.
    left_out : names of the other kinds of faces, and how many there are.
    """

    splines: tuple[TensorSpline, ...]
    n_trimmed: int
    left_out: Mapping[str, int]


def faces_from_occt(shape: Any, where: str) -> FoundFaces:
    """The B-spline surfaces of the faces of a shape; ``where`` begins any error's sentence."""
    splines: list[TensorSpline] = []
    left_out: Counter[str] = Counter()
    n_trimmed = 0
    for face in occt.subshapes(shape, occt.FACE):
        surface = BRep_Tool.Surface_s(face)
        spline = surface_from_occt(surface, f"{where}, face {len(splines) + 1}")
        if spline is None:
            left_out[_kind(surface)] += 1
            continue
        spline, is_whole = _bounded(spline, face)
        n_trimmed += not is_whole
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            spline = spline.transposed()
        splines.append(spline)
    return FoundFaces(tuple(splines), n_trimmed, dict(left_out))


def face_kinds(shape: Any) -> tuple[str, ...]:
    """Kind of the surface of every face ("plane", "cylinder", "bspline"), in exploration order."""
    return tuple(_kind(BRep_Tool.Surface_s(face)) for face in occt.subshapes(shape, occt.FACE))


def _kind(surface: Any) -> str:
    while isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    name = type(surface).__name__.removeprefix("Geom_").removesuffix("Surface")
    return {
        "Cylindrical": "cylinder",
        "Conical": "cone",
        "Spherical": "sphere",
        "Toroidal": "torus",
        "SurfaceOfLinearExtrusion": "extrusion",
        "SurfaceOfRevolution": "revolution",
    }.get(name, name.lower())


def _bounded(spline: TensorSpline, face: Any) -> tuple[TensorSpline, bool]:
    """The surface cut to the face's parameter rectangle, and whether the face fills that."""
    (u0, u1), (v0, v1) = spline.domain
    found = BRepTools.UVBounds_s(face)
    low = np.clip(found[0::2], [u0, v0], [u1, v1])
    high = np.clip(found[1::2], [u0, v0], [u1, v1])
    room = _SAME * np.array([u1 - u0, v1 - v0])
    low = np.where(low - [u0, v0] <= room, [u0, v0], low)
    high = np.where([u1, v1] - high <= room, [u1, v1], high)
    border = _border_samples(face)
    is_whole = len(occt.subshapes(face, occt.WIRE)) == 1 and bool(
        np.all(np.any(np.minimum(np.abs(border - low), np.abs(border - high)) <= room, axis=1))
    )
    if np.any(high - low <= room) or ((low == [u0, v0]).all() and (high == [u1, v1]).all()):
        return spline, is_whole
    (u0, v0), (u1, v1) = low.tolist(), high.tolist()
    return spline.restricted((u0, u1), (v0, v1)), is_whole


def _border_samples(face: Any) -> Array:
    """Parameters along the edges of a face, shape ``(k, 2)``."""
    samples = []
    for edge in occt.subshapes(face, occt.EDGE):
        for direction in (TopAbs_Orientation.TopAbs_FORWARD, TopAbs_Orientation.TopAbs_REVERSED):
            # The two sides of a seam are one edge with two curves.
            first, last = BRep_Tool.Range_s(edge)
            curve = BRep_Tool.CurveOnSurface_s(
                occt.as_edge(edge.Oriented(direction)), face, first, last
            )
            if curve is not None:
                places = np.linspace(first, last, _SAMPLES)
                samples += [(p.X(), p.Y()) for p in map(curve.Value, places.tolist())]
    return np.array(samples, dtype=float).reshape(-1, 2)


def scaled(spline: TensorSpline, factor: float) -> TensorSpline:
    """The surface with every length multiplied by ``factor``."""
    return replace(spline, control_points=factor * spline.control_points)
