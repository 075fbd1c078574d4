"""The boundary representation as plain values: no OCCT, no algorithm."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from crispline.curve import Curve
from crispline.surface import Similarity, Surface
from crispline.surface.base import Array


@dataclass(frozen=True)
class Edge:
    """A curve between two vertices, shared by the faces on its left and right.

    Seen from outside the part, with the curve running forward, face ``left``
    lies to its left. A closed edge has ``start == end``. ``right`` is -1 at the
    border of an open shell.

    Attributes
    ----------
    curve : the geometry, from vertex ``start`` to vertex ``end``.
    start, end : indices into ``Model.vertices``.
    left, right : indices into ``Model.faces``; -1 for none.
    gap : largest distance from the curve to its two surfaces (length unit of the model).
    angle : median angle between the outward normals of the two faces, radians.
    is_sharp : whether the surfaces really meet at an angle.
    """

    curve: Curve
    start: int
    end: int
    left: int
    right: int
    gap: float
    angle: float
    is_sharp: bool


@dataclass(frozen=True)
class Face:
    """A trimmed surface.

    Attributes
    ----------
    surface : the carrier.
    orientation : +1 if the surface's own normal points out of the part, else -1.
    loops : closed loops; each a tuple of ``(edge index, +1 forward | -1 backward)``
        with the face on the left, seen from outside. Outer and inner loops are
        not told apart. Empty for a closed surface without edges.
    points : raw points that the face explains, shape ``(k, 3)``.
    residuals : their signed distances to the surface, shape ``(k,)``.
    region : label of the region that the face came from.
    is_patch : whether it is a whole B-spline surface whose borders are parameter lines, run
        through at constant speed; see :mod:`crispline.sharp.patched`.
    """

    surface: Surface
    orientation: int
    loops: tuple[tuple[tuple[int, int], ...], ...]
    points: Array
    residuals: Array
    region: int
    is_patch: bool = False


@dataclass(frozen=True)
class Model:
    """A boundary representation.

    Attributes
    ----------
    vertices : positions, shape ``(n, 3)``.
    vertex_gaps : largest distance of each vertex to its surfaces, shape ``(n,)``.
    edges, faces : see :class:`Edge`, :class:`Face`.
    """

    vertices: Array
    vertex_gaps: Array
    edges: tuple[Edge, ...]
    faces: tuple[Face, ...]

    @property
    def is_closed(self) -> bool:
        """Whether every edge has a face on both sides."""
        return all(edge.left >= 0 and edge.right >= 0 for edge in self.edges)

    def transformed(self, similarity: Similarity) -> Model:
        """The image under a similarity (from the working frame to the user's units)."""
        scale = similarity.scale
        edges = tuple(
            replace(edge, curve=edge.curve.transformed(similarity), gap=edge.gap * scale)
            for edge in self.edges
        )
        faces = tuple(
            replace(
                face,
                surface=face.surface.transformed(similarity),
                points=similarity.points(face.points),
                residuals=face.residuals * scale,
            )
            for face in self.faces
        )
        return Model(
            similarity.points(self.vertices), np.asarray(self.vertex_gaps) * scale, edges, faces
        )
