"""Cut a net where the cloud under it ends, and lay its rim on that end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.net.halfedge import half_edges
from crispline.net.loops import without_pinches
from crispline.net.support import coverage, support
from crispline.surface.base import Array

Index = NDArray[np.int64]

_ON_PIECE = 3.0  # points this near to a piece of surface are on it
_BUBBLE = 2.0  # a piece with less than a tenth of it nearer than this to a point is no surface
_BARE_SHARE = 0.9
_MIN_POLYGONS = 12  # fewer make no region
_LONGEST_SIDE = 3.0  # of a quad, spacings: meshed at 1, it was torn between two sheets
_MAX_MOVE = 1.5
_MOVES = 2


@dataclass(frozen=True)
class Trimmed:
    """A net over the cloud and nothing else.

    Attributes
    ----------
    vertices, quads : the net, shapes ``(n, 3)`` and ``(m, 4)``; every vertex is used.
    n_lost_pieces, n_lost_points : pieces left out as too small, and the points on them.
    """

    vertices: Array
    quads: Index
    n_lost_pieces: int
    n_lost_points: int


def trimmed(
    vertices: Array,
    quads: Index,
    tree: cKDTree,
    local_spacing: Array,
    fill_holes: float,
    min_piece: int,
    threads: int = -1,
) -> Trimmed:
    """Cut a net that runs on over the ends of a cloud, or from one sheet of it to another.

    Parameters
    ----------
    vertices, quads : the net, shapes ``(n, 3)`` and ``(m, 4)``, spacings.
    tree, local_spacing : the cloud.
    fill_holes : holes up to this wide stay covered, in local spacings.
    min_piece : pieces with fewer points than this are left out.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    normals = vertex_normals(vertices, quads)
    found = support(vertices, normals, tree, local_spacing, threads)
    on_border = np.zeros(len(vertices), dtype=bool)
    on_border[_rim(quads, len(vertices))] = True
    cover = coverage(vertices, _links(quads, len(vertices)), on_border, found, fill_holes)
    side = np.linalg.norm(vertices[quads] - vertices[np.roll(quads, -1, axis=1)], axis=2)
    keep = (cover.value[quads].mean(axis=1) > 0.0) & (side.max(axis=1) <= _LONGEST_SIDE)
    vertices, quads = used_only(vertices, without_pinches(quads[keep]))
    vertices, quads, lost = without_crumbs(vertices, quads, tree, min_piece, threads)
    return Trimmed(_rim_on_end(vertices, quads, tree, local_spacing, threads), quads, *lost)


def without_crumbs(
    vertices: Array, polygons: Index, tree: cKDTree, min_piece: int, threads: int = -1
) -> tuple[Array, Index, tuple[int, int]]:
    """The mesh without the pieces that fewer than ``min_piece`` points lie nearest to.

    The largest piece stays in any case.

    Returns
    -------
    vertices, polygons : of the pieces that stay.
    lost : how many pieces went, and how many points lie on them.
    """
    if len(polygons) == 0:
        return vertices, polygons, (0, 0)
    _, piece = connected_components(_links(polygons, len(vertices)), directed=False)
    # Most of the closed surface of an open scan is lids, far from every point.
    gap = nearest(tree, vertices, 1, threads, within=2.0 * _BUBBLE)[0][:, 0]
    points = np.asarray(tree.data)
    distance, at = nearest(cKDTree(vertices), points, 1, threads, within=2.0 * _ON_PIECE)
    n_points = np.bincount(piece[at[distance <= _ON_PIECE]], minlength=int(piece.max()) + 1)
    # A bubble between two sheets has points near it as well, but not on it.
    is_bubble = np.bincount(piece, gap > _BUBBLE) > _BARE_SHARE * np.bincount(piece)
    n_polygons = np.bincount(piece[polygons[:, 0]], minlength=len(n_points))
    stays = (n_points >= min_piece) & (n_polygons >= _MIN_POLYGONS) & ~is_bubble
    stays[np.argmax(n_points)] = True
    lost = int((~stays).sum()), int(n_points[~stays].sum())
    return *used_only(vertices, polygons[stays[piece[polygons[:, 0]]]]), lost


def used_only(vertices: Array, polygons: Index) -> tuple[Array, Index]:
    """The mesh without vertices that no polygon uses."""
    used, renumbered = np.unique(polygons, return_inverse=True)
    return vertices[used], renumbered.reshape(polygons.shape)


def vertex_normals(vertices: Array, quads: Index) -> Array:
    """Unit normals of a quad net, weighted by area, shape ``(n, 3)``; zero if degenerate."""
    a, b, c, d = (vertices[quads[:, i]] for i in range(4))
    across = np.cross(c - a, d - b)
    total = np.zeros_like(vertices)
    for i in range(3):
        total[:, i] = np.bincount(quads.T.ravel(), np.tile(across[:, i], 4), len(vertices))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.where(length > 0.0, length, 1.0))


def _rim_on_end(
    vertices: Array, quads: Index, tree: cKDTree, local_spacing: Array, threads: int
) -> Array:
    """Rim vertices moved along the surface to where the points end."""
    rim = _rim(quads, len(vertices))
    vertices = vertices.copy()
    start = vertices[rim]
    for _ in range(_MOVES if len(rim) else 0):
        normals = vertex_normals(vertices, quads)[rim]
        found = support(vertices[rim], normals, tree, local_spacing, threads)
        # Only an end within reach is one; farther in, the rim belongs to a filled hole.
        step = np.where(np.abs(found.inset) <= 2.0 * _MAX_MOVE, found.inset, 0.0)
        moved = vertices[rim] - step[:, None] * found.inward - start
        length = np.linalg.norm(moved, axis=1, keepdims=True)
        vertices[rim] = start + moved * np.minimum(1.0, _MAX_MOVE / np.maximum(length, _MAX_MOVE))
    return vertices


def _rim(quads: Index, n_vertices: int) -> Index:
    """Vertices on the border of a quad net, ascending."""
    connected = half_edges(quads, n_vertices)
    loose = connected.twin < 0
    return np.unique(np.concatenate([connected.origin[loose], connected.target[loose]]))


def _links(polygons: Index, n_vertices: int) -> csr_array:
    """Symmetric 0/1 matrix of vertices that share a side."""
    tail, head = polygons.ravel(), np.roll(polygons, -1, axis=1).ravel()
    both = (np.concatenate([tail, head]), np.concatenate([head, tail]))
    links = coo_array((np.ones(2 * len(tail)), both), shape=(n_vertices, n_vertices)).tocsr()
    links.data[:] = 1.0
    return links
