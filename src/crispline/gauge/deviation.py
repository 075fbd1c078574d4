"""Distances between a tessellated shape and a cloud, both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.occt.measure import Tessellation
from crispline.surface.base import Array

_MAX_SAMPLES = 400_000
"""Samples of the model; larger models are sampled more thinly."""
_CROWD = 8
"""Points that far from the model count only with this many others of their kind around
them: a missing face leaves dozens, an outlier that was not removed is alone."""
_MAX_THINNING = 4.0
"""A stretch of the cloud this much thinner than the rest is no surface."""


@dataclass(frozen=True)
class Deviation:
    """Distances in spacings.

    Attributes
    ----------
    face_distances : per face, the largest distance of its samples to the cloud; beyond the
        limit, in spacings of the points near it.
    n_uncovered : per face, how many cloud points lie nearest to it, but far from it and
        close to each other.
    """

    face_distances: Array
    n_uncovered: NDArray[np.int64]


def measure_deviation(
    mesh: Tessellation, n_faces: int, points: Array, spacing: float, limit: float
) -> Deviation:
    """Compare a model with its cloud.

    Parameters
    ----------
    mesh : the model.
    n_faces : number of faces, also those without triangles.
    points : the cloud, shape ``(n, 3)``.
    spacing : mean distance between neighbouring points.
    limit : distance beyond which a cloud point is uncovered, in spacings.
    """
    samples, owners = sample_triangles(mesh, 0.7 * spacing)
    face_distances = np.zeros(n_faces)
    cloud = cKDTree(points)
    distance, closest = nearest(cloud, samples, 1)
    to_cloud = distance[:, 0] / spacing
    # Where the scan is thin, its own spacing counts.
    thin = np.flatnonzero(to_cloud > limit)
    around, _ = nearest(cloud, points[closest[thin, 0]], min(9, len(points)))
    local = around[:, -1] * np.sqrt(np.pi / 8.0) / spacing
    to_cloud[thin] /= np.clip(local, 1.0, _MAX_THINNING)
    np.maximum.at(face_distances, mesh.faces[owners], to_cloud)

    tree = cKDTree(samples)
    far = np.flatnonzero(tree.query(points)[0] > limit * spacing)
    n_uncovered = np.zeros(n_faces, dtype=np.int64)
    if len(far):
        # Samples are sparse: measure to the triangles around before judging.
        beside = owners[tree.query(points[far], k=min(8, len(samples)))[1].reshape(len(far), -1)]
        corners = mesh.vertices[mesh.triangles[beside]]
        exact = point_triangle_distance(points[far, None, :], corners).min(axis=1)
        is_far = exact > limit * spacing
        far, beside = far[is_far], beside[is_far]
    if len(far):
        crowd = cKDTree(points[far])
        n_near = crowd.query_ball_point(points[far], limit * spacing, return_length=True) - 1
        is_crowded = np.asarray(n_near) >= _CROWD
        np.add.at(n_uncovered, mesh.faces[beside[is_crowded, 0]], 1)
    return Deviation(face_distances, n_uncovered)


def sample_triangles(mesh: Tessellation, step: float) -> tuple[Array, NDArray[np.int64]]:
    """Evenly spread points of a mesh, about one per ``step`` squared and the vertices.

    Returns
    -------
    samples : shape ``(n, 3)``; the same for the same mesh.
    owners : the triangle of each sample, shape ``(n,)``.
    """
    areas = mesh.areas()
    step = max(step, float(np.sqrt(areas.sum() / _MAX_SAMPLES)))
    # Rounding the running sum, not each area, keeps the density over many small triangles.
    running = np.floor(np.cumsum(areas) / step**2 + 0.5).astype(np.int64)
    counts = np.diff(running, prepend=0)
    owners = np.repeat(np.arange(len(areas)), counts)
    n = np.arange(len(owners), dtype=np.float64) + 1.0
    # Roberts' additive sequence fills the unit square evenly, folded into the triangle.
    plastic = 1.32471795724474602596
    a, b = np.mod(n / plastic, 1.0), np.mod(n / plastic**2, 1.0)
    folded = a + b > 1.0
    a, b = np.where(folded, 1.0 - a, a), np.where(folded, 1.0 - b, b)
    corners = mesh.vertices[mesh.triangles[owners]]
    inner = (
        (1.0 - a - b)[:, None] * corners[:, 0] + a[:, None] * corners[:, 1]
        + b[:, None] * corners[:, 2]
    )  # fmt: skip
    at_vertices = mesh.vertices[mesh.triangles].reshape(-1, 3)
    vertex_owners = np.repeat(np.arange(len(areas)), 3)
    return np.vstack([inner, at_vertices]), np.concatenate([owners, vertex_owners])


def point_triangle_distance(points: Array, triangles: Array) -> Array:
    """Distance of points to triangles.

    Parameters
    ----------
    points : shape ``(..., 3)``, broadcast against the triangles.
    triangles : corners, shape ``(..., 3, 3)``.
    """
    a, b, c = triangles[..., 0, :], triangles[..., 1, :], triangles[..., 2, :]
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=-1)
    to_border = np.minimum.reduce(
        [_point_segment_distance(points, p, q) for p, q in ((a, b), (b, c), (c, a))]
    )
    is_above = length > 0.0
    for p, q in ((a, b), (b, c), (c, a)):
        is_above = is_above & (np.einsum("...i,...i", np.cross(q - p, points - p), normal) >= 0.0)
    height = np.abs(np.einsum("...i,...i", points - a, normal)) / np.where(length > 0, length, 1)
    return np.asarray(np.where(is_above, height, to_border))


def _point_segment_distance(points: Array, start: Array, end: Array) -> Array:
    along = end - start
    squared = np.einsum("...i,...i", along, along)
    share = np.einsum("...i,...i", points - start, along) / np.where(squared > 0, squared, 1.0)
    foot = start + np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray(np.linalg.norm(points - foot, axis=-1))
