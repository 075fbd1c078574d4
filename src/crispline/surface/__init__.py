"""Surfaces that regions are fitted with: exact geometry, no fitting."""

from crispline.surface.base import Similarity, Surface, perpendicular_frame, unit
from crispline.surface.bspline import BSplineSurface
from crispline.surface.cone import Cone
from crispline.surface.cylinder import Cylinder
from crispline.surface.extruded import ExtrudedSurface
from crispline.surface.plane import Plane
from crispline.surface.profile import Profile
from crispline.surface.revolved import RevolvedSurface
from crispline.surface.sphere import Sphere
from crispline.surface.torus import Torus

FREE_FORMS = ("bspline", "revolution")
"""Kinds that are no primitives: a spline is in them."""

__all__ = [
    "FREE_FORMS",
    "BSplineSurface",
    "Cone",
    "Cylinder",
    "ExtrudedSurface",
    "Plane",
    "Profile",
    "RevolvedSurface",
    "Similarity",
    "Sphere",
    "Surface",
    "Torus",
    "perpendicular_frame",
    "unit",
]
