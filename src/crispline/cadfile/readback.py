"""Whether a file gives the shape again that was written to it."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from crispline import occt
from crispline.occt.measure import tessellate

_DEFLECTION = 1e-3  # of the root of the area: enough to see that a face can be filled
_ANGLE = 0.5


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
    area, volume = _integrals(shape)
    mesh = tessellate(copy, _DEFLECTION * factor * float(np.sqrt(area)), _ANGLE)
    if len(np.unique(mesh.faces)) < n_faces:
        return False
    slack = 2.0 * occt.largest_tolerance(shape, occt.VERTEX)
    room = slack * area + 1e-6 * abs(volume)
    return bool(abs(_integrals(copy)[1] / factor**3 - volume) <= room)


def _integrals(shape: Any) -> tuple[float, float]:
    """Area and volume by one Gauss rule a span.

    Not as exact as `crispline.occt.measure`, which is slow on large B-spline faces, but
    wrong in the same way for the same faces.
    """
    surface, inside = GProp_GProps(), GProp_GProps()
    BRepGProp.SurfaceProperties_s(shape, surface)
    BRepGProp.VolumeProperties_s(shape, inside)
    return float(surface.Mass()), float(inside.Mass())
