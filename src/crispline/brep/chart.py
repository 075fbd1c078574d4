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
from scipy.interpolate import NdBSpline
from scipy.spatial import cKDTree

from crispline.brep import occt
from crispline.surface import BSplineSurface
from crispline.surface.base import Array

TURN = 2.0 * np.pi
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

    def trace(self, points: Array) -> Array:
        """(u, v) along a dense polyline, shape ``(n, 2)``, without jumps of a period."""
        uv = self.parameters(points)
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
        radius, u = np.hypot(x, y), np.arctan2(y, x)
        # On the axis the angle is undefined: take the neighbour's along the polyline.
        is_on_axis = radius <= 1e-9 * np.linalg.norm(offset, axis=1).max(initial=0.0)
        if is_on_axis.any() and not is_on_axis.all():
            lost, known = np.flatnonzero(is_on_axis), np.flatnonzero(~is_on_axis)
            u[lost] = u[known[np.abs(lost[:, None] - known).argmin(axis=1)]]
        return np.column_stack([u, self.profile_parameter(radius, height)])

    def points(self, parameters: Array) -> Array:
        u = parameters[:, 0]
        radius, height = self.profile(parameters[:, 1])
        y_axis = np.cross(self.axis, self.x_axis)
        around = np.cos(u)[:, None] * self.x_axis + np.sin(u)[:, None] * y_axis
        return self.origin + radius[:, None] * around + height[:, None] * self.axis


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
        return np.maximum((radius - self.radius) * slope + height * rise, self.v_range[0])


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
        return float(self.surface.knots_u[3]), float(self.surface.knots_u[-4])

    @property
    def v_range(self) -> tuple[float, float]:
        return float(self.surface.knots_v[3]), float(self.surface.knots_v[-4])

    @property
    def geometry(self) -> Any:
        return occt.bspline_surface(self.surface)

    def parameters(self, points: Array) -> Array:
        """Gauss-Newton from the nearest node of a grid with four nodes to a span."""
        spline = self._spline
        lower, upper = np.transpose([self.u_range, self.v_range])
        n_nodes = [4 * (n - 3) + 1 for n in self.surface.control_points.shape[:2]]
        axes = [np.linspace(lower[i], upper[i], n_nodes[i]) for i in (0, 1)]
        nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        uv = nodes[cKDTree(spline(nodes)).query(points)[1]]
        for _ in range(20):
            residual = points - spline(uv)
            tangents = np.stack([spline(uv, nu=(1, 0)), spline(uv, nu=(0, 1))], axis=1)
            metric = tangents @ tangents.transpose(0, 2, 1)
            step = np.linalg.pinv(metric) @ (tangents @ residual[:, :, None])
            moved = np.clip(uv + step[:, :, 0], lower, upper)
            change = np.abs(moved - uv).max(initial=0.0)
            uv = moved
            if change <= 1e-14 * np.abs(upper - lower).max():
                break
        return np.asarray(uv)

    def points(self, parameters: Array) -> Array:
        lower, upper = np.transpose([self.u_range, self.v_range])
        return np.asarray(self._spline(np.clip(parameters, lower, upper)))

    @property
    def _spline(self) -> NdBSpline:
        knots = (self.surface.knots_u, self.surface.knots_v)
        return NdBSpline(knots, self.surface.control_points, 3)
