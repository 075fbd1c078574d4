"""A plane B-spline curve swept along a straight line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from crispline.surface.base import Array, Similarity, unit
from crispline.surface.basis import uniform_knots
from crispline.surface.bspline import BSplineSurface


@dataclass(frozen=True)
class ExtrudedSurface(BSplineSurface):
    """A bicubic B-spline whose lines of constant ``u`` are parallel and straight.

    It is the exact surface of extrusion, and everything that takes a B-spline takes it.
    """

    @classmethod
    def of(
        cls, knots: Array, profile: Array, direction: Array, interval: tuple[float, float]
    ) -> ExtrudedSurface:
        """The surface that a curve sweeps.

        Parameters
        ----------
        knots : of the curve, clamped, shape ``(m + 4,)``.
        profile : its control points, shape ``(m, 3)``.
        direction : of the sweep, unit, shape ``(3,)``.
        interval : from where to where along the direction, relative to the curve.
        """
        knots_v = uniform_knots(*interval, 1)
        heights = np.linspace(*interval, 4)  # straight at constant speed
        return cls(knots, knots_v, profile[:, None] + heights[None, :, None] * direction)

    @property
    def direction(self) -> Array:
        """Of the sweep, unit, shape ``(3,)``."""
        return np.asarray(unit(self.control_points[0, -1] - self.control_points[0, 0]))

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {**super().parameters(), "direction": self.direction.tolist()}

    def transformed(self, similarity: Similarity) -> ExtrudedSurface:
        moved = similarity.points(self.control_points)
        return ExtrudedSurface(self.knots_u, self.knots_v, moved)

    @property
    def n_parameters(self) -> int:
        """Of each control point of the profile, what moves the curve; and the direction."""
        return len(self.control_points) + 2
