"""Signed distance near an oriented cloud: the surface of a scan that is not closed.

The indicator of a solid needs a closed surface, and lids over whatever the scan
leaves open. The distance to the tangent planes of the nearest points (Hoppe et
al. 1992) is local: it knows nothing far from the points, and ends where they end.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from skimage.measure import marching_cubes

from crispline.cloud.nearest import nearest
from crispline.errors import ReconstructionError
from crispline.net.mesh import TriangleMesh, compact
from crispline.surface.base import Array

MAX_CELLS = 30_000_000
"""Largest grid; beyond this the cells are coarsened."""
_N_NEIGHBOURS = 12
_WIDTH = 1.2
_CHUNK = 100_000


def sheet_mesh(
    tree: cKDTree, normals: Array, local_spacing: Array, reach: float, threads: int = -1
) -> TriangleMesh:
    """Triangles where the signed distance to an oriented cloud is zero.

    Parameters
    ----------
    tree : search tree over the points, spacings.
    normals : unit normals, shape ``(n, 3)``.
    local_spacing : spacing of the points round each point, shape ``(n,)``.
    reach : how far from the points the surface is sought, in local spacings.
    threads : threads for neighbour queries; the result does not depend on it.

    Returns
    -------
    TriangleMesh
        Runs on over the ends of the cloud by up to ``reach``.

    Raises
    ------
    ReconstructionError
        If the distance is zero nowhere.
    """
    points = np.asarray(tree.data, dtype=np.float64)
    radius = reach * local_spacing
    margin = float(radius.max()) + 2.0
    extent = np.ptp(points, axis=0) + 2.0 * margin
    cell = max(1.0, float((np.prod(extent) / MAX_CELLS) ** (1.0 / 3.0)))
    origin = points.min(axis=0) - margin
    shape = tuple(int(np.ceil(side)) + 1 for side in extent / cell)
    is_known = _near_nodes((points - origin) / cell, radius / cell, shape)
    node = np.flatnonzero(is_known)
    places = origin + cell * np.stack(np.unravel_index(node, shape), axis=1)
    values = np.zeros(shape, dtype=np.float32)
    values.reshape(-1)[node] = _signed_distance(places, tree, normals, local_spacing, threads)
    try:
        vertices, triangles, _, _ = marching_cubes(
            values, 0.0, mask=_known_cells(is_known), allow_degenerate=False
        )
    except (ValueError, RuntimeError) as error:
        raise ReconstructionError(
            "no surface could be found through the cloud; check the columns of the file "
            "and that the points lie on surfaces"
        ) from error
    return compact(origin + cell * vertices, triangles.astype(np.int64))


def _near_nodes(grid: Array, radius: Array, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """Nodes of a grid within each point's radius of it (all in cells)."""
    near = np.zeros(shape, dtype=bool)
    flat = near.reshape(-1)
    corner = np.round(grid).astype(np.int64)
    order = np.argsort(-radius, kind="stable")
    corner, radius = corner[order], radius[order]
    most = int(np.ceil(radius[0]))
    offsets = np.indices((2 * most + 1,) * 3).reshape(3, -1).T - most
    length = np.linalg.norm(offsets, axis=1)
    # The farther an offset, the fewer points reach it: a leading run of the sorted ones.
    n_reached = np.searchsorted(-radius, -length, side="right")
    for offset, n in zip(offsets, n_reached, strict=True):
        if n:
            flat[np.ravel_multi_index(tuple((corner[:n] + offset).T), shape)] = True
    return near


def _known_cells(is_known: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Cells with eight known nodes, marked at their last node, as the library has it."""
    cells = np.zeros_like(is_known)
    inner = cells[1:, 1:, 1:]
    inner[:] = True
    for i in (0, 1):
        for j in (0, 1):
            for k in (0, 1):
                n_i, n_j, n_k = (side - 1 for side in is_known.shape)
                inner &= is_known[i : i + n_i, j : j + n_j, k : k + n_k]
    return cells


def _signed_distance(
    places: Array, tree: cKDTree, normals: Array, local_spacing: Array, threads: int
) -> Array:
    """Distance to the tangent planes of the nearest points, averaged, shape ``(m,)``."""
    points = np.asarray(tree.data, dtype=np.float64)
    k = min(_N_NEIGHBOURS, len(points))
    result = np.empty(len(places))
    for begin in range(0, len(places), _CHUNK):
        chunk = places[begin : begin + _CHUNK]
        distance, index = nearest(tree, chunk, k, threads)
        width = _WIDTH * local_spacing[index[:, :1]]
        # Relative to the nearest point, so that the weights hold at any distance.
        weight = np.exp(-(distance**2 - distance[:, :1] ** 2) / width**2)
        height = np.einsum("mki,mki->mk", chunk[:, None] - points[index], normals[index])
        result[begin : begin + _CHUNK] = (weight * height).sum(axis=1) / weight.sum(axis=1)
    return result
