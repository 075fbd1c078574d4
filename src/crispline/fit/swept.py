"""Surfaces swept by a known motion: fits of a line or a circle in the plane of their profile.

A narrow face hardly tells the direction of its own axis, but the faces beside it do: the wall
of a step goes along their normal, a chamfer about their axis. What is left to fit is a curve
in the plane, which a few points hold.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from crispline.fit.frame import frame_about
from crispline.fit.robust import DistanceModel, coarse, fit_distances
from crispline.surface import Cone, Cylinder, Plane, Surface, Torus
from crispline.surface.base import Array

MAX_RADIUS = 20.0
"""In extents of the data; a larger circle is a line to the points."""
_FLAT = 1e-9


@dataclass(frozen=True)
class Line:
    """The points ``p`` of a plane with ``p . normal = offset``.

    Attributes
    ----------
    angle : of the normal, radians.
    offset : spacings.
    """

    angle: float
    offset: float

    @property
    def normal(self) -> Array:
        """Unit, shape ``(2,)``."""
        return np.array([np.cos(self.angle), np.sin(self.angle)])


@dataclass(frozen=True)
class Circle:
    """Centre, shape ``(2,)``, and radius, spacings."""

    centre: Array
    radius: float


Profile = Line | Circle
ProfileFit = Callable[[Array, float], Profile | None]
"""From points ``(n, 2)`` and their noise."""


class Sweep(Protocol):
    """A motion that sweeps a plane curve into a surface."""

    def flattened(self, points: Array) -> Array:
        """Where points ``(n, 3)`` cross the plane of the profile, shape ``(n, 2)``."""

    def surface(self, profile: Profile) -> Surface | None:
        """What the curve sweeps; None if that is no primitive."""


@dataclass(frozen=True)
class Translation:
    """Along a unit direction, shape ``(3,)``."""

    direction: Array

    @cached_property
    def _frame(self) -> Array:
        return frame_about(self.direction)

    def flattened(self, points: Array) -> Array:
        """Coordinates across the direction."""
        return np.asarray(points @ self._frame[:2].T)

    def surface(self, profile: Profile) -> Surface:
        """A plane or a cylinder."""
        if isinstance(profile, Line):
            normal = profile.normal @ self._frame[:2]
            return Plane(profile.offset * normal, normal)
        return Cylinder(profile.centre @ self._frame[:2], self.direction, profile.radius)

    def profile(self, surface: Plane | Cylinder) -> Profile:
        """What sweeps a plane along the direction, or a cylinder about it."""
        if isinstance(surface, Cylinder):
            return Circle(self.flattened(surface.origin[None])[0], surface.radius)
        across = self._frame[:2] @ surface.normal
        across /= np.linalg.norm(across)
        line = Line(float(np.arctan2(across[1], across[0])), 0.0)
        return Line(line.angle, float(self.flattened(surface.origin[None])[0] @ line.normal))


@dataclass(frozen=True)
class Revolution:
    """About the axis through ``origin`` along the unit vector ``axis``, both shape ``(3,)``."""

    origin: Array
    axis: Array

    def flattened(self, points: Array) -> Array:
        """Distance from the axis and height along it."""
        offset = points - self.origin
        height = offset @ self.axis
        return np.column_stack(
            [np.linalg.norm(offset - np.outer(height, self.axis), axis=1), height]
        )

    def surface(self, profile: Profile) -> Surface | None:
        """A plane, cylinder, cone or torus; None for a circle that reaches the axis."""
        if isinstance(profile, Circle):
            major, height = profile.centre
            if not 0.0 < profile.radius < major:
                return None
            return Torus(
                self.origin + height * self.axis,
                self.axis,
                float(major),
                profile.radius,
            )
        across, along = profile.normal
        if abs(across) < _FLAT:
            return Plane(self.origin + profile.offset / along * self.axis, self.axis)
        if abs(along) < _FLAT:
            return Cylinder(self.origin, self.axis, abs(profile.offset / across))
        apex = self.origin + profile.offset / along * self.axis
        # The line falls towards the axis on one side of the apex: there the radius is positive.
        side = 1.0 if -along / across > 0.0 else -1.0
        return Cone(apex, side * self.axis, float(np.arctan(abs(along / across))))


def fit_line(flat: Array, sigma: float) -> Line | None:
    """Robust line through points ``(n, 2)``; None for fewer than two."""
    if len(flat) < 2:
        return None
    centre = flat.mean(axis=0)
    _, _, directions = np.linalg.svd(flat - centre, full_matrices=False)
    start = Line(float(np.arctan2(*directions[1][::-1])), 0.0)
    found = fit_distances(_LINE, [start], flat - centre, sigma)
    return None if found is None else Line(found.angle, found.offset + float(centre @ found.normal))


def fit_circle(flat: Array, sigma: float) -> Circle | None:
    """Robust circle through points ``(n, 2)``; None if they are on a line, or fewer than three."""
    if len(flat) < 3:
        return None
    centre = flat.mean(axis=0)
    size = float(np.abs(flat - centre).max())
    found = fit_distances(_CIRCLE, [_algebraic(flat[coarse(len(flat))])], flat, sigma)
    if found is None or not 0.0 < found.radius < 2.0 * MAX_RADIUS * size:
        return None
    return found


def concentric(centre: Array) -> Callable[[Array, float], Circle | None]:
    """The fit of a circle about a known centre, shape ``(2,)``."""

    def fit(flat: Array, sigma: float) -> Circle | None:
        start = Circle(centre, float(np.median(np.linalg.norm(flat - centre, axis=1))))
        return fit_distances(_RADIUS, [start], flat, sigma)

    return fit


def _algebraic(flat: Array) -> Circle:
    """Kasa's circle."""
    centre = flat.mean(axis=0)
    local = flat - centre
    columns = np.column_stack([2.0 * local, np.ones(len(local))])
    a, b, c = np.linalg.lstsq(columns, np.sum(local**2, axis=1), rcond=None)[0]
    return Circle(centre + np.array([a, b]), float(np.sqrt(max(c + a * a + b * b, 1e-12))))


def _line_distances(line: Line, flat: Array) -> tuple[Array, Array]:
    across = line.normal
    along = np.array([-across[1], across[0]])
    return flat @ across - line.offset, np.column_stack([flat @ along, np.full(len(flat), -1.0)])


def _moved_line(line: Line, step: Array) -> Line:
    return Line(line.angle + float(step[0]), line.offset + float(step[1]))


def _circle_distances(circle: Circle, flat: Array) -> tuple[Array, Array]:
    offset = flat - circle.centre
    length = np.linalg.norm(offset, axis=1)
    outward = offset / np.where(length > 0.0, length, 1.0)[:, None]
    return length - circle.radius, np.column_stack([-outward, np.full(len(flat), -1.0)])


def _moved_circle(circle: Circle, step: Array) -> Circle:
    return Circle(circle.centre + step[:2], circle.radius + float(step[2]))


def _radius_distances(circle: Circle, flat: Array) -> tuple[Array, Array]:
    distances, derivatives = _circle_distances(circle, flat)
    return distances, derivatives[:, 2:]


def _grown_circle(circle: Circle, step: Array) -> Circle:
    return Circle(circle.centre, circle.radius + float(step[0]))


_RADIUS = DistanceModel(_radius_distances, _grown_circle)
_LINE = DistanceModel(_line_distances, _moved_line)
_CIRCLE = DistanceModel(_circle_distances, _moved_circle)
