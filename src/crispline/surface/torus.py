"""Circular torus."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from crispline.surface.base import Array, Similarity, Surface, unit


@dataclass(frozen=True)
class Torus(Surface):
    """Tube of ``minor_radius`` about a circle of ``major_radius``; normal away from that circle."""

    centre: Array
    axis: Array
    major_radius: float
    minor_radius: float
    kind: ClassVar[str] = "torus"

    def project(self, points: Array) -> tuple[Array, Array]:
        offset = points - self.centre
        radial = offset - (offset @ self.axis)[:, None] * self.axis
        spine = self.centre + self.major_radius * unit(radial)
        normals = unit(points - spine)
        return spine + self.minor_radius * normals, normals

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {
            "centre": self.centre.tolist(),
            "axis": self.axis.tolist(),
            "major_radius": self.major_radius,
            "minor_radius": self.minor_radius,
        }

    def transformed(self, similarity: Similarity) -> Torus:
        return Torus(
            similarity.points(self.centre),
            similarity.directions(self.axis),
            self.major_radius * similarity.scale,
            self.minor_radius * similarity.scale,
        )

    @property
    def n_parameters(self) -> int:
        return 7
