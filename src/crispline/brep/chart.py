"""Parameter planes of surfaces: where a point has its (u, v), and where the plane ends."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.Geom import Geom_Plane

from crispline import occt
from crispline.surface import BSplineSurface
from crispline.surface.base import Array

TURN = 2.0 * np.pi
SAME = 1e-6
"""Parameters closer than this are the same."""
_SNAP = 1e-4
"""A border point this close to a side of a patch, or to a whole parameter, is there."""
UNBOUNDED = (-np.inf, np.inf)


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
    u_range = UNBOUNDED
    v_range = UNBOUNDED

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
