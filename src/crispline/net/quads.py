"""Quad net over an unorganised cloud."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.cloud.working import WorkingCloud
from crispline.net.halfedge import half_edges
from crispline.net.level_set import solid_mesh
from crispline.net.loops import (
    border_loops,
    with_quad_holes_filled,
    with_small_holes_filled,
    without_pinches,
)
from crispline.net.mesh import TriangleMesh, clipped, compact
from crispline.net.poisson import point_areas, poisson_indicator
from crispline.net.projection import project_to_cloud
from crispline.net.remesh import quads_over
from crispline.net.restrain import restrained
from crispline.net.sheets import FINE_CELL, are_apart
from crispline.net.signed_distance import sheet_mesh
from crispline.net.support import Coverage, coverage, local_spacings, support
from crispline.net.trim import Trimmed, trimmed, without_crumbs
from crispline.options import NetOptions
from crispline.spline.separate import fan_vertices
from crispline.surface.base import Array

_CELL = 1.0  # of the indicator's grid where no wall is thin, spacings
_OVERHANG = 2.0  # how far an open surface runs on over its end before it is trimmed
_MAX_LOCAL_SPACING = 4.0
_UNCOVERED = 3.0  # points this far from the closed surface are not on it ...
_MAX_UNCOVERED = 0.01  # ... and if more than this share is not, the scan is not closed
_CLEARLY_WIDER = 1.25  # gaps this much wider than those to be filled make a scan open
_LONGEST_HOLE = 12  # sides of a hole that the mesher left by accident
_HOPELESS = 40  # sides of such holes: four and more, and quads laid anew have as many


@dataclass(frozen=True)
class QuadNet:
    """Control net: the vertices and quads of a mesh over the cloud.

    Attributes
    ----------
    vertices : shape ``(n, 3)``, spacings; every vertex is used by a quad.
    quads : vertex indices, counter-clockwise from outside, shape ``(m, 4)``.
    is_open : whether the scan is not closed, so that the net ends where the points do.
    notes : sentences for the user about what was left out.
    """

    vertices: Array
    quads: NDArray[np.int64]
    is_open: bool = False
    notes: tuple[str, ...] = ()

    @property
    def edge_length(self) -> float:
        """Median side of the quads."""
        sides = self.vertices[self.quads] - self.vertices[np.roll(self.quads, -1, axis=1)]
        return float(np.median(np.linalg.norm(sides, axis=2)))


def quad_net(
    cloud: WorkingCloud, normals: Array, options: NetOptions, threads: int = -1
) -> QuadNet:
    """Pure quad mesh over a cloud with outward normals.

    A closed surface is the level set of the Poisson indicator. If that spans gaps wider
    than ``options.fill_holes``, or misses points, the scan is open: then the surface is
    the zero of the signed distance near the points. Either is projected onto the cloud,
    meshed with quads (Jakob et al. 2015) and projected again. Sheets that touch in a vertex
    or along a side get vertices of their own.

    Raises
    ------
    ReconstructionError
        If there is no surface through the points, or the mesher returns no quads.
    """
    net = _Builder(cloud, normals, options, threads).net()
    vertices, quads = _taken_apart(net.vertices, net.quads)
    return replace(net, vertices=vertices, quads=quads)


@dataclass(frozen=True)
class _Builder:
    """What both kinds of net are made from."""

    cloud: WorkingCloud
    normals: Array
    options: NetOptions
    threads: int

    @property
    def _spacing(self) -> Array:
        return local_spacings(self.cloud.distances)

    def net(self) -> QuadNet:
        """The closed net, or the open one."""
        if self.options.surface == "open":
            return self.open_net()
        level_set = self.level_set()
        mesh = self._on_cloud(level_set)
        if self.options.surface == "auto" and self.leaves_gaps(mesh):
            return self.open_net()
        return self.closed_net(mesh, level_set)

    def level_set(self) -> TriangleMesh:
        """Closed triangle mesh near the points."""
        areas = point_areas(self.cloud.distances)
        # Smoothed over a spacing, the two sides of a thin wall run together here and there.
        cell = FINE_CELL if are_apart(self.cloud, self.threads) else _CELL
        points = self.cloud.points
        indicator = poisson_indicator(points, self.normals, areas, cell, threads=self.threads)
        mesh = solid_mesh(indicator, points, areas)
        return TriangleMesh(*self._without_crumbs(mesh.vertices, mesh.triangles))

    def leaves_gaps(self, mesh: TriangleMesh) -> bool:
        """Whether a closed mesh spans gaps that are too wide to be filled, or misses points."""
        distance, _ = nearest(cKDTree(mesh.vertices), self.cloud.points, 1, self.threads)
        if np.mean(distance > _UNCOVERED) > _MAX_UNCOVERED:
            return True
        widths = self._coverage(mesh).widths
        return bool((widths > _CLEARLY_WIDER * self.options.fill_holes).any())

    def closed_net(self, mesh: TriangleMesh, level_set: TriangleMesh) -> QuadNet:
        """Quads over a closed mesh, which is a level set that was projected onto the points."""
        fewest = math.inf
        for meshed, length in self._trials(mesh, level_set):
            net = _mended(*quads_over(meshed, length))
            n_open = int(np.sum(half_edges(net[1], len(net[0])).twin < 0))
            if n_open < fewest:
                best, fewest = net, n_open
            if n_open == 0:
                break
        # What hung on the surface in a vertex only has become a piece of its own.
        vertices, quads = self._without_crumbs(*best)
        vertices = self._project(vertices, self.options.projection_steps[1])
        return _outward(QuadNet(vertices, quads, notes=self._lids(mesh)))

    def _trials(
        self, mesh: TriangleMesh, level_set: TriangleMesh
    ) -> Iterator[tuple[TriangleMesh, float]]:
        """What to mesh at which edge length, until a net comes out closed.

        The mesher leaves large holes where a projected mesh crosses itself, and a small one
        elsewhere now and then: another edge length lays the quads anew.
        """
        first, *others = self.options.edge_lengths
        yield mesh, first
        calm = restrained(level_set, mesh.vertices)
        if not np.array_equal(calm.vertices, mesh.vertices):
            yield calm, first
        for length in others:
            yield calm, length

    def _lids(self, mesh: TriangleMesh) -> tuple[str, ...]:
        """That a wide gap was spanned because the user insisted."""
        if self.options.surface != "closed":
            return ()
        widths = self._coverage(mesh).widths
        if not (widths > _CLEARLY_WIDER * self.options.fill_holes).any():
            return ()
        return (
            f"a gap of {widths[0]:.0f} spacings was spanned to close the surface: "
            "no point says where it runs there",
        )

    def open_net(self) -> QuadNet:
        """Quads over the points, ending where the points end."""
        reach = max(2.0 * _OVERHANG, 0.5 * self.options.fill_holes + 1.5)
        spacing = np.clip(self._spacing, 1.0, _MAX_LOCAL_SPACING)
        mesh = sheet_mesh(self.cloud.tree, self.normals, spacing, reach, self.threads)
        mesh = self._on_cloud(TriangleMesh(*self._without_crumbs(mesh.vertices, mesh.triangles)))
        cover = self._coverage(mesh)
        overhang = np.where(cover.is_notch, 0.0, _OVERHANG)
        mesh = clipped(mesh, cover.value + overhang)
        mesh = compact(mesh.vertices, without_pinches(mesh.triangles))
        mesh = with_small_holes_filled(mesh, self.options.fill_holes)
        fewest = math.inf
        for length in self.options.edge_lengths:
            net = self._trimmed(*quads_over(mesh, length))
            n_odd = _n_short_sides(net.quads)
            if n_odd < fewest:
                best, fewest = net, n_odd
            if n_odd == 0 or n_odd > _HOPELESS:
                break
        vertices = self._project(best.vertices, 1)
        notes: tuple[str, ...] = ()
        if best.n_lost_pieces:
            notes = (
                f"{best.n_lost_pieces} pieces of surface with {best.n_lost_points} points are "
                f"smaller than {self.options.min_piece} points each and were left out",
            )
        return QuadNet(vertices, best.quads, is_open=True, notes=notes)

    def _trimmed(self, vertices: Array, quads: NDArray[np.int64]) -> Trimmed:
        # What hangs on the surface in a vertex only is a crumb of its own.
        vertices, quads = _taken_apart(vertices, quads)
        vertices = self._project(vertices, self.options.projection_steps[1])
        cut = trimmed(
            vertices,
            quads,
            self.cloud.tree,
            self._spacing,
            self.options.fill_holes,
            self.options.min_piece,
            self.threads,
        )
        fill = self.options.fill_holes
        filled = with_quad_holes_filled(cut.vertices, cut.quads, _LONGEST_HOLE, fill)
        return Trimmed(*filled, cut.n_lost_pieces, cut.n_lost_points)

    def _on_cloud(self, mesh: TriangleMesh) -> TriangleMesh:
        """The mesh projected onto the points."""
        n_steps = self.options.projection_steps[0]
        return TriangleMesh(self._project(mesh.vertices, n_steps), mesh.triangles)

    def _without_crumbs(
        self, vertices: Array, polygons: NDArray[np.int64]
    ) -> tuple[Array, NDArray[np.int64]]:
        least = self.options.min_piece
        vertices, polygons, _ = without_crumbs(
            vertices, polygons, self.cloud.tree, least, self.threads
        )
        return vertices, polygons

    def _coverage(self, mesh: TriangleMesh) -> Coverage:
        found = support(mesh.vertices, mesh.normals(), self.cloud.tree, self._spacing, self.threads)
        on_border = np.zeros(len(mesh.vertices), dtype=bool)
        on_border[mesh.borders().ravel()] = True
        fill = self.options.fill_holes
        return coverage(mesh.vertices, mesh.links(), on_border, found, fill)

    def _project(self, vertices: Array, n_steps: int) -> Array:
        return project_to_cloud(vertices, self.cloud.tree, self.normals, n_steps, self.threads)


def _taken_apart(vertices: Array, quads: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Sheets that touch in a vertex or along a side with vertices of their own."""
    twin = half_edges(quads, len(vertices)).twin
    quads, source = fan_vertices(quads, twin, len(vertices))
    return vertices[source], quads


def _mended(vertices: Array, quads: NDArray[np.int64]) -> tuple[Array, NDArray[np.int64]]:
    """Small holes filled, those where sheets touch on each sheet."""
    return with_quad_holes_filled(*_taken_apart(vertices, quads), _LONGEST_HOLE)


def _n_short_sides(quads: NDArray[np.int64]) -> int:
    """Sides of the border loops that are too short for the end of a scan."""
    return sum(len(loop) for loop in border_loops(quads) if len(loop) <= _LONGEST_HOLE)


def _outward(net: QuadNet) -> QuadNet:
    """The net with quads counter-clockwise from outside (positive enclosed volume)."""
    a, b, c, d = (net.vertices[net.quads[:, i]] for i in range(4))
    volume = np.einsum("ij,ij->", a, np.cross(b, c)) + np.einsum("ij,ij->", a, np.cross(c, d))
    if volume >= 0.0:
        return net
    return QuadNet(net.vertices, net.quads[:, ::-1].copy(), net.is_open, net.notes)
