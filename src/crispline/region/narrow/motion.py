"""The motion that sweeps two faces: it makes what is across their border a problem in the plane."""

from __future__ import annotations

import numpy as np

from crispline.fit.swept import Revolution, Sweep, Translation
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Cylinder, Plane, Surface
from crispline.surface.base import Array

MIN_ANGLE = np.radians(25.0)
"""Between the normals of two faces that meet at an angle."""

_MAX_TILT = np.radians(3.0)  # of surfaces that count as being about one axis or along it ...
_MAX_OFFSET = 0.5  # ... within so much, spacings


def common_sweep(first: RegionFit, second: RegionFit, *, bent: bool) -> Sweep | None:
    """The motion that both surfaces are swept by; None if there is none.

    With ``bent`` a cylinder may be swept along its axis, beside a plane or cylinder.
    """
    if not (first.is_accepted and second.is_accepted):
        return None
    for one, other in ((first.surface, second.surface), (second.surface, first.surface)):
        if isinstance(one, Plane) and isinstance(other, Plane):
            across = np.cross(one.normal, other.normal)
            length = float(np.linalg.norm(across))
            return Translation(across / length) if length > np.sin(MIN_ANGLE) else None
        axis = _axis(one)
        if axis is not None and _is_about(other, axis):
            return axis
        if bent and isinstance(one, Cylinder) and _is_along(other, one.axis):
            return Translation(one.axis)
    return None


def _axis(surface: Surface) -> Revolution | None:
    match surface:
        case Cylinder():
            return Revolution(surface.origin, surface.axis)
        case Cone():
            return Revolution(surface.apex, surface.axis)
    return None


def _is_about(surface: Surface, axis: Revolution) -> bool:
    """Whether a plane lies across an axis, or a cylinder or cone is about it."""
    if isinstance(surface, Plane):
        return bool(abs(surface.normal @ axis.axis) > np.cos(_MAX_TILT))
    own = _axis(surface)
    if own is None or abs(own.axis @ axis.axis) < np.cos(_MAX_TILT):
        return False
    return bool(np.linalg.norm(np.cross(own.origin - axis.origin, axis.axis)) < _MAX_OFFSET)


def _is_along(surface: Surface, direction: Array) -> bool:
    """Whether a plane or cylinder is swept straight along a direction."""
    match surface:
        case Plane():
            return bool(abs(surface.normal @ direction) < np.sin(_MAX_TILT))
        case Cylinder():
            return bool(abs(surface.axis @ direction) > np.cos(_MAX_TILT))
    return False
