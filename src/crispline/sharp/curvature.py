"""Mean curvature at the patch centres (step 2 of the paper)."""

from __future__ import annotations

import numpy as np

from crispline.spline.catmull_clark import PatchCentres
from crispline.surface.base import Array

_DEGENERATE = 1e-12


def curvature(centres: PatchCentres) -> Array:
    """Signed mean curvature of every patch at its centre, shape ``(...)``, 1/length.

    ``H = (E N - 2 F M + G L) / (2 (E G - F^2))`` with the first fundamental
    form E, F, G and the second L, M, N (paper, section II). Positive where the
    surface bends towards its normal. Degenerate patches (parallel or zero
    tangents) get 0.

    Parameters
    ----------
    centres : derivatives of shape ``(..., 3)``: patches of a net in one row, of
        a grid in rows and columns.
    """
    du, dv = centres.du, centres.dv
    e, f, g = _dot(du, du), _dot(du, dv), _dot(dv, dv)
    # Across the tangents but not yet of length one: its length is sqrt(E G - F^2).
    across = _cross(du, dv)
    metric = e * g
    limit = _DEGENERATE * metric
    metric -= f * f
    is_regular = metric > limit
    if not is_regular.all():
        metric = np.where(is_regular, metric, np.inf)
    numerator = e * _dot(centres.dvv, across)
    numerator += g * _dot(centres.duu, across)
    f *= 2.0
    numerator -= f * _dot(centres.duv, across)
    scale = np.sqrt(metric)
    scale *= metric
    scale *= 2.0
    numerator /= scale
    return numerator


def _dot(a: Array, b: Array) -> Array:
    """Scalar products; three products of planes are faster than a sum over a short axis."""
    return np.asarray(a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2])


def _cross(a: Array, b: Array) -> Array:
    # One plane a coordinate, whatever the memory layout of the operands.
    result = np.empty((3, *a.shape[:-1]))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(a[..., i], b[..., j], out=result[k])
        result[k] -= a[..., j] * b[..., i]
    return np.moveaxis(result, 0, -1)
