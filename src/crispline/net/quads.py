"""Quad net over an unorganised cloud."""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pynanoinstantmeshes
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skimage.measure import marching_cubes

from crispline.cloud.working import WorkingCloud
from crispline.errors import ReconstructionError
from crispline.net.halfedge import half_edges
from crispline.net.poisson import Indicator, point_areas, poisson_indicator
from crispline.net.projection import project_to_cloud
from crispline.options import NetOptions
from crispline.surface.base import Array


@dataclass(frozen=True)
class QuadNet:
    """Control net: the vertices and quads of a mesh over the cloud.

    Attributes
    ----------
    vertices : shape ``(n, 3)``, spacings; every vertex is used by a quad.
    quads : vertex indices, counter-clockwise from outside, shape ``(m, 4)``.
    """

    vertices: Array
    quads: NDArray[np.int64]

    @property
    def edge_length(self) -> float:
        """Median side of the quads."""
        sides = self.vertices[self.quads] - self.vertices[np.roll(self.quads, -1, axis=1)]
        return float(np.median(np.linalg.norm(sides, axis=2)))


def quad_net(
    cloud: WorkingCloud, normals: Array, options: NetOptions, threads: int = -1
) -> QuadNet:
    """Pure quad mesh over a cloud with outward normals.

    Poisson indicator, marching cubes, projection onto the cloud, field-aligned
    quad meshing (Jakob et al. 2015), projection again.

    Raises
    ------
    ReconstructionError
        If the indicator has no level set, or the mesher returns no quads.
    """
    areas = point_areas(cloud.distances)
    indicator = poisson_indicator(cloud.points, normals, areas, threads=threads)
    vertices, triangles = _level_set(indicator, cloud.points, areas)
    before, after = options.projection_steps
    vertices = project_to_cloud(vertices, cloud.tree, normals, before, threads)
    # The mesher leaves a hole now and then; another edge length lays the quads anew.
    fewest = math.inf
    for length in options.edge_lengths:
        net = _quads_over(vertices, triangles, length)
        n_open = int(np.sum(half_edges(net.quads, len(net.vertices)).twin < 0))
        if n_open < fewest:
            best, fewest = net, n_open
        if n_open == 0:
            break
    projected = project_to_cloud(best.vertices, cloud.tree, normals, after, threads)
    return _outward(QuadNet(projected, best.quads))


def _quads_over(vertices: Array, triangles: NDArray[np.int64], edge_length: float) -> QuadNet:
    """Quad mesh over a triangle mesh.

    Raises
    ------
    ReconstructionError
        If there are no quads.
    """
    with _quiet_stdout():
        vertices, quads = pynanoinstantmeshes.remesh(
            vertices.astype(np.float32),
            triangles.astype(np.uint32),
            vertex_count=-1,
            scale=2.0 * edge_length,  # the mesher halves it when it makes pure quads
            creaseAngle=-1.0,  # 0 would make every edge a crease
            deterministic=True,
            smooth_iter=2,
            extrinsic=True,
            align_to_boundaries=False,
        )
    if len(quads) == 0:
        raise ReconstructionError(
            "quad meshing of the cloud gave no quads; the part may be smaller than "
            "a few point spacings: scan it more densely"
        )
    return _compact(np.asarray(vertices, dtype=np.float64), np.asarray(quads, dtype=np.int64))


def _level_set(
    indicator: Indicator, points: Array, areas: Array
) -> tuple[Array, NDArray[np.int64]]:
    """Triangles of the indicator's level at the points, without crumbs."""
    level = float(np.average(indicator.at(points), weights=areas))
    try:
        vertices, triangles, _, _ = marching_cubes(indicator.values, level, allow_degenerate=False)
    except (ValueError, RuntimeError) as error:
        raise ReconstructionError(
            "no surface could be found through the cloud: the points do not enclose a part; "
            "check the columns of the file and that the scan covers the part"
        ) from error
    # Crumbs: level sets round stray points.
    n = len(vertices)
    links = coo_array(
        (np.ones(2 * len(triangles)), (triangles[:, :2].ravel(), triangles[:, 1:].ravel())),
        shape=(n, n),
    )
    _, piece = connected_components(links, directed=False)
    size = np.bincount(piece[triangles[:, 0]], minlength=piece.max() + 1)
    triangles = triangles[size[piece[triangles[:, 0]]] > 0.02 * size.max()]
    compact = _compact(indicator.origin + indicator.cell * vertices, triangles.astype(np.int64))
    return compact.vertices, compact.quads


def _compact(vertices: Array, polygons: NDArray[np.int64]) -> QuadNet:
    used, renumbered = np.unique(polygons, return_inverse=True)
    return QuadNet(vertices[used], renumbered.reshape(polygons.shape))


def _outward(net: QuadNet) -> QuadNet:
    """The net with quads counter-clockwise from outside (positive enclosed volume)."""
    a, b, c, d = (net.vertices[net.quads[:, i]] for i in range(4))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) + np.einsum("ij,ij->", a, np.cross(c, d))
    return net if volume >= 0.0 else QuadNet(net.vertices, net.quads[:, ::-1].copy())


@contextlib.contextmanager
def _quiet_stdout() -> Iterator[None]:
    """Silence a C++ library that writes progress to the process's standard output."""
    sys.stdout.flush()
    try:
        saved = os.dup(1)
    except OSError:  # no standard output at all, as under some services
        yield
        return
    with open(os.devnull, "w") as sink:
        os.dup2(sink.fileno(), 1)
        try:
            yield
        finally:
            os.dup2(saved, 1)
            os.close(saved)
