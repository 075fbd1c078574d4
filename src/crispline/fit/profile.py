"""Points in a plane to a B-spline profile: where they lie along it, and its linear system."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from crispline.fit.bspline import DOMAIN_MARGIN, is_height_field
from crispline.fit.spline_system import SMOOTHING_LENGTH
from crispline.surface.base import Array, unit
from crispline.surface.basis import DEGREE, basis_functions, uniform_knots

_REACH = 1.7  # of neighbours along a profile, in its steps
_STEP = 1.0  # spacings


def start_parameters(flat: Array, normals: Array) -> Array | None:
    """Start values along the profile of points ``(n, 2)``, whose normals may be fewer.

    None for a closed profile, and for one in pieces.
    """
    if is_height_field(normals):
        middle = unit(normals.mean(axis=0))
        return np.asarray(flat @ np.array([middle[1], -middle[0]]))
    cell = np.unique(np.floor(flat / _STEP).astype(np.int64), axis=0, return_inverse=True)[1]
    cell = cell.ravel()
    size = np.bincount(cell)
    nodes = np.column_stack([np.bincount(cell, weights=x) / size for x in flat.T])
    pairs = cKDTree(nodes).query_pairs(_REACH * _STEP, output_type="ndarray")
    if len(nodes) < 2 or not len(pairs):
        return None
    length = np.linalg.norm(nodes[pairs[:, 0]] - nodes[pairs[:, 1]], axis=1)
    near = csr_array((length, (pairs[:, 0], pairs[:, 1])), shape=(len(nodes), len(nodes)))
    end = int(np.argmax(_ways(near, 0)))
    along = _ways(near, end)
    if not np.isfinite(along).all():
        return None
    last = _ways(near, int(np.argmax(along)))
    # On an open profile the ways to both ends add up to its length everywhere.
    if np.max(along + last) > 1.5 * along.max():
        return None
    return np.asarray(along[cell])


def _ways(near: csr_array, start: int) -> Array:
    """Lengths of the shortest ways from a node."""
    return np.asarray(dijkstra(near, directed=False, indices=np.array([start]))).ravel()


def profile_knots(t: Array, n_spans: int) -> Array:
    """Uniform knots over parameters and a margin at either end."""
    low, high = float(t.min()), float(t.max())
    margin = DOMAIN_MARGIN * max(high - low, 1e-9)
    return uniform_knots(low - margin, high + margin, n_spans)


def basis_rows(knots: Array, t: Array, order: int) -> Array:
    """Values or derivatives of all basis functions, shape ``(n, m)``."""
    first, values = basis_functions(knots, t, order)
    rows = np.zeros((len(t), len(knots) - DEGREE - 1))
    np.put_along_axis(rows, first[:, None] + np.arange(DEGREE + 1), values[order], axis=1)
    return rows


def bending_rows(knots: Array, weight: float) -> Array:
    """Rows whose squares add up to the bending of one coordinate of a profile, shape ``(k, m)``.

    ``weight`` is that of all points together; the bending gets as much of it as smooths over
    a fraction of a span.
    """
    span = knots[DEGREE + 1] - knots[DEGREE]
    density = weight / (knots[-1] - knots[0])
    nodes, gauss = np.polynomial.legendre.leggauss(DEGREE)
    starts = knots[DEGREE : -DEGREE - 1]
    places = (starts[:, None] + 0.5 * span * (1.0 + nodes)).ravel()
    energy = 0.5 * span * np.tile(gauss, len(starts)) * density * (SMOOTHING_LENGTH * span) ** 4
    return np.asarray(basis_rows(knots, places, 2) * np.sqrt(energy)[:, None])
