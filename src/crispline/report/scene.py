"""What the picture of a report shows, as plain arrays."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crispline import occt
from crispline.gauge.borders import borders
from crispline.gauge.distance import Deviations
from crispline.occt.measure import Tessellation, tessellate
from crispline.result import Reconstruction
from crispline.spline.creased import CreasedNet
from crispline.spline.limit import limit_points
from crispline.surface.base import Array

Index = NDArray[np.int64]

_DEFLECTION = 0.05
"""Distance of the triangles from their face, in spacings."""
_ANGLE = 0.12
"""Angle between neighbouring triangles on a bend, radians ..."""
_MANY_FACES = 500
_MANY_ANGLE = 0.5
"""... and on so many faces: a quilt of patches bends with the noise everywhere."""


@dataclass(frozen=True)
class Cloud:
    """Points and how far they lie from the model.

    Attributes
    ----------
    points : shape ``(n, 3)``.
    deviations : signed, positive outside, shape ``(n,)``; NaN where unknown.
    faces : row of the face table that each point is measured to, -1 for none, shape ``(n,)``.
    """

    points: Array
    deviations: Array
    faces: Index


@dataclass(frozen=True)
class Patches:
    """The bicubic surface over the net, by the corners of its patches.

    Attributes
    ----------
    quads : indices into the positions, shape ``(m, 4)``.
    plain : limit positions of the plain net, shape ``(n, 3)``.
    sharp : limit positions of the sharpened net, shape ``(n, 3)``.
    kinds : 0 flat, 1 curved, 2 sharp, shape ``(m,)``.
    """

    quads: Index
    plain: Array
    sharp: Array
    kinds: NDArray[np.uint8]


@dataclass(frozen=True)
class Scene:
    """Everything that can be shown, in the user's unit.

    Attributes
    ----------
    cloud : the points that were measured.
    mesh : the model; its ``faces`` are rows of the face table, -1 for a face in no row.
    sharp_edges, tangent_edges : polylines, each of shape ``(k, 3)``.
    corners : shape ``(c, 3)``.
    patches : None if there is no net.
    """

    cloud: Cloud
    mesh: Tessellation
    sharp_edges: tuple[Array, ...]
    tangent_edges: tuple[Array, ...]
    corners: Array
    patches: Patches | None = None

    def box(self) -> tuple[Array, Array]:
        """Lowest and highest corner of the model, or of what there is if there is no model.

        Points far from everything stretch no picture: without a model the box holds
        all but the outermost thousandth of the cloud on every side.
        """
        solid = [self.mesh.vertices, *self.sharp_edges, *self.tangent_edges]
        solid += [self.patches.plain] if self.patches is not None else []
        places = np.concatenate(solid)
        if len(places) == 0:
            low, high = np.quantile(self.cloud.points, [0.001, 0.999], axis=0)
            return np.asarray(low), np.asarray(high)
        return places.min(axis=0), places.max(axis=0)


def scene_of(result: Reconstruction, points: Array, found: Deviations | None) -> Scene:
    """The scene of a run, as far as it came.

    Parameters
    ----------
    result : complete or partial.
    points : the cloud, shape ``(n, 3)``.
    found : deviations of the points from ``result.solid.shape``; None if there is no shape.
    """
    mesh, owners = _EMPTY, np.full(len(points), -1)
    distances = np.full(len(points), np.nan)
    if result.solid is not None:
        order = np.array(result.solid.face_order, dtype=np.int64)
        mesh = model_mesh(result.solid.shape, result.spacing, order)
        if found is not None:
            distances, owners = found.distance, order[found.face]
    edges = result.edges
    return Scene(
        Cloud(points, distances, owners),
        mesh,
        tuple(edge.points for edge in edges if edge.is_sharp),
        tuple(edge.points for edge in edges if not edge.is_sharp),
        result.corners,
        patches_of(result),
    )


def scene_of_shape(shape: Any, points: Array, found: Deviations, spacing: float) -> Scene:
    """The scene of any shape with faces and the cloud it was compared with."""
    faces = list(occt.subshapes(shape, occt.FACE))
    lines = borders(faces, _DEFLECTION * spacing, math.inf)
    segments = np.stack([lines.start, lines.end], axis=1)
    return Scene(
        Cloud(points, found.distance, found.face),
        model_mesh(shape, spacing, np.arange(len(faces))),
        tuple(segments),
        (),
        np.zeros((0, 3)),
    )


def model_mesh(shape: Any, spacing: float, order: Index) -> Tessellation:
    """Triangles of a shape with the rows of its faces; ``order`` has a row per face."""
    angle = _ANGLE if len(order) < _MANY_FACES else _MANY_ANGLE
    mesh = tessellate(shape, _DEFLECTION * spacing, angle)
    return Tessellation(mesh.vertices, mesh.triangles, order[mesh.faces])


_EMPTY = Tessellation(np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty(0, np.int64))


def patches_of(result: Reconstruction) -> Patches | None:
    """The plain and the sharp surface of a result; None if it has no net."""
    net = result.patches
    if len(net.quads) == 0 or len(result.plain_vertices) != len(net.vertices):
        return None
    none = np.zeros((0, 2), dtype=np.int64)
    plain = CreasedNet(result.plain_vertices, net.quads, none, none[:, 0])
    kinds = result.patch_kinds
    if len(kinds) != len(net.quads):
        kinds = np.zeros(len(net.quads), dtype=np.uint8)
    # A vertex without quads has no limit position, and none is asked for.
    positions = (np.nan_to_num(limit_points(each).position) for each in (plain, net))
    before, after = positions
    return Patches(net.quads, before, after, kinds)
