"""Signed distances of points to the faces of a shape: where a model deviates from its cloud."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline import occt
from crispline.errors import InputError
from crispline.gauge.borders import borders
from crispline.gauge.bordersearch import BorderSearch, border_search
from crispline.gauge.carriers import Carriers, carriers
from crispline.gauge.deviation import sample_triangles
from crispline.occt.measure import Tessellation, tessellate
from crispline.surface.base import Array, Similarity

Index = NDArray[np.int64]

_SAMPLE_STEP = 0.7
"""Distance between the samples that tell which faces are near a point, in spacings."""
_SAMPLE_DEFLECTION = 0.1
"""Distance of the samples from their face, in spacings; only the search starts from them."""
_N_SAMPLES = (6, 24)
"""Nearest samples whose faces are tried, for points near the shape and for others: about as
many lie nearly at the distance of the nearest one ..."""
_FAR = 1.0
"""... beyond this distance, in spacings ..."""
_REACH = 1.5
"""... if they are at most this much farther than the nearest one, in spacings."""
_EDGE_DEFLECTION = 5e-4
"""Distance between an edge and the polyline that stands for it, in spacings."""
_SEGMENT = 0.5
"""Longest segment of such a polyline, in spacings."""
_SLACK = 0.1
"""A foot this much farther from every edge than from a sample of its face lies inside the
face, in spacings."""
_SMALL = 1e-3
"""Shapes with a smaller spacing are measured at spacing 1, as OCCT's precision is absolute."""
_CHUNK = 50_000
"""Points measured together; bounds the memory."""


@dataclass(frozen=True)
class Deviations:
    """Where points lie with respect to a shape, a row per point, in its length unit.

    Attributes
    ----------
    distance : to the nearest point of the shape; positive on the outer side of the face,
        shape ``(n,)``. Beyond the rim of an open shell the sign tells the side of the
        face's tangent plane.
    face : the face that holds that nearest point, in exploration order, shape ``(n,)``.
    foot : the nearest point, shape ``(n, 3)``.
    """

    distance: Array
    face: Index
    foot: Array


def deviations(
    shape: Any, points: Array, spacing: float, mesh: Tessellation | None = None
) -> Deviations:
    """Signed distances of points to a shape, to a thousandth of a spacing or better.

    The faces near a point are found on samples of a coarse tessellation; the point is
    projected onto their exact surfaces, and onto the edges. A foot on a surface counts
    if the nearest edge of its face has it on the face's side.

    Parameters
    ----------
    shape : any ``TopoDS_Shape`` with faces.
    points : shape ``(n, 3)``.
    spacing : mean distance between neighbouring points; sets the fineness of the search.
    mesh : triangles of the shape with vertices on it, if there are any: thousands of B-spline
        faces take OCCT a minute.

    Raises
    ------
    InputError
        The shape has no face with an area, or a surface that is none of OCCT's usual kinds.
    """
    return Gauge.of(shape, spacing, mesh).deviations(points)


@dataclass(frozen=True)
class Gauge:
    """A shape made ready for points, which may take as long as measuring them."""

    _target: _Target
    _unit: float

    @classmethod
    def of(cls, shape: Any, spacing: float, mesh: Tessellation | None = None) -> Gauge:
        """Of a shape, see :func:`deviations`."""
        if spacing >= _SMALL:
            return cls(_target(shape, spacing, mesh), 1.0)
        larger = Similarity(1.0 / spacing, np.eye(3), np.zeros(3))
        mesh = mesh and replace(mesh, vertices=larger.points(mesh.vertices))
        return cls(_target(occt.transform(shape, larger), 1.0, mesh), spacing)

    def deviations(self, points: Array) -> Deviations:
        """Of points ``(n, 3)``."""
        points = np.asarray(points, float).reshape(-1, 3) / self._unit
        starts = range(0, max(len(points), 1), _CHUNK)
        parts = [self._target.measured(points[i : i + _CHUNK]) for i in starts]
        return Deviations(
            self._unit * np.concatenate([part.distance for part in parts]),
            np.concatenate([part.face for part in parts]),
            self._unit * np.concatenate([part.foot for part in parts]),
        )


