"""A surface of revolution with a spline profile that moves as a whole.

Beside its neighbours only its place is open: the axis may be set parallel to a plane's normal,
or on that of a bore, and the profile along it, until it touches the face that it goes over into.
"""

from __future__ import annotations

import numpy as np

from crispline.fit.frame import frame_about, tilted
from crispline.fit.robust import DistanceModel
from crispline.surface import RevolvedSurface
from crispline.surface.base import Array


def linearise(surface: RevolvedSurface, points: Array) -> tuple[Array, Array]:
    """Signed distances and derivatives by three shifts and two tilts ``(n, 5)``."""
    frame = frame_about(surface.axis)
    feet, normals = surface.project(points)
    arm = (feet - surface.origin) @ frame.T
    inward = -normals @ frame.T
    jacobian = np.empty((len(points), 5))
    jacobian[:, :3] = inward
    # A tilt towards x lifts what lies there and draws in what lies above.
    jacobian[:, 3:] = inward[:, :2] * arm[:, 2:] - inward[:, 2:] * arm[:, :2]
    return np.einsum("ij,ij->i", points - feet, normals), jacobian


def move(surface: RevolvedSurface, step: Array) -> RevolvedSurface:
    """Shift, and tilt about the origin."""
    frame = frame_about(surface.axis)
    return RevolvedSurface(
        surface.origin + step[:3] @ frame, tilted(frame, step[3], step[4]), surface.profile
    )


MODEL = DistanceModel(linearise, move)
