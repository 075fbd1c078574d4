"""How near a shape is to what it should be: exact distances, samples, counts of features."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape

from crispline import occt
from crispline.occt.measure import tessellate
from crispline.surface.base import Array


def shape_distances(points: Array, shape: Any) -> Array:
    """Exact distances of points ``(n, 3)`` to the nearest face of a shape, shape ``(n,)``."""
    faces = occt.subshapes(shape, occt.FACE)
    vertices = [BRepBuilderAPI_MakeVertex(occt.point(point)).Vertex() for point in points]
    return np.array(
        [
            min(BRepExtrema_DistShapeShape(vertex, face).Value() for face in faces)
            for vertex in vertices
        ]
    )


def surface_samples(shape: Any, n_points: int, deflection: float) -> Array:
    """Points on the faces of a shape, uniform by area and alike in every run.

    Parameters
    ----------
    n_points : how many.
    deflection : largest distance of a point to its face, the length unit of the shape.

    Returns
    -------
    Shape ``(n_points, 3)``.
    """
    mesh = tessellate(shape, deflection, 0.05)
    stream = np.random.default_rng(0)
    areas = mesh.areas()
    chosen = stream.choice(len(areas), n_points, p=areas / areas.sum())
    u, v = stream.random((2, n_points, 1))
    u, v = np.where(u + v > 1.0, (1.0 - u, 1.0 - v), (u, v))
    a, b, c = mesh.vertices[mesh.triangles[chosen]].transpose(1, 0, 2)
    return np.asarray(a + u * (b - a) + v * (c - a))


def feature_counts(shape: Any) -> tuple[int, int, int]:
    """Count faces, edges between two different faces (no seams), vertices where three meet."""
    # The bindings compare shapes by their wrappers; the hash tells which are the same.
    faces = occt.subshapes(shape, occt.FACE)
    faces_at: dict[int, set[int]] = {}
    ends_of: dict[int, set[int]] = {}
    for index, face in enumerate(faces):
        for edge in occt.subshapes(face, occt.EDGE):
            faces_at.setdefault(hash(edge), set()).add(index)
            ends_of[hash(edge)] = {hash(end) for end in occt.subshapes(edge, occt.VERTEX)}
    edges = [edge for edge, sides in faces_at.items() if len(sides) == 2]
    degree = Counter(end for edge in edges for end in ends_of[edge])
    return len(faces), len(edges), sum(n >= 3 for n in degree.values())
