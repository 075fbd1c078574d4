"""Bounded curves in space: line, circular arc, cubic B-spline."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import BSpline

from crispline.surface.base import Array, Similarity


class Curve(ABC):
    """A bounded, oriented curve over the parameter interval ``[start, end]``."""

    kind: ClassVar[str]
    start: float
    end: float

    @abstractmethod
    def evaluate(self, parameters: Array) -> Array:
        """Points at the parameters: shape ``(n,)`` gives ``(n, 3)``."""

    @abstractmethod
    def transformed(self, similarity: Similarity) -> Curve:
        """The image of the curve, over the matching parameter interval."""

    def samples(self, n: int) -> Array:
        """``n`` points at equal parameter steps from start to end, shape ``(n, 3)``."""
        return self.evaluate(np.linspace(self.start, self.end, n))


@dataclass(frozen=True)
class Line(Curve):
    """``origin + t * direction`` with unit ``direction``; ``t`` is arc length."""

    origin: Array
    direction: Array
    start: float
    end: float
    kind: ClassVar[str] = "line"

    def evaluate(self, parameters: Array) -> Array:
        return self.origin + np.asarray(parameters)[:, None] * self.direction

    def transformed(self, similarity: Similarity) -> Line:
        return Line(
            similarity.points(self.origin),
            similarity.directions(self.direction),
            self.start * similarity.scale,
            self.end * similarity.scale,
        )


@dataclass(frozen=True)
class Circle(Curve):
    """``centre + radius (cos t x_axis + sin t (normal x x_axis))``; ``t`` in radians.

    A full circle has ``end - start == 2 pi``.
    """

    centre: Array
    normal: Array
    x_axis: Array
    radius: float
    start: float
    end: float
    kind: ClassVar[str] = "circle"

    def evaluate(self, parameters: Array) -> Array:
        angle = np.asarray(parameters)[:, None]
        y_axis = np.cross(self.normal, self.x_axis)
        return self.centre + self.radius * (np.cos(angle) * self.x_axis + np.sin(angle) * y_axis)

    def transformed(self, similarity: Similarity) -> Circle:
        return Circle(
            similarity.points(self.centre),
            similarity.directions(self.normal),
            similarity.directions(self.x_axis),
            self.radius * similarity.scale,
            self.start,
            self.end,
        )


@dataclass(frozen=True)
class BSplineCurve(Curve):
    """Cubic B-spline with clamped ``knots`` ``(n + 4,)`` and ``control_points`` ``(n, 3)``.

    A closed curve is clamped too: its first and last control points coincide.
    """

    knots: Array
    control_points: Array
    kind: ClassVar[str] = "bspline"

    @property
    def start(self) -> float:  # type: ignore[override]
        return float(self.knots[3])

    @property
    def end(self) -> float:  # type: ignore[override]
        return float(self.knots[-4])

    def evaluate(self, parameters: Array) -> Array:
        return np.asarray(BSpline(self.knots, self.control_points, 3)(parameters))

    def transformed(self, similarity: Similarity) -> BSplineCurve:
        return BSplineCurve(self.knots, similarity.points(self.control_points))
