"""The surfaces under the faces of any shape as values, and nearest points on all of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepTools import BRepTools
from OCP.Geom import (
    Geom_BSplineCurve,
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
    Geom_RectangularTrimmedSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
)
from OCP.GeomConvert import GeomConvert

from crispline import occt
from crispline.errors import InputError
from crispline.occt.surfaces import surface_from_occt
from crispline.spline.atlas import Atlas, build_atlas
from crispline.spline.tensor import TensorSpline
from crispline.surface import (
    Cone,
    Cylinder,
    Plane,
    Profile,
    RevolvedSurface,
    Sphere,
    Surface,
    Torus,
)
from crispline.surface.base import Array, unit
from crispline.surface.basis import DEGREE

Index = NDArray[np.int64]

_PLANAR = 1e-7
"""A meridian that leaves its plane by less than this share of its size is a plane curve."""


@dataclass(frozen=True, eq=False)
class Carriers:
    """The whole, untrimmed surfaces under the faces of a shape.

    Attributes
    ----------
    elementary : planes, cylinders, cones, spheres, tori and cubic B-splines turned about an
        axis, by the index of the face.
    atlases : all other surfaces as splines, one atlas for each pair of degrees.
    atlas : which of ``atlases`` holds a face's surface; -1 for none, shape ``(n_faces,)``.
    place : and at which place in it, shape ``(n_faces,)``.
    """

    elementary: dict[int, Surface]
    atlases: tuple[Atlas, ...]
    atlas: Index
    place: Index

    def project(self, points: Array, face: Index) -> tuple[Array, Array]:
        """Nearest points on the surface of the face that is named for each point.

        Parameters
        ----------
        points : shape ``(n, 3)``.
        face : shape ``(n,)``.

        Returns
        -------
        feet, normals : shape ``(n, 3)``; normals on the surface's own side.
        """
        feet, normals = np.empty((len(points), 3)), np.empty((len(points), 3))
        if not len(points):
            return feet, normals
        order = np.argsort(face, kind="stable")
        found, start = np.unique(face[order], return_index=True)
        for index, mine in zip(found, np.split(order, start[1:]), strict=True):
            if index in self.elementary:
                feet[mine], normals[mine] = self.elementary[int(index)].project(points[mine])
        for number, atlas in enumerate(self.atlases):
            mine = np.flatnonzero(self.atlas[face] == number)
            feet[mine], normals[mine] = atlas.project(points[mine], self.place[face[mine]])
        return feet, normals

    def described(self) -> list[tuple[str, Mapping[str, float | list[float]]]]:
        """Kind and parameters of the surface of each face."""
        splines: tuple[str, Mapping[str, float | list[float]]] = ("bspline", {})
        return [
            (self.elementary[i].kind, self.elementary[i].parameters())
            if i in self.elementary
            else splines
            for i in range(len(self.atlas))
        ]


def carriers(faces: list[Any]) -> Carriers:
    """The surfaces under faces of any kind that OCCT knows.

    Raises
    ------
    InputError
        A surface is no elementary one and cannot be brought to a B-spline either.
    """
    elementary: dict[int, Surface] = {}
    splines: dict[tuple[int, int], list[tuple[int, TensorSpline]]] = {}
    for index, face in enumerate(faces):
        surface = _elementary(face)
        if surface is not None:
            elementary[index] = surface
            continue
        spline = _spline(face, index)
        splines.setdefault((spline.degree_u, spline.degree_v), []).append((index, spline))
    atlas, place = np.full(len(faces), -1), np.zeros(len(faces), dtype=np.int64)
    for number, group in enumerate(splines.values()):
        members = [index for index, _ in group]
        atlas[members], place[members] = number, np.arange(len(group))
    atlases = tuple(build_atlas([spline for _, spline in group]) for group in splines.values())
    return Carriers(elementary, atlases, atlas, place)


def _elementary(face: Any) -> Surface | None:
    """The surface as one of ours, its normal on a side of its own; None for any other kind."""
    surface = BRep_Tool.Surface_s(face)
    while isinstance(surface, Geom_RectangularTrimmedSurface):
        surface = surface.BasisSurface()
    match surface:
        case Geom_Plane():
            frame = surface.Pln().Position()
            return Plane(_vector(frame.Location()), _vector(frame.Direction()))
        case Geom_CylindricalSurface():
            frame = surface.Cylinder().Position()
            return Cylinder(
                _vector(frame.Location()), unit(_vector(frame.Direction())), surface.Radius()
            )
        case Geom_ConicalSurface():
            cone = surface.Cone()
            apex, axis = _vector(cone.Apex()), _vector(cone.Axis().Direction())
            u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
            middle = _vector(surface.Value(0.5 * (u0 + u1), 0.5 * (v0 + v1)))
            side = 1.0 if (middle - apex) @ axis >= 0.0 else -1.0
            return Cone(apex, side * axis, abs(cone.SemiAngle()))
        case Geom_SphericalSurface():
            return Sphere(_vector(surface.Sphere().Location()), surface.Radius())
        case Geom_ToroidalSurface() if surface.MajorRadius() > surface.MinorRadius():
            frame = surface.Torus().Position()
            return Torus(
                _vector(frame.Location()),
                _vector(frame.Direction()),
                surface.MajorRadius(),
                surface.MinorRadius(),
            )
        case Geom_SurfaceOfRevolution():
            return _revolved(surface, BRepTools.UVBounds_s(face)[2:])
    return None


def _revolved(surface: Any, within: tuple[float, float]) -> RevolvedSurface | None:
    """A surface whose meridian is a plain cubic B-spline to one side of its axis; else None.

    Only the piece that the face needs: the whole may have a nearer point beyond the face.
    """
    curve = occt.untrimmed(surface.BasisCurve())
    if not isinstance(curve, Geom_BSplineCurve) or curve.Degree() != DEGREE:
        return None
    if curve.IsRational() or curve.IsPeriodic():
        return None
    line = surface.Axis()
    origin, axis = _vector(line.Location()), _vector(line.Direction())
    offset = np.array([_vector(curve.Pole(i + 1)) for i in range(curve.NbPoles())]) - origin
    heights = offset @ axis
    radial = offset - np.outer(heights, axis)
    radii = np.linalg.norm(radial, axis=1)
    outward = unit(radial.sum(axis=0))
    if np.abs(radial - np.outer(radii, outward)).max() > _PLANAR * np.abs(offset).max():
        return None
    knots = [[curve.Knot(i + 1)] * curve.Multiplicity(i + 1) for i in range(curve.NbKnots())]
    profile = Profile(np.concatenate(knots), np.column_stack([radii, heights]))
    low, high = np.clip(within, *profile.interval).tolist()
    return RevolvedSurface(origin, axis, profile.between(low, high) if low < high else profile)


def _vector(position: Any) -> Array:
    return np.array([position.X(), position.Y(), position.Z()])


def _spline(face: Any, index: int) -> TensorSpline:
    """The surface as a spline: extrusions and revolutions exactly, offsets approximately."""
    where = f"face {index}"
    surface = BRep_Tool.Surface_s(face)
    spline = surface_from_occt(surface, where)
    if spline is not None:
        return spline
    try:
        u0, u1, v0, v1 = BRepTools.UVBounds_s(face)
        piece = Geom_RectangularTrimmedSurface(surface, u0, u1, v0, v1)
        spline = surface_from_occt(GeomConvert.SurfaceToBSplineSurface_s(piece), where)
    except occt.FAILURES:
        spline = None
    if spline is None:
        raise InputError(
            f"{where}: expected a surface that can be brought to a B-spline, found a "
            f"{type(surface).__name__.removeprefix('Geom_')}; convert the faces to B-splines "
            "(NURBS) where the file was made"
        )
    return spline
