"""Patch centres of a grid by separable stencils, and their mean curvature, in blocks of rows.

The centre weights of a uniform bicubic patch are, along each direction,
``(1, 23, 23, 1)/48`` for the position, ``(-1, -5, 5, 1)/8`` for the first and
``(1, -1, -1, 1)/2`` for the second derivative. An outer point that is missing,
at the border of the grid or beside an invalid pixel, lies on the line of its
two neighbours, as in :func:`crispline.spline.tensor.spline_over_grid`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.sharp.curvature import curvature
from crispline.spline.catmull_clark import PatchCentres
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array

Mask = NDArray[np.bool_]
_BLOCK = 16384
"""Points in a block of rows: few enough for the second-level cache."""


@dataclass(frozen=True)
class Curvature:
    """Curvature of the patches of a grid.

    Attributes
    ----------
    mean : signed mean curvature at the centre, 1/length, shape ``(m - 1, n - 1)``; 0
        where there is no patch.
    size : root of the area that the tangents span there, length, same shape.
    """

    mean: Array
    size: Array


def grid_curvature(points: Array, is_valid: Mask | None = None) -> Curvature:
    """Mean curvature and size of every patch of a grid.

    Parameters
    ----------
    points : shape ``(m, n, 3)``, the control net of a uniform bicubic surface.
    is_valid : shape ``(m, n)``; all by default.
    """
    m, n = points.shape[:2]
    bend, size = np.zeros((m - 1, n - 1)), np.zeros((m - 1, n - 1))
    for rows, centres in _blocks(points, is_valid):
        bend[rows], size[rows] = curvature(centres), centres.size
    if is_valid is not None and not is_valid.all():
        ok = is_valid[:-1, :-1] & is_valid[1:, :-1] & is_valid[:-1, 1:] & is_valid[1:, 1:]
        bend[~ok] = 0.0
        size[~ok] = 0.0
    return Curvature(bend, size)


def grid_centres(points: Array, is_valid: Mask | None = None) -> PatchCentres:
    """Centres and derivatives of every patch, arrays of shape ``(m - 1, n - 1, 3)``.

    Meaningless where a point of the cell is invalid.
    """
    m, n = points.shape[:2]
    arrays = [np.empty((m - 1, n - 1, 3)) for _ in range(6)]
    for rows, centres in _blocks(points, is_valid):
        parts = (centres.point, centres.du, centres.dv, centres.duu, centres.duv, centres.dvv)
        for array, part in zip(arrays, parts, strict=True):
            array[rows] = part
    return PatchCentres(*arrays)


def surface_centres(surface: TensorSpline, u: Array, v: Array) -> PatchCentres:
    """Centres of the spans between ``u`` and ``v``, derivatives per span, ``(m - 1, n - 1, 3)``."""
    width_u, width_v = np.diff(u), np.diff(v)
    at_u, at_v = np.meshgrid(u[:-1] + 0.5 * width_u, v[:-1] + 0.5 * width_v, indexing="ij")
    step_u, step_v = np.meshgrid(width_u, width_v, indexing="ij")

    def derivative(du: int, dv: int) -> Array:
        values = surface.evaluate(at_u.ravel(), at_v.ravel(), du, dv).reshape(*at_u.shape, 3)
        return np.asarray(values * (step_u**du * step_v**dv)[:, :, None])

    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    return PatchCentres(*(derivative(*order) for order in orders))


def _blocks(points: Array, is_valid: Mask | None) -> Iterator[tuple[slice, PatchCentres]]:
    """Yield blocks of rows of patches with their centres."""
    m, n = points.shape[:2]
    complete = is_valid is None or bool(is_valid.all())
    n_rows = max(_BLOCK // n, 1)
    for start in range(0, m - 1, n_rows):
        stop = min(start + n_rows, m - 1)
        low, high = max(start - 1, 0), min(stop + 2, m)
        # One plane a coordinate: the stencils then run over contiguous rows.
        block = np.ascontiguousarray(np.moveaxis(points[low:high], 2, 0))
        before = 2.0 * block[:, :1] - block[:, 1:2] if start == 0 else block[:, :0]
        after = 2.0 * block[:, -1:] - block[:, -2:-1] if stop == m - 1 else block[:, :0]
        if before.size or after.size:
            block = np.concatenate([before, block, after], axis=1)
        if complete or is_valid is None:
            yield slice(start, stop), _complete_centres(block)
        else:
            ok = np.zeros((stop - start + 3, n), dtype=bool)
            ok[low - start + 1 : high - start + 1] = is_valid[low:high]
            yield slice(start, stop), _partial_centres(block, ok)


def _complete_centres(block: Array) -> PatchCentres:
    """Centres from planes ``(3, r + 3, n)`` without gaps."""
    inner = block[:, 1:-2], block[:, 2:-1]
    return _centres(block[:, :-3], *inner, block[:, 3:], None)


def _partial_centres(block: Array, ok: Mask) -> PatchCentres:
    """Centres from planes ``(3, r + 3, n)`` whose points are valid where ``ok``."""
    a, b, c, d = block[:, :-3], block[:, 1:-2], block[:, 2:-1], block[:, 3:]
    a = np.where(ok[:-3], a, 2.0 * b - c)
    d = np.where(ok[3:], d, 2.0 * c - b)
    return _centres(a, b, c, d, ok[1:-2] & ok[2:-1])


def _centres(a: Array, b: Array, c: Array, d: Array, ok: Mask | None) -> PatchCentres:
    """Both passes; ``ok`` tells which columns ``(r, n)`` the second may use."""
    inner, outer = b + c, a + d
    second = outer - inner
    second *= 0.5
    position = outer
    inner *= 23.0
    position += inner
    position /= 48.0
    first = c - b
    first *= 5.0
    first += d
    first -= a
    first /= 8.0
    point, dv, dvv = _along_v(position, ok, (0, 1, 2))
    du, duv = _along_v(first, ok, (0, 1))
    (duu,) = _along_v(second, ok, (0,))
    return PatchCentres(*(np.moveaxis(x, 0, 2) for x in (point, du, dv, duu, duv, dvv)))


def _along_v(values: Array, ok: Mask | None, orders: tuple[int, ...]) -> list[Array]:
    """Position (0), first (1) and second (2) derivative along columns, ``(3, r, n - 1)``."""
    shape = (*values.shape[:2], values.shape[2] + 2)
    padded = np.empty(shape)
    padded[:, :, 1:-1] = values
    padded[:, :, 0] = 2.0 * values[:, :, 0] - values[:, :, 1]
    padded[:, :, -1] = 2.0 * values[:, :, -1] - values[:, :, -2]
    a, b, c, d = padded[:, :, :-3], padded[:, :, 1:-2], padded[:, :, 2:-1], padded[:, :, 3:]
    if ok is not None:
        known = np.pad(ok, ((0, 0), (1, 1)))
        a = np.where(known[:, :-3], a, 2.0 * b - c)
        d = np.where(known[:, 3:], d, 2.0 * c - b)
    results = []
    for order in orders:
        if order == 1:
            result = c - b
            result *= 5.0
            result += d
            result -= a
            result /= 8.0
        else:
            inner, result = b + c, a + d
            if order == 0:
                inner *= 23.0
                result += inner
                result /= 48.0
            else:
                result -= inner
                result *= 0.5
        results.append(result)
    return results
