"""Whether a file gives the shape again that was written to it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from crispline import occt
from crispline.occt.measure import diagonal, tessellate
from crispline.occt.surfaces import surface_from_occt
from crispline.surface.base import Array

_DEFLECTION = 1e-3  # of the diagonal: enough to see that a face can be filled
_ANGLE = 0.5
_SAME = 1e-6  # of the volume
_ROUNDING = 1e-12  # of the largest coordinate: the numbers in a file have 16 digits
_FEW = 0.5  # share of the faces of which single integrals are worth while


def is_same_solid(copy: Any, shape: Any, factor: float = 1.0) -> bool:
    """Whether what was read is the shape, as far as its tolerances leave it room.

    Parameters
    ----------
    copy : what was read, or None if nothing was.
    shape : what was written.
    factor : lengths of the copy over lengths of the shape.

    Returns
    -------
    True if the copy is valid, every face of it can be triangulated, and the numbers
    of faces and the volumes agree.
    """
    if copy is None or not BRepCheck_Analyzer(copy).IsValid():
        return False
    n_faces = len(occt.subshapes(shape, occt.FACE))
    if n_faces != len(occt.subshapes(copy, occt.FACE)):
        return False
    deflection = _DEFLECTION * diagonal(shape)
    found, wanted = (
        tessellate(s, deflection * times, _ANGLE) for s, times in ((copy, factor), (shape, 1.0))
    )
    if len(np.unique(found.faces)) < n_faces:
        return False
    area, volume = float(found.areas().sum()) / factor**2, wanted.volume()
    slack = 2.0 * occt.largest_tolerance(shape, occt.VERTEX) * area
    # Exact integrals take minutes on thousands of B-spline faces. The same faces get the same
    # triangles but for a few, and of these only those are integrated whose surfaces differ, or
    # that are filled to another extent.
    apex = wanted.vertices.mean(axis=0)
    cones = wanted.cones(apex, n_faces)
    apart = found.cones(factor * apex, n_faces) / factor**3 - cones
    room = slack + _SAME * abs(volume)
    differs = np.abs(apart) > room / n_faces
    areas = np.bincount(wanted.faces, wanted.areas(), minlength=n_faces)
    is_filled_alike = np.abs(apart) <= deflection * areas
    faces = [occt.subshapes(one, occt.FACE) for one in (copy, shape)]
    alike = [
        index
        for index in np.flatnonzero(differs & is_filled_alike)
        if _is_same_spline(faces[0][index], faces[1][index], factor)
    ]
    apart[differs] = 0.0
    differs[alike] = False
    other = np.flatnonzero(differs)
    if len(other) <= _FEW * n_faces:
        exact = (_cone(copy, other, factor * apex) / factor**3, _cone(shape, other, apex))
        if abs(exact[0] - exact[1] + apart.sum()) <= room:
            return True
    volume = _volume(shape)
    return bool(abs(_volume(copy) / factor**3 - volume) <= slack + _SAME * abs(volume))


def _is_same_spline(copy: Any, face: Any, factor: float) -> bool:
    """Whether two faces lie on the same B-spline surface, but for rounding."""
    found, wanted = (surface_from_occt(BRep_Tool.Surface_s(one)) for one in (copy, face))
    if found is None or wanted is None or found.control_points.shape != wanted.control_points.shape:
        return False
    room = _ROUNDING * float(np.abs(wanted.control_points).max())
    weights = [
        np.ones(1) if one.weights is None else one.weights / one.weights.max()
        for one in (found, wanted)
    ]
    knots = [
        (one_knots - one_knots[0]) / np.ptp(one_knots)
        for one in (found, wanted)
        for one_knots in (one.knots_u, one.knots_v)
    ]
    return (
        bool(np.abs(found.control_points / factor - wanted.control_points).max() <= room)
        and np.allclose(weights[0], weights[1], rtol=0.0, atol=_ROUNDING)
        and all(
            len(one) == len(other) and np.allclose(one, other, rtol=0.0, atol=_ROUNDING)
            for one, other in zip(knots[:2], knots[2:], strict=True)
        )
    )


def _cone(shape: Any, faces: NDArray[np.int64], apex: Array) -> float:
    """Volume of the cones from a point to some faces, by one Gauss rule a span."""
    inside = GProp_GProps(occt.point(apex))
    known = occt.subshapes(shape, occt.FACE)
    for index in faces.tolist():
        part = GProp_GProps(occt.point(apex))
        BRepGProp.VolumeProperties_s(known[index], part)
        inside.Add(part)
    return float(inside.Mass())


def _volume(shape: Any) -> float:
    """Volume by one Gauss rule a span.

    Not as exact as `crispline.occt.measure`, which is slow on large B-spline faces, but
    wrong in the same way for the same faces.
    """
    inside = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, inside)
    return float(inside.Mass())
