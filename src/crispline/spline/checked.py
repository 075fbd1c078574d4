"""B-spline surfaces from outside: every way in which their numbers can be wrong, one sentence."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from crispline.errors import InputError
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array


def checked_spline(
    degree_u: int,
    degree_v: int,
    knots_u: ArrayLike,
    knots_v: ArrayLike,
    control_points: ArrayLike,
    weights: ArrayLike | None = None,
    where: str = "the surface",
) -> TensorSpline:
    """A surface whose numbers make sense; shapes as for `TensorSpline`.

    Equal weights are dropped, since the surface is then not rational.

    Parameters
    ----------
    where : what the sentence of an error begins with, for example the file's name.

    Raises
    ------
    InputError
        No control points or too few for the degree, values that are not finite,
        knots of the wrong count, decreasing or repeated so often that the surface
        tears, weights that are not positive.
    """
    net = _floats(control_points, "control points", where)
    if net.size == 0:
        raise InputError(
            f"{where}: expected control points, found none; export the surface itself, "
            "not only its outline"
        )
    if net.ndim != 3 or net.shape[2] != 3:
        raise InputError(
            f"{where}: expected control points in rows and columns, an array of shape "
            f"(n_u, n_v, 3), found shape {net.shape}; give three coordinates for each"
        )
    _require_finite(net, "control points", where)
    axes = (("u", degree_u, knots_u, net.shape[0]), ("v", degree_v, knots_v, net.shape[1]))
    checked_u, checked_v = (_checked_knots(*axis, where) for axis in axes)
    return TensorSpline(
        int(degree_u),
        int(degree_v),
        checked_u,
        checked_v,
        net,
        _checked_weights(weights, net, where),
    )


def _checked_knots(name: str, degree: int, knots: ArrayLike, n: int, where: str) -> Array:
    if int(degree) != degree or degree < 1:
        raise InputError(
            f"{where}: expected a degree_{name} of at least 1, found {degree}; "
            "a surface of degree 0 is not connected"
        )
    if n <= degree:
        raise InputError(
            f"{where}: expected at least {degree + 1} control points along {name} for degree "
            f"{degree}, found {n}; lower the degree or add control points"
        )
    values = _floats(knots, f"knots_{name}", where)
    if values.shape != (n + degree + 1,):
        raise InputError(
            f"{where}: expected {n + degree + 1} knots_{name} ({n} control points + degree "
            f"{degree} + 1), found shape {values.shape}; write out every repeated knot"
        )
    _require_finite(values, f"knots_{name}", where)
    falls = np.flatnonzero(np.diff(values) < 0.0)
    if len(falls):
        i = int(falls[0])
        raise InputError(
            f"{where}: expected knots_{name} that never decrease, found {values[i]:.6g} followed "
            f"by {values[i + 1]:.6g} at place {i + 1}; put them in order"
        )
    # A knot may fill a whole support only where it ends the domain.
    is_torn = values[1:n] == values[1 + degree : n + degree]
    is_torn &= (values[1:n] > values[degree]) & (values[1:n] < values[n])
    has_dead_end = values[degree] == values[degree + 1] or values[n - 1] == values[n]
    if is_torn.any() or has_dead_end:
        most = degree + 1 if has_dead_end else degree
        raise InputError(
            f"{where}: expected every one of knots_{name} at most {degree} times inside and "
            f"{degree + 1} times at the ends, found one more than {most} times; "
            "split the surface there"
        )
    return values


def _checked_weights(weights: ArrayLike | None, net: Array, where: str) -> Array | None:
    if weights is None:
        return None
    values = _floats(weights, "weights", where)
    if values.shape != net.shape[:2]:
        raise InputError(
            f"{where}: expected one weight for each control point, shape {net.shape[:2]}, "
            f"found shape {values.shape}; leave the weights out if the surface is not rational"
        )
    _require_finite(values, "weights", where)
    if values.min() <= 0.0:
        i, j = np.unravel_index(int(values.argmin()), values.shape)
        raise InputError(
            f"{where}: expected positive weights, found {values.min():.6g} at ({i}, {j}); "
            "a surface with such a weight has points at infinity"
        )
    return None if values.min() == values.max() else values


def _floats(values: ArrayLike, what: str, where: str) -> Array:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{where}: expected {what} as an array of numbers, found other content ({error}); "
            "check the export"
        ) from error


def _require_finite(values: Array, what: str, where: str) -> None:
    n_bad = int(values.size - np.count_nonzero(np.isfinite(values)))
    if n_bad:
        raise InputError(
            f"{where}: expected finite {what}, found {n_bad} values that are NaN or infinite; "
            "export the surface again"
        )


def checked_grid(points: ArrayLike, where: str = "the grid") -> Array:
    """Organised points whose numbers make sense, as a new array of shape ``(m, n, 3)``.

    A pixel with a coordinate that is not finite is invalid and becomes NaN as a
    whole. So do pixels at exactly (0, 0, 0), the mark of many range cameras, if
    there is more than one of them.

    Parameters
    ----------
    points : shape ``(m, n, 3)``; rows and columns as in the grid, at least 4 each.
    where : what the sentence of an error begins with.

    Raises
    ------
    InputError
        Not a grid of points with three coordinates, too small for a bicubic
        patch, or without two different valid points.
    """
    grid = _floats(points, "points", where)
    if grid.ndim != 3 or grid.shape[2] != 3:
        hint = "arrange the points in rows and columns"
        if grid.ndim == 2:
            hint = (
                "rebuild the rows and columns, or use the reconstruction from unorganised points"
                if grid.shape[1] == 3
                else "turn a depth image into x, y and z of every pixel first"
            )
        raise InputError(
            f"{where}: expected a grid of points, an array of shape (m, n, 3), "
            f"found shape {grid.shape}; {hint}"
        )
    if min(grid.shape[:2]) < 4:
        raise InputError(
            f"{where}: expected at least 4 rows and 4 columns of points, found "
            f"{grid.shape[0]} x {grid.shape[1]}; a bicubic patch takes 4 x 4"
        )
    is_zero = np.all(grid == 0.0, axis=2)
    if np.count_nonzero(is_zero) > 1:
        grid[is_zero] = np.nan
    grid[~np.isfinite(grid).all(axis=2)] = np.nan
    valid = grid[np.isfinite(grid[:, :, 0])]
    if len(valid) == 0:
        raise InputError(
            f"{where}: expected finite points, found none; NaN, infinity and (0, 0, 0) mark "
            "pixels without a point"
        )
    if np.all(valid == valid[0]):
        raise InputError(
            f"{where}: expected a surface, found one point {len(valid)} times; export it again"
        )
    return grid
