"""Whether a file gives the shape again that was written to it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from crispline import occt
from crispline.occt.measure import diagonal, tessellate
from crispline.surface.base import Array

_DEFLECTION = 1e-3  # of the diagonal: enough to see that a face can be filled
_ANGLE = 0.5
_SAME = 1e-6  # of the volume
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
    found, wanted = (tessellate(s, _DEFLECTION * diagonal(s), _ANGLE) for s in (copy, shape))
    if len(np.unique(found.faces)) < n_faces:
        return False
    area, volume = float(found.areas().sum()) / factor**2, wanted.volume()
    slack = 2.0 * occt.largest_tolerance(shape, occt.VERTEX) * area
    # Exact integrals take minutes on thousands of B-spline faces. The same faces get the same
    # triangles but for a few, and only these are integrated.
    apex = wanted.vertices.mean(axis=0)
    cones = wanted.cones(apex, n_faces)
    apart = found.cones(factor * apex, n_faces) / factor**3 - cones
    room = slack + _SAME * abs(volume)
    other = np.flatnonzero(np.abs(apart) > room / n_faces)
    if len(other) <= _FEW * n_faces:
        exact = (_cone(copy, other, factor * apex) / factor**3, _cone(shape, other, apex))
        if abs(exact[0] - exact[1] + np.delete(apart, other).sum()) <= room:
            return True
    volume = _volume(shape)
    return bool(abs(_volume(copy) / factor**3 - volume) <= slack + _SAME * abs(volume))


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
