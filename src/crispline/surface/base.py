"""What every fitted surface can do: project points, tell its parameters, follow a similarity."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Similarity:
    """The map ``x -> scale * rotation @ x + translation``.

    Attributes
    ----------
    scale : positive factor.
    rotation : proper rotation, shape ``(3, 3)``.
    translation : shape ``(3,)``.
    """

    scale: float
    rotation: Array
    translation: Array

    def points(self, points: Array) -> Array:
        """Image of points, shape ``(..., 3)``."""
        return self.scale * (points @ self.rotation.T) + self.translation

    def directions(self, directions: Array) -> Array:
        """Image of unit vectors, shape ``(..., 3)``; they stay unit."""
        return directions @ self.rotation.T

    def inverse(self) -> Similarity:
        """The map that undoes this one."""
        rotation = self.rotation.T
        return Similarity(1.0 / self.scale, rotation, -(rotation @ self.translation) / self.scale)


class Surface(ABC):
    """An unbounded (or, for B-splines, generously bounded) oriented surface.

    The normal has a fixed side of its own (away from the axis or centre, along
    the plane's normal, ``S_u x S_v``); whether that is the *outward* side of a
    part belongs to the face, not to the surface.
    """

    kind: ClassVar[str]

    @abstractmethod
    def project(self, points: Array) -> tuple[Array, Array]:
        """Nearest points on the surface.

        Parameters
        ----------
        points : shape ``(n, 3)``.

        Returns
        -------
        feet : shape ``(n, 3)``.
        normals : unit normals at the feet, shape ``(n, 3)``.

        Points with no unique foot (on an axis, at a centre) get one of the
        feet, never NaN.
        """

    def signed_distance(self, points: Array) -> Array:
        """Distance along the surface normal, shape ``(n,)``; positive on the normal's side."""
        feet, normals = self.project(points)
        return np.asarray(np.einsum("ij,ij->i", points - feet, normals))

    @abstractmethod
    def parameters(self) -> Mapping[str, float | list[float]]:
        """Defining lengths, points and directions, ready for JSON (angles in degrees)."""

    @abstractmethod
    def transformed(self, similarity: Similarity) -> Surface:
        """The image of the surface."""

    @property
    @abstractmethod
    def n_parameters(self) -> int:
        """Number of free parameters, for model selection."""


def unit(vectors: Array) -> Array:
    """Vectors of length one, shape ``(..., 3)``; a zero vector becomes the x axis.

    >>> unit(np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 0.0]])).tolist()
    [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    """
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    fallback = np.zeros_like(vectors)
    fallback[..., 0] = 1.0
    return np.asarray(
        np.where(length > 0.0, vectors / np.where(length > 0.0, length, 1.0), fallback)
    )


def perpendicular_frame(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors ``x``, ``y`` with ``x, y, axis`` right-handed and orthonormal."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = unit(helper - (helper @ axis) * axis)
    return x, np.cross(axis, x)
