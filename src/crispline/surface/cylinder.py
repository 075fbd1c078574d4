"""Circular cylinder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from crispline.surface.base import Array, Similarity, Surface, unit


@dataclass(frozen=True)
class Cylinder(Surface):
    """Cylinder about the line through ``origin`` along unit ``axis``; normal away from the axis."""

    origin: Array
    axis: Array
    radius: float
    kind: ClassVar[str] = "cylinder"

    def project(self, points: Array) -> tuple[Array, Array]:
        offset = points - self.origin
        height = (offset @ self.axis)[:, None] * self.axis
        normals = unit(offset - height)
        return self.origin + height + self.radius * normals, normals

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {
            "origin": self.origin.tolist(),
            "axis": self.axis.tolist(),
            "radius": self.radius,
        }

    def transformed(self, similarity: Similarity) -> Cylinder:
        return Cylinder(
            similarity.points(self.origin),
            similarity.directions(self.axis),
            self.radius * similarity.scale,
        )

    @property
    def n_parameters(self) -> int:
        return 5