@dataclass(frozen=True)
class _Target:
    """A shape made ready for many points.

    Attributes
    ----------
    carriers : the surfaces of its faces.
    outward : +1 where a surface's own normal is the outward one, else -1, per face.
    samples, sample_face : points on the faces, with ``tree`` to search them.
    edges : the borders of the faces.
    spacing : unit of the module's lengths.
    """

    carriers: Carriers
    outward: Array
    samples: Array
    sample_face: Index
    tree: cKDTree
    edges: BorderSearch
    spacing: float

    def measured(self, points: Array) -> Deviations:
        point, face, near = self._candidates(points)
        foot, normal = self.carriers.project(points[point], face)
        gap = np.linalg.norm(foot - near, axis=1)
        is_inside = self.edges.has_inside(foot, face, gap + _SLACK * self.spacing)
        point, face, foot = point[is_inside], face[is_inside], foot[is_inside]
        normal = self.outward[face, None] * normal[is_inside]
        offset = points[point] - foot
        size = np.linalg.norm(offset, axis=1)
        is_behind = np.einsum("ij,ij->i", offset, normal) < 0.0

        reached = np.full(len(points), np.inf)
        np.minimum.at(reached, point, size)
        edgy = np.flatnonzero(self.edges.lower_bounds(points) < reached)
        edge = self.edges.nearest(points[edgy])
        point = np.concatenate([point, edgy])
        size = np.concatenate([size, edge.distance])
        # Of two feet at the same distance the one inside a face is taken: it stands first.
        order = np.lexsort((np.arange(len(point)), size, point))
        best = order[np.flatnonzero(np.diff(point[order], prepend=-1))]
        sign = np.where(np.concatenate([is_behind, edge.is_behind]), -1.0, 1.0)
        return Deviations(
            (sign * size)[best],
            np.concatenate([face, edge.face])[best],
            np.concatenate([foot, edge.foot])[best],
        )

    def _candidates(self, points: Array) -> tuple[Index, Index, Array]:
        """Points, for each a face that may hold its foot, and a place of that face nearby."""
        few, many = (min(count, len(self.samples)) for count in _N_SAMPLES)
        away = np.asarray(self.tree.query(points, [1])[0])[:, 0]
        is_far = away > _FAR * self.spacing
        point, near = np.empty(0, np.int64), np.empty(0, np.int64)
        for mine, count in ((np.flatnonzero(~is_far), few), (np.flatnonzero(is_far), many)):
            distance, sample = map(np.asarray, self.tree.query(points[mine], range(1, count + 1)))
            row, column = np.nonzero(distance <= away[mine, None] + _REACH * self.spacing)
            point, near = np.append(point, mine[row]), np.append(near, sample[row, column])
        # Faces too narrow for a sample of their own are found by their edges.
        edgy = np.flatnonzero(self.edges.lower_bounds(points) < away)
        segment = self.edges.near(points[edgy])
        point = np.concatenate([point, np.repeat(edgy, segment.shape[1])])
        face = np.concatenate([self.sample_face[near], self.edges.face[segment.ravel()]])
        places = np.concatenate([self.samples[near], self.edges.middle[segment.ravel()]])
        pair = point * (int(self.sample_face.max()) + int(self.edges.face.max(initial=0)) + 1)
        _, first = np.unique(pair + face, return_index=True)
        return point[first], face[first], places[first]


def _target(shape: Any, spacing: float, mesh: Tessellation | None) -> _Target:
    faces = occt.subshapes(shape, occt.FACE)
    mesh = mesh or tessellate(shape, _SAMPLE_DEFLECTION * spacing, 0.5)
    if not len(mesh.triangles) or mesh.areas().sum() <= 0.0:
        raise InputError(
            "expected a model with at least one face to measure against, found none; "
            "export the model as faces or a solid"
        )
    surfaces = carriers(faces)
    outward = _outward(mesh, surfaces, len(faces))
    samples, owners = sample_triangles(mesh, _SAMPLE_STEP * spacing)
    lines = borders(faces, _EDGE_DEFLECTION * spacing, _SEGMENT * spacing)
    normals = surfaces.project(0.5 * (lines.start + lines.end), lines.face)[1]
    edges = border_search(lines, outward[lines.face, None] * normals, spacing * _SEGMENT)
    return _Target(surfaces, outward, samples, mesh.faces[owners], cKDTree(samples), edges, spacing)


def _outward(mesh: Tessellation, surfaces: Carriers, n_faces: int) -> Array:
    """+1 where the normal of a face's surface points outward, else -1, shape ``(n_faces,)``.

    The triangles are oriented as the faces are; the largest of each face tells.
    """
    largest = np.lexsort((-mesh.areas(), mesh.faces))
    face, first = np.unique(mesh.faces[largest], return_index=True)
    a, b, c = mesh.vertices[mesh.triangles[largest[first]]].transpose(1, 0, 2)
    normals = surfaces.project((a + b + c) / 3.0, face)[1]
    outward = np.ones(n_faces)
    outward[face] = np.where(np.einsum("ij,ij->i", np.cross(b - a, c - a), normals) < 0, -1, 1)
    return outward
