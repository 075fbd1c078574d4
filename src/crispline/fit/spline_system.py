"""Linear least squares for the control points of a bicubic B-spline surface."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

from crispline.surface import BSplineSurface
from crispline.surface.base import Array
from crispline.surface.basis import DEGREE, basis_functions

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
    first_u, basis_u = basis_functions(knots[0], u)
    first_v, basis_v = basis_functions(knots[1], v)
    near = np.arange(DEGREE + 1)
    columns = (first_u[:, None] + near)[:, :, None] * n_v + (first_v[:, None] + near)[:, None, :]
    entries = basis_u[0][:, :, None] * basis_v[0][:, None, :]
    starts = np.arange(0, 16 * len(u) + 1, 16)
    return sp.csr_array((entries.ravel(), columns.ravel(), starts), shape=(len(u), n_u * n_v))


def bending_energy(knots_u: Array, knots_v: Array) -> sp.csr_array:
    """Matrix of the thin-plate energy ``integral S_uu^2 + 2 S_uv^2 + S_vv^2``, exact."""
    (u0, u1, u2), (v0, v1, v2) = (_gram_matrices(k) for k in (knots_u, knots_v))
    return sp.csr_array(sp.kron(u2, v0) + 2.0 * sp.kron(u1, v1) + sp.kron(u0, v2))


def _gram_matrices(knots: Array) -> tuple[sp.csr_array, sp.csr_array, sp.csr_array]:
    """Integrals of products of basis functions, of first and of second derivatives.

    Four Gauss points a span are exact for the products' degree, six.
    """
    nodes, gauss = np.polynomial.legendre.leggauss(DEGREE + 1)
    breaks = knots[DEGREE : len(knots) - DEGREE]
    half = 0.5 * np.diff(breaks)[:, None]
    parameters = (0.5 * (breaks[:-1] + breaks[1:])[:, None] + half * nodes).ravel()
    weights = (half * gauss).ravel()
    first, values = basis_functions(knots, parameters, 2)
    n = len(parameters)
    columns = (first[:, None] + np.arange(DEGREE + 1)).ravel()
    starts = np.arange(0, 4 * n + 1, 4)
    shape = (n, len(knots) - DEGREE - 1)
    rows = [sp.csr_array((value.ravel(), columns, starts), shape=shape) for value in values]
    zero, one, two = (sp.csr_array(row.T @ (row * weights[:, None])) for row in rows)
    return zero, one, two
