"""Project vertices onto the surface that a noisy oriented cloud defines, keeping edges.

Robust implicit moving least squares (RIMLS, Oztireli, Guennebaud and Gross 2009).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.surface.base import Array

Single = NDArray[np.float32]

_SUPPORT = 4.0  # radius of the weight function, spacings
_RESIDUAL_WIDTH = 0.5 * _SUPPORT  # residuals beyond this count as another surface
_NORMAL_WIDTH = 0.7  # and so do normals that differ by more than this
_REWEIGHTINGS = 4
_N_NEIGHBOURS = 32
_CHUNK = 20_000


def project_to_cloud(
    vertices: Array, tree: cKDTree, normals: Array, n_steps: int, threads: int = -1
) -> Array:
    """Vertices after ``n_steps`` projection steps, shape ``(m, 3)``.

    Parameters
    ----------
    vertices : shape ``(m, 3)``, spacings.
    tree : search tree over the cloud's points.
    normals : outward unit normals of the points, shape ``(n, 3)``.

    Vertices farther than four spacings from every point stay where they are.
    """
    points = np.asarray(tree.data, dtype=np.float64)
    projected = np.array(vertices, dtype=np.float64)
    k = min(_N_NEIGHBOURS, len(points))
    # Most of the closed surface of an open scan is lids, far from every point.
    distance, _ = tree.query(vertices, distance_upper_bound=_SUPPORT, workers=threads)
    near = np.flatnonzero(np.isfinite(distance))
    for begin in range(0, len(near), _CHUNK):
        members = near[begin : begin + _CHUNK]
        chunk = projected[members]
        # Vertices move by a fraction of a spacing: their neighbours stay the same.
        nearest = np.asarray(tree.query(chunk, k=k, workers=threads)[1])
        near_points, near_normals = points[nearest], normals[nearest].astype(np.float32)
        for _ in range(n_steps):
            offset = (chunk[:, None] - near_points).astype(np.float32)
            chunk = chunk - _rimls_step(offset, near_normals)
        projected[members] = chunk
    return projected


def _rimls_step(offset: Single, normals: Single) -> Array:
    """Step to subtract: value over gradient of the implicit function, shape ``(m, 3)``.

    ``offset`` (vertex minus point) and ``normals`` have shape ``(m, k, 3)``.
    """
    squared = np.einsum("mki,mki->mk", offset, offset)
    falloff = np.maximum(1.0 - squared / _SUPPORT**2, 0.0)
    weight = falloff**4
    slope = -8.0 * falloff**3 / _SUPPORT**2  # gradient of the weight = slope * offset
    height = np.einsum("mki,mki->mk", offset, normals)
    value = np.zeros(len(offset), dtype=np.float32)
    gradient = np.zeros((len(offset), 3), dtype=np.float32)
    for iteration in range(_REWEIGHTINGS):
        robust = np.ones_like(weight)
        if iteration > 0:
            off_value = (height - value[:, None]) / _RESIDUAL_WIDTH
            # |n - g|^2 = 1 - 2 n.g + g.g for unit n
            turn = 1.0 - 2.0 * np.einsum("mki,mi->mk", normals, gradient)
            turn += np.einsum("mi,mi->m", gradient, gradient)[:, None]
            robust = np.exp(-(off_value**2) - turn / _NORMAL_WIDTH**2)
        w, g = robust * weight, robust * slope
        total = np.maximum(w.sum(axis=1), 1e-12)
        value = np.einsum("mk,mk->m", w, height) / total
        gradient = (
            np.einsum("mk,mki->mi", g * (height - value[:, None]), offset)
            + np.einsum("mk,mki->mi", w, normals)
        ) / total[:, None]
    norm = np.einsum("mi,mi->m", gradient, gradient)
    usable = (norm > 1e-6) & (squared.min(axis=1) < _SUPPORT**2)
    step = np.where(usable, value / np.where(usable, norm, 1.0), 0.0)
    return np.asarray(step[:, None] * gradient, dtype=np.float64)
