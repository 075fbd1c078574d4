"""Whether a file gives the shape again that was written to it."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from crispline import occt
from crispline.occt.measure import diagonal, tessellate

_DEFLECTION = 1e-3  # of the diagonal: enough to see that a face can be filled
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
    found, wanted = (tessellate(s, _DEFLECTION * diagonal(s), _ANGLE) for s in (copy, shape))
    if len(np.unique(found.faces)) < n_faces:
        return False
    area = float(found.areas().sum()) / factor**2
    slack = 2.0 * occt.largest_tolerance(shape, occt.VERTEX) * area
    # The same faces get the same triangles. Only where they do not, exact integrals tell: these
    # take minutes on thousands of B-spline faces.
    volumes = found.volume() / factor**3, wanted.volume()
    if _agree(*volumes, slack):
        return True
    return _agree(_volume(copy) / factor**3, _volume(shape), slack)


def _agree(found: float, wanted: float, slack: float) -> bool:
    return abs(found - wanted) <= slack + 1e-6 * abs(wanted)


def _volume(shape: Any) -> float:
    """Volume by one Gauss rule a span.

    Not as exact as `crispline.occt.measure`, which is slow on large B-spline faces, but
    wrong in the same way for the same faces.
    """
    inside = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, inside)
    return float(inside.Mass())
