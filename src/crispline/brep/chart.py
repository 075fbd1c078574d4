"""Parameter planes of surfaces: where a point has its (u, v), and where the plane ends.

A surface of revolution is parametrised the way OCCT and STEP do it: ``u`` turns
about the axis from the frame's x axis, ``v`` runs along the profile. The choice
of that x axis is the choice of the seam.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.Geom import (
    Geom_ConicalSurface,
    Geom_CylindricalSurface,
    Geom_Plane,
    Geom_SphericalSurface,
    Geom_ToroidalSurface,
)

from crispline import occt
from crispline.surface import BSplineSurface
from crispline.surface.base import Array

TURN = 2.0 * np.pi
POLE_REACH = 0.5
"""A border that comes this close to a pole goes through it, in spacings."""
SAME = 1e-6
"""Parameters closer than this are the same."""
_SNAP = 1e-4
"""A border point this close to a side of a patch, or to a whole parameter, is there."""
_UNBOUNDED = (-np.inf, np.inf)


class Chart(ABC):
    """A surface with parameters ``(u, v)`` on a rectangle, which may be unbounded.

    Attributes
    ----------
    is_periodic : whether the two borders of ``u`` (of ``v``) are one curve, a seam.
    has_pole : whether the lower (the upper) border of ``v`` is a single point.
    """

    is_periodic: tuple[bool, bool] = (False, False)
    has_pole: tuple[bool, bool] = (False, False)

    @property
    @abstractmethod
    def u_range(self) -> tuple[float, float]:
        """Borders of ``u``."""

    @property
    @abstractmethod
    def v_range(self) -> tuple[float, float]:
        """Borders of ``v``."""

    @property
    @abstractmethod
    def geometry(self) -> Any:
        """The ``Geom_Surface``."""

    @abstractmethod
    def parameters(self, points: Array) -> Array:
        """(u, v) of the nearest surface points: shape ``(n, 3)`` gives ``(n, 2)``."""

    @abstractmethod
    def points(self, parameters: Array) -> Array:
        """Surface points: shape ``(n, 2)`` gives ``(n, 3)``."""

    def is_pole(self, parameters: Array) -> bool:
        """Whether a (u, v), shape ``(2,)``, lies in a pole."""
        sides = zip(self.v_range, self.has_pole, strict=True)
        return any(has_pole and abs(parameters[1] - v) < SAME for v, has_pole in sides)

    def trace(self, points: Array, t: Array) -> Array:
        """(u, v) along a dense polyline, shape ``(n, 2)``, without jumps of a period.

        ``t`` are the parameters of the points on their own curve, shape ``(n,)``.
        """
        return self._unwrapped(self.parameters(points))

    def _unwrapped(self, uv: Array) -> Array:
        for axis in (0, 1):
            if self.is_periodic[axis]:
                uv[:, axis] = np.unwrap(uv[:, axis])
        return uv


@dataclass(frozen=True)
class PlaneChart(Chart):
    """Cartesian coordinates in a plane."""

    origin: Array
    normal: Array
    x_axis: Array
    u_range = _UNBOUNDED
    v_range = _UNBOUNDED

    @property
    def geometry(self) -> Any:
        return Geom_Plane(occt.frame(self.origin, self.normal, self.x_axis))

    def parameters(self, points: Array) -> Array:
        return (points - self.origin) @ self._axes.T

    def points(self, parameters: Array) -> Array:
        return self.origin + parameters @ self._axes

    @property
    def _axes(self) -> Array:
        return np.stack([self.x_axis, np.cross(self.normal, self.x_axis)])


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
    v_range = _UNBOUNDED

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
class BSplineChart(Chart):
    """The knot rectangle of a B-spline surface."""

    surface: BSplineSurface

    @property
    def u_range(self) -> tuple[float, float]:
        lower, upper = self.surface.domain
        return float(lower[0]), float(upper[0])

    @property
    def v_range(self) -> tuple[float, float]:
        lower, upper = self.surface.domain
        return float(lower[1]), float(upper[1])

    @property
    def geometry(self) -> Any:
        return occt.bspline_surface(self.surface)

    def parameters(self, points: Array) -> Array:
        return np.column_stack(self.surface.parameters_of(points))

    def points(self, parameters: Array) -> Array:
        lower, upper = self.surface.domain
        inside = np.clip(parameters, lower, upper)
        return self.surface.evaluate(inside[:, 0], inside[:, 1])


@dataclass(frozen=True)
class PatchChart(BSplineChart):
    """The knot rectangle of a B-spline surface that is not trimmed: its borders are the face's."""

    def trace(self, points: Array, t: Array) -> Array:
        start, end = self._on_border(points[[0, -1]])
        share = (t - t[0]) / (t[-1] - t[0])
        return np.asarray(start + share[:, None] * (end - start))

    def _on_border(self, points: Array) -> Array:
        """(u, v) of border points, exactly on the border, shape ``(n, 2)``."""
        uv = self.parameters(points)
        for side in self.surface.domain:
            uv = np.where(np.abs(uv - side) < _SNAP, side, uv)
        whole = np.round(uv)  # vertices of the net
        return np.where(np.abs(uv - whole) < _SNAP, whole, uv)
