"""A plane B-spline curve turned about an axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from crispline.surface.base import Array, Similarity, Surface, perpendicular_frame, unit
from crispline.surface.basis import DEGREE
from crispline.surface.profile import Profile

_ON_AXIS = 1e-12


@dataclass(frozen=True)
class RevolvedSurface(Surface):
    """What a profile beside an axis sweeps in a full turn.

    Attributes
    ----------
    origin : a point of the axis, shape ``(3,)``: zero of the profile's heights.
    axis : unit, shape ``(3,)``.
    profile : in the half plane of the axis, points ``(radius, height)``; radii are positive.

    The normal is ``S_u x S_v``, ``u`` the angle about the axis and ``v`` the parameter of the
    profile: away from the axis where the profile climbs along it.
    """

    origin: Array
    axis: Array
    profile: Profile
    kind: ClassVar[str] = "revolution"

    def flattened(self, points: Array) -> Array:
        """Distance from the axis and height along it, shape ``(n, 2)``."""
        offset = points - self.origin
        height = offset @ self.axis
        return np.column_stack(
            [np.linalg.norm(offset - height[:, None] * self.axis, axis=1), height]
        )

    def project(self, points: Array) -> tuple[Array, Array]:
        """Nearest points; where the true foot is beyond the profile, one over its end."""
        offset = points - self.origin
        height = offset @ self.axis
        radial = offset - height[:, None] * self.axis
        radius = np.linalg.norm(radial, axis=1)
        is_off = radius > _ON_AXIS * np.abs(height)  # else its direction is rounding
        outward = np.where(
            is_off[:, None],
            radial / np.where(is_off, radius, 1.0)[:, None],
            perpendicular_frame(self.axis)[0],
        )
        t = self.profile.feet(np.column_stack([radius, height]))
        at, along = self.profile.derivatives(t, 1)
        feet = self.origin + at[:, :1] * outward + at[:, 1:] * self.axis
        return feet, unit(along[:, 1:] * outward - along[:, :1] * self.axis)

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {
            "origin": self.origin.tolist(),
            "axis": self.axis.tolist(),
            "degree": DEGREE,
            "knots": self.profile.knots.tolist(),
            "radii": self.profile.control_points[:, 0].tolist(),
            "heights": self.profile.control_points[:, 1].tolist(),
        }

    def transformed(self, similarity: Similarity) -> RevolvedSurface:
        scaled = similarity.scale * self.profile.control_points
        return RevolvedSurface(
            similarity.points(self.origin),
            similarity.directions(self.axis),
            Profile(self.profile.knots, scaled),
        )

    @property
    def n_parameters(self) -> int:
        """Four of the axis, and of each control point of the profile, what moves the curve."""
        return len(self.profile.control_points) + 4
