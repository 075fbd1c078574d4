"""Triangle meshes: the step between an indicator or a distance field and quads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from crispline.surface.base import Array

Index = NDArray[np.int64]


@dataclass(frozen=True)
class TriangleMesh:
    """Vertices and triangles.

    Attributes
    ----------
    vertices : shape ``(n, 3)``, spacings.
    triangles : vertex indices, consistently oriented, shape ``(m, 3)``.
    """

    vertices: Array
    triangles: Index

    def links(self) -> csr_array:
        """Symmetric 0/1 matrix of vertices that share a side, shape ``(n, n)``."""
        tail, head = self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel()
        n = len(self.vertices)
        ones = np.ones(2 * len(tail))
        both = (np.concatenate([tail, head]), np.concatenate([head, tail]))
        matrix = coo_array((ones, both), shape=(n, n)).tocsr()
        matrix.data[:] = 1.0
        return matrix

    def pieces(self) -> Index:
        """Connected piece of every vertex, shape ``(n,)``."""
        return np.asarray(connected_components(self.links(), directed=False)[1], dtype=np.int64)

    def borders(self) -> Index:
        """Sides used by one triangle only, as vertex pairs, shape ``(e, 2)``."""
        tail, head = self.triangles.ravel(), np.roll(self.triangles, -1, axis=1).ravel()
        n = len(self.vertices)
        key = np.minimum(tail, head) * n + np.maximum(tail, head)
        _, first, uses = np.unique(key, return_index=True, return_counts=True)
        once = first[uses == 1]
        return np.stack([tail[once], head[once]], axis=1)

    def normals(self) -> Array:
        """Unit normals of the vertices, weighted by area, shape ``(n, 3)``; zero if degenerate."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        across = np.cross(b - a, c - a)
        n = len(self.vertices)
        corner = self.triangles.T.ravel()
        total = np.stack(
            [np.bincount(corner, np.tile(across[:, i], 3), minlength=n) for i in range(3)], axis=1
        )
        length = np.linalg.norm(total, axis=1, keepdims=True)
        return np.asarray(total / np.where(length > 0.0, length, 1.0))

    def areas(self) -> Array:
        """Area of every triangle, shape ``(m,)``."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))


def compact(vertices: Array, triangles: Index) -> TriangleMesh:
    """A mesh without unused vertices."""
    used, renumbered = np.unique(triangles, return_inverse=True)
    return TriangleMesh(vertices[used], renumbered.reshape(triangles.shape).astype(np.int64))


def clipped(mesh: TriangleMesh, values: Array) -> TriangleMesh:
    """The part of a mesh where values given at its vertices are positive.

    Triangles that the zero line crosses are cut along it, so the new border is as
    smooth as the values.

    Parameters
    ----------
    values : shape ``(n,)``, linear over every triangle.
    """
    # A vertex on the line would leave triangles without area.
    values = np.where(values == 0.0, -1e-9, values)
    inside = values > 0.0
    n_inside = inside[mesh.triangles].sum(axis=1)
    vertices, triangles = mesh.vertices, mesh.triangles
    cut = triangles[(n_inside == 1) | (n_inside == 2)]
    if len(cut) == 0:
        return compact(vertices, triangles[n_inside == 3])
    # Turn every cut triangle so that its first vertex is the one on its own side.
    lone = inside[cut] == (inside[cut].sum(axis=1) == 1)[:, None]
    first = lone.argmax(axis=1)
    turned = np.take_along_axis(cut, (first[:, None] + np.arange(3)) % 3, axis=1)
    sides = np.stack([turned[:, :2], turned[:, [0, 2]]], axis=1).reshape(-1, 2)
    n = len(vertices)
    key = sides.min(axis=1) * n + sides.max(axis=1)
    unique, place = np.unique(key, return_inverse=True)
    low, high = unique // n, unique % n
    share = (values[low] / (values[low] - values[high]))[:, None]
    crossing = vertices[low] + share * (vertices[high] - vertices[low])
    ab, ac = n + place.reshape(-1, 2).T
    a, b, c = turned.T
    is_tip = inside[a]
    tips = np.stack([a, ab, ac], axis=1)[is_tip]
    rest = np.concatenate(
        [np.stack([ab, b, c], axis=1)[~is_tip], np.stack([ab, c, ac], axis=1)[~is_tip]]
    )
    kept = np.concatenate([triangles[n_inside == 3], tips, rest])
    return compact(np.concatenate([vertices, crossing]), kept)
