"""Circular cone (one nappe)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from crispline.surface.base import Array, Similarity, Surface, unit


@dataclass(frozen=True)
class Cone(Surface):
    """The nappe of a cone on the ``+axis`` side of ``apex``; normal away from the axis.

    ``half_angle`` is in radians, between 0 and pi/2.
    """

    apex: Array
    axis: Array
    half_angle: float
    kind: ClassVar[str] = "cone"

    def project(self, points: Array) -> tuple[Array, Array]:
        offset = points - self.apex
        height = offset @ self.axis
        radial = offset - height[:, None] * self.axis
        outward = unit(radial)
        radius = np.einsum("ij,ij->i", radial, outward)
        cos, sin = np.cos(self.half_angle), np.sin(self.half_angle)
        along = np.maximum(height * cos + radius * sin, 0.0)
        feet = self.apex + along[:, None] * (cos * self.axis + sin * outward)
        return feet, cos * outward - sin * self.axis

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {
            "apex": self.apex.tolist(),
            "axis": self.axis.tolist(),
            "half_angle_deg": float(np.degrees(self.half_angle)),
        }

    def transformed(self, similarity: Similarity) -> Cone:
        return Cone(similarity.points(self.apex), similarity.directions(self.axis), self.half_angle)

    @property
    def n_parameters(self) -> int:
        return 6
