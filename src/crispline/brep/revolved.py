"""Parameter planes of surfaces of revolution.

They are parametrised the way OCCT and STEP do it: ``u`` turns about the axis from the frame's
x axis, ``v`` runs along the profile. The choice of that x axis is the choice of the seam.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_SphericalSurface,
    Geom_SurfaceOfRevolution,
    Geom_ToroidalSurface,
)

from crispline import occt
from crispline.brep.chart import TURN, UNBOUNDED, Chart
from crispline.curve import BSplineCurve
from crispline.surface import Profile
from crispline.surface.base import Array

POLE_REACH = 0.5
"""A border that comes this close to a pole goes through it, in spacings."""


@dataclass(frozen=True)
class RevolutionChart(Chart):
    """Angle ``u`` about an axis, and a parameter ``v`` along a profile.

    Attributes
    ----------
    origin : zero of the profile's height, shape ``(3,)``.
    axis, x_axis : orthogonal unit vectors, shape ``(3,)``; ``u`` is 0 along ``x_axis``.
    """

    origin: Array
    axis: Array
    x_axis: Array
    is_periodic = (True, False)
    u_range = (0.0, TURN)

    @abstractmethod
    def profile(self, v: Array) -> tuple[Array, Array]:
        """Radius about the axis and height along it."""

    @abstractmethod
    def profile_parameter(self, radius: Array, height: Array) -> Array:
        """``v`` of the nearest profile point."""

    @property
    def frame(self) -> Any:
        """The ``gp_Ax3`` that the OCCT surface stands in."""
        return occt.frame(self.origin, self.axis, self.x_axis)

    def parameters(self, points: Array) -> Array:
        offset = points - self.origin
        height = offset @ self.axis
        x, y = offset @ self.x_axis, offset @ np.cross(self.axis, self.x_axis)
        v = self.profile_parameter(np.hypot(x, y), height)
        return np.column_stack([np.arctan2(y, x), v])

    def trace(self, points: Array, t: Array) -> Array:
        uv = self.parameters(points)
        for pole in self.pole_points():
            distance = np.linalg.norm(points - pole, axis=1)
            is_lost = distance < POLE_REACH
            if not is_lost.any() or is_lost.all():
                continue
            # The angle is undefined here: take the neighbour's along the polyline.
            lost, known = np.flatnonzero(is_lost), np.flatnonzero(~is_lost)
            uv[lost, 0] = uv[known[np.abs(lost[:, None] - known).argmin(axis=1)], 0]
            v_pole = self.parameters(pole[None, :])[0, 1]
            for end in (0, -1):
                if is_lost[end]:  # a border that ends here ends in the pole itself
                    share = np.clip(1.0 - distance / (4.0 * POLE_REACH), 0.0, 1.0)
                    uv[:, 1] += share / share[end] * (v_pole - uv[end, 1])
        return self._unwrapped(uv)

    def pole_points(self) -> list[Array]:
        """Places of the poles, each of shape ``(3,)``."""
        heights = [v for v, is_pole in zip(self.v_range, self.has_pole, strict=True) if is_pole]
        return list(self.points(np.array([[0.0, v] for v in heights]).reshape(-1, 2)))

    def points(self, parameters: Array) -> Array:
        u = parameters[:, 0]
        radius, height = self.profile(parameters[:, 1])
        y_axis = np.cross(self.axis, self.x_axis)
        around = np.cos(u)[:, None] * self.x_axis + np.sin(u)[:, None] * y_axis
        return np.asarray(self.origin + radius[:, None] * around + height[:, None] * self.axis)


@dataclass(frozen=True)
class CylinderChart(RevolutionChart):
    """Profile ``(R, v)``."""

    radius: float
    v_range = UNBOUNDED

    @property
    def geometry(self) -> Any:
        return Geom_CylindricalSurface(self.frame, float(self.radius))

    def profile(self, v: Array) -> tuple[Array, Array]:
        return np.full_like(v, self.radius), v

    def profile_parameter(self, radius: Array, height: Array) -> Array:
        return height


@dataclass(frozen=True)
class ConeChart(RevolutionChart):
    """Profile ``(R + v sin a, v cos a)``; the apex is the lower border of ``v``."""

    radius: float
    half_angle: float
    has_pole = (True, False)

    @property
    def v_range(self) -> tuple[float, float]:
        return -self.radius / float(np.sin(self.half_angle)), np.inf

    @property
    def geometry(self) -> Any:
        return Geom_ConicalSurface(self.frame, float(self.half_angle), float(self.radius))

    def profile(self, v: Array) -> tuple[Array, Array]:
        return self.radius + v * np.sin(self.half_angle), v * np.cos(self.half_angle)

    def profile_parameter(self, radius: Array, height: Array) -> Array:
        slope, rise = np.sin(self.half_angle), np.cos(self.half_angle)
        along = (radius - self.radius) * slope + height * rise
        return np.asarray(np.maximum(along, self.v_range[0]))


@dataclass(frozen=True)
class SphereChart(RevolutionChart):
    """Profile ``(R cos v, R sin v)``."""

    radius: float
    has_pole = (True, True)
    v_range = (-np.pi / 2, np.pi / 2)

    @property
    def geometry(self) -> Any:
        return Geom_SphericalSurface(self.frame, float(self.radius))

    def profile(self, v: Array) -> tuple[Array, Array]:
        return self.radius * np.cos(v), self.radius * np.sin(v)

    def profile_parameter(self, radius: Array, height: Array) -> Array:
        return np.arctan2(height, radius)


@dataclass(frozen=True)
class TorusChart(RevolutionChart):
    """Profile ``(M + m cos v, m sin v)``, cut open at ``v_start``."""

    major_radius: float
    minor_radius: float
    v_start: float = 0.0
    is_periodic = (True, True)

    @property
    def v_range(self) -> tuple[float, float]:
        return self.v_start, self.v_start + TURN

    @property
    def geometry(self) -> Any:
        return Geom_ToroidalSurface(self.frame, float(self.major_radius), float(self.minor_radius))

    def profile(self, v: Array) -> tuple[Array, Array]:
        return self.major_radius + self.minor_radius * np.cos(v), self.minor_radius * np.sin(v)

    def profile_parameter(self, radius: Array, height: Array) -> Array:
        return np.arctan2(height, radius - self.major_radius)


@dataclass(frozen=True)
class ProfileChart(RevolutionChart):
    """A B-spline profile, radii and heights over its own parameter."""

    curve: Profile

    @property
    def v_range(self) -> tuple[float, float]:
        return self.curve.interval

    @property
    def geometry(self) -> Any:
        radius, height = self.curve.control_points.T[..., None]
        placed = self.origin + radius * self.x_axis + height * self.axis
        meridian = occt.curve_to_occt(BSplineCurve(self.curve.knots, placed))
        return Geom_SurfaceOfRevolution(meridian, occt.axis(self.origin, self.axis))

    def profile(self, v: Array) -> tuple[Array, Array]:
        radius, height = self.curve.derivatives(np.clip(v, *self.v_range), 0)[0].T
        return radius, height

    def profile_parameter(self, radius: Array, height: Array) -> Array:
        return self.curve.feet(np.column_stack([radius, height]))
