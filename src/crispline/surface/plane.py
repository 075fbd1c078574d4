"""Plane."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from crispline.surface.base import Array, Similarity, Surface


@dataclass(frozen=True)
class Plane(Surface):
    """Plane through ``origin`` with unit ``normal`` (both shape ``(3,)``)."""

    origin: Array
    normal: Array
    kind: ClassVar[str] = "plane"

    def project(self, points: Array) -> tuple[Array, Array]:
        height = (points - self.origin) @ self.normal
        return points - height[:, None] * self.normal, np.broadcast_to(self.normal, points.shape)

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {"origin": self.origin.tolist(), "normal": self.normal.tolist()}

    def transformed(self, similarity: Similarity) -> Plane:
        return Plane(similarity.points(self.origin), similarity.directions(self.normal))

    @property
    def n_parameters(self) -> int:
        return 3
