"""Linear least squares for the control points of a bicubic B-spline surface."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from crispline.surface import BSplineSurface
from crispline.surface.base import Array
from crispline.surface.basis import DEGREE, SpanPolynomials, basis_functions, uniform_knots

SMOOTHING_LENGTH = 0.1
"""Length over which the bending energy smooths, in spans."""


def solve_control_points(
    knots: tuple[Array, Array],
    rows: sp.csr_array,
    targets: Array,
    weights: Array,
    roughness: sp.csr_array,
) -> BSplineSurface:
    """Minimise ``sum w |S(u, v) - target|^2`` plus a quadratic form of the control points.

    Parameters
    ----------
    knots : along u and along v.
    rows : tensor basis at the data's parameters, shape ``(n, n_u n_v)``; see :func:`tensor_rows`.
    targets : shape ``(n, 3)``.
    weights : shape ``(n,)``, not negative.
    roughness : a positive multiple of :func:`bending_energy`, which alone
        determines control points without data.

    Notes
    -----
    The normal equations are banded and kept well conditioned by the local
    support of B-splines and the bending energy; they are factorised, not inverted.
    """
    matrix = rows.T @ (rows * weights[:, None]) + roughness
    right = rows.T @ (targets * weights[:, None])
    control_points = splu(sp.csc_array(matrix), permc_spec="MMD_AT_PLUS_A").solve(right)
    n_u, n_v = (len(k) - DEGREE - 1 for k in knots)
    return BSplineSurface(*knots, control_points.reshape(n_u, n_v, 3))


def smoothing_weight(knots: tuple[Array, Array], density: float) -> float:
    """Weight of the bending energy for ``density`` data points per unit of parameter area.

    A thin-plate term of weight ``w`` smooths over a length ``(w / density)^(1/4)``.
    Tying that length to the span makes its bias fall with the fourth power of
    the span, as the approximation error of cubics does.
    """
    span_area = np.prod([k[DEGREE + 1] - k[DEGREE] for k in knots])
    return float(density * SMOOTHING_LENGTH**4 * span_area**2)


def tensor_rows(knots: tuple[Array, Array], u: Array, v: Array) -> sp.csr_array:
    """Sparse matrix that maps control points (row-major in u, v) to surface points.

    Shape ``(n, n_u n_v)`` with 16 entries a row, for ``u``, ``v`` of shape ``(n,)``.
    """
    n_u, n_v = (len(k) - DEGREE - 1 for k in knots)
    (first_u, basis_u), (first_v, basis_v) = (
        SpanPolynomials.of(k).at(parameters) for k, parameters in zip(knots, (u, v), strict=True)
    )
    near = np.arange(DEGREE + 1)
    columns = (first_u[:, None] + near)[:, :, None] * n_v + (first_v[:, None] + near)[:, None, :]
    entries = basis_u[0][:, :, None] * basis_v[0][:, None, :]
    starts = np.arange(0, 16 * len(u) + 1, 16)
    return sp.csr_array((entries.ravel(), columns.ravel(), starts), shape=(len(u), n_u * n_v))


def bending_energy(knots_u: Array, knots_v: Array) -> sp.csr_array:
    """Matrix of the thin-plate energy ``integral S_uu^2 + 2 S_uv^2 + S_vv^2``, exact.

    Both knot vectors are clamped with equal spans, as :func:`crispline.surface.basis.uniform_knots`
    makes them: what spans of one unit have is then only scaled.
    """
    spans = [float(k[DEGREE + 1] - k[DEGREE]) for k in (knots_u, knots_v)]
    unit = _unit_energies(*(len(k) - 2 * DEGREE - 1 for k in (knots_u, knots_v)))
    scales = (spans[1] / spans[0] ** 3, 2.0 / (spans[0] * spans[1]), spans[0] / spans[1] ** 3)
    energy = sum(scale * data for scale, data in zip(scales, unit.energies, strict=True))
    return sp.csr_array((energy, unit.columns, unit.starts), shape=(unit.size, unit.size))


class _UnitEnergies(NamedTuple):
    """The integrals of ``S_uu^2``, ``S_uv^2`` and ``S_vv^2`` over unit spans.

    Attributes
    ----------
    energies : the entries of each, shape ``(3, k)``.
    columns, starts : where they stand in a sparse matrix, row by row.
    size : number of rows.
    """

    energies: Array
    columns: NDArray[np.int32]
    starts: NDArray[np.int32]
    size: int


@lru_cache(maxsize=128)
def _unit_energies(n_u: int, n_v: int) -> _UnitEnergies:
    along_u, along_v = _gram_matrices(n_u), _gram_matrices(n_v)
    band_u, band_v = (
        np.abs(np.subtract.outer(np.arange(len(gram[0])), np.arange(len(gram[0])))) <= DEGREE
        for gram in (along_u, along_v)
    )
    pattern = sp.csr_array(sp.kron(sp.csr_array(band_u), sp.csr_array(band_v)))
    pattern.sort_indices()
    row = np.repeat(np.arange(pattern.shape[0]), np.diff(pattern.indptr))
    (row_u, row_v), (column_u, column_v) = (
        np.divmod(index, len(band_v)) for index in (row, pattern.indices)
    )
    energies = np.stack(
        [
            along_u[order][row_u, column_u] * along_v[2 - order][row_v, column_v]
            for order in (2, 1, 0)
        ]
    )
    return _UnitEnergies(energies, pattern.indices, pattern.indptr, pattern.shape[0])


def _gram_matrices(n_spans: int) -> Array:
    """Integrals over unit spans of products of basis functions, of first and second derivatives.

    Shape ``(3, m, m)``. Four Gauss points a span are exact for the products' degree, six.
    """
    nodes, gauss = np.polynomial.legendre.leggauss(DEGREE + 1)
    parameters = (np.arange(n_spans)[:, None] + 0.5 + 0.5 * nodes).ravel()
    first, values = basis_functions(uniform_knots(0.0, n_spans, n_spans), parameters, 2)
    rows = np.zeros((3, len(parameters), n_spans + DEGREE))
    columns = np.broadcast_to(first[:, None] + np.arange(DEGREE + 1), values.shape)
    np.put_along_axis(rows, columns, values, axis=2)
    weights = np.tile(0.5 * gauss, n_spans)
    return np.asarray(np.swapaxes(rows, 1, 2) @ (rows * weights[:, None]))
