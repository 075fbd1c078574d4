"""Bicubic B-spline surface over a quad net of any topology: Catmull-Clark limit patches.

One patch per quad. Where the net is regular the patch is exactly the uniform
bicubic B-spline patch of the surrounding 4 x 4 control points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array

# Limit position, first and second derivative at a regular vertex, in the
# half-size parameter of one subdivision step.
_POSITION = np.array([1.0, 4.0, 1.0]) / 6.0
_FIRST = np.array([-1.0, 0.0, 1.0]) / 2.0
_SECOND = np.array([1.0, -2.0, 1.0])


@dataclass(frozen=True)
class PatchCentres:
    """Position and derivatives of every patch at its centre, each shape ``(m, 3)``.

    On a quad net ``u`` runs from side 3 to side 1 of the quad, ``v`` from side 0
    to side 2, and derivatives are per half patch. On a grid the shape is
    ``(m, n, 3)`` and derivatives are per patch.
    """

    point: Array
    du: Array
    dv: Array
    duu: Array
    duv: Array
    dvv: Array

    @property
    def normal(self) -> Array:
        """Unit normals ``S_u x S_v``, shape ``(m, 3)``; zero where the patch is degenerate."""
        cross = np.cross(self.du, self.dv)
        length = np.linalg.norm(cross, axis=-1, keepdims=True)
        return np.asarray(cross / np.where(length > 0.0, length, 1.0))

    @property
    def size(self) -> Array:
        """Root of the area that the tangents span, shape ``(m,)``."""
        e, f, g = (
            a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
            for a, b in ((self.du, self.du), (self.du, self.dv), (self.dv, self.dv))
        )
        return np.asarray(np.sqrt(np.sqrt(np.maximum(e * g - f * f, 0.0))))


def patch_centres(vertices: Array, quads: NDArray[np.int64]) -> PatchCentres:
    """Exact limit positions and derivatives at the centres of all patches.

    After one Catmull-Clark step the face point of a quad is a regular vertex,
    so its limit position and derivatives are tensor products of
    ``(1, 4, 1)/6``, ``(-1, 0, 1)/2`` and ``(1, -2, 1)`` over the 3 x 3 points
    about it; on a regular net they equal the weights of the paper's patch.

    Parameters
    ----------
    vertices : control points, shape ``(n, 3)``.
    quads : vertex indices, shape ``(m, 4)``.
    """
    block = _subdivided_blocks(vertices, quads)

    def limit(along_u: Array, along_v: Array) -> Array:
        return np.asarray(np.einsum("a,b,mabk->mk", along_v, along_u, block))

    return PatchCentres(
        point=limit(_POSITION, _POSITION),
        du=limit(_FIRST, _POSITION),
        dv=limit(_POSITION, _FIRST),
        duu=limit(_SECOND, _POSITION),
        duv=limit(_FIRST, _FIRST),
        dvv=limit(_POSITION, _SECOND),
    )


def _subdivided_blocks(vertices: Array, quads: NDArray[np.int64]) -> Array:
    """The 3 x 3 net about each face point after one step, indexed (v, u), shape ``(m, 3, 3, 3)``.

    On an open border edge points are midpoints and vertices stay (the border
    rule of linear extrapolation is not needed for centres inside).
    """
    n, m = len(vertices), len(quads)
    face_point = vertices[quads].mean(axis=1)
    tail, head = quads.ravel(), np.roll(quads, -1, axis=1).ravel()
    key = np.minimum(tail, head) * n + np.maximum(tail, head)
    edge_key, edge, uses = np.unique(key, return_inverse=True, return_counts=True)
    ends = np.stack([edge_key // n, edge_key % n], axis=1)
    middle = vertices[ends].mean(axis=1)
    faces_sum = _scatter(edge, np.repeat(face_point, 4, axis=0), len(ends))
    inner = (uses == 2)[:, None]
    edge_point = np.where(inner, (2.0 * middle + faces_sum) / 4.0, middle)

    valence = np.bincount(ends.ravel(), minlength=n)
    n_faces = np.bincount(tail, minlength=n)
    middle_mean = _scatter(ends.T.ravel(), np.concatenate([middle, middle]), n)
    middle_mean /= np.maximum(valence, 1)[:, None]
    face_mean = _scatter(tail, np.repeat(face_point, 4, axis=0), n)
    face_mean /= np.maximum(n_faces, 1)[:, None]
    degree = np.maximum(valence, 1)[:, None]
    vertex_point = (face_mean + 2.0 * middle_mean + (degree - 3.0) * vertices) / degree
    on_border = np.zeros(n, dtype=bool)
    on_border[ends[uses != 2]] = True
    vertex_point[on_border] = vertices[on_border]

    side = edge_point[edge].reshape(m, 4, 3)
    corner = vertex_point[quads]
    block = np.empty((m, 3, 3, 3))
    block[:, 0, 0], block[:, 0, 1], block[:, 0, 2] = corner[:, 0], side[:, 0], corner[:, 1]
    block[:, 1, 0], block[:, 1, 1], block[:, 1, 2] = side[:, 3], face_point, side[:, 1]
    block[:, 2, 0], block[:, 2, 1], block[:, 2, 2] = corner[:, 3], side[:, 2], corner[:, 2]
    return block


def _scatter(index: NDArray[np.int64], values: Array, n: int) -> Array:
    """Sum rows of ``values`` (k, 3) by index into shape ``(n, 3)``."""
    return np.stack([np.bincount(index, values[:, i], minlength=n) for i in range(3)], axis=1)
