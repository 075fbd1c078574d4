"""Sphere."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from crispline.surface.base import Array, Similarity, Surface, unit


@dataclass(frozen=True)
class Sphere(Surface):
    """Sphere about ``centre`` (shape ``(3,)``); the normal points away from the centre."""

    centre: Array
    radius: float
    kind: ClassVar[str] = "sphere"

    def project(self, points: Array) -> tuple[Array, Array]:
        normals = unit(points - self.centre)
        return self.centre + self.radius * normals, normals

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {"centre": self.centre.tolist(), "radius": self.radius}

    def transformed(self, similarity: Similarity) -> Sphere:
        return Sphere(similarity.points(self.centre), self.radius * similarity.scale)

    @property
    def n_parameters(self) -> int:
        return 4
