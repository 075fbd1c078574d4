"""What the grid algorithms work on: points in rows and columns, one patch a cell.

Organised points and B-spline surfaces both become a lattice, in a frame where
the spacing is 1, so that no threshold depends on the unit of the input.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crispline.errors import InputError
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array

Mask = NDArray[np.bool_]

MIN_LINES = 4
"""Rows and columns that a bicubic patch needs."""
_MIN_SIDE = 1e-9
_MAX_AREAS = 50_000


@dataclass(frozen=True, eq=False)
class Lattice:
    """Points in rows and columns with their parameters; cell ``(i, j)`` is a patch.

    Attributes
    ----------
    points : spacings, about ``origin``, shape ``(m, n, 3)``; 0 at invalid ones.
    is_valid : shape ``(m, n)``.
    u, v : parameters of rows and columns, shapes ``(m,)`` and ``(n,)``.
    spacing : root of the mean area of a cell, in the input's unit.
    origin : in the input's unit, shape ``(3,)``.
    given : the organised points or the surface that it was made of.
    """

    points: Array
    is_valid: Mask
    u: Array
    v: Array
    spacing: float
    origin: Array
    given: TensorSpline | Array

    @property
    def is_measured(self) -> bool:
        """Whether the points are data.

        Else they are samples of a given surface, which is rounded within two spans of
        a sharp feature.
        """
        return not isinstance(self.given, TensorSpline)

    @property
    def has_patch(self) -> Mask:
        """Cells whose four points are valid, shape ``(m - 1, n - 1)``."""
        ok = self.is_valid
        return ok[:-1, :-1] & ok[1:, :-1] & ok[:-1, 1:] & ok[1:, 1:]

    def to_input(self, points: Array) -> Array:
        """Points in the unit and place of the input, shape ``(..., 3)``."""
        return self.origin + self.spacing * points


Surface = TensorSpline | ArrayLike
"""What the steps take: organised points ``(m, n, 3)`` or a B-spline surface."""


def as_lattice(surface: Surface | Lattice) -> Lattice:
    """The lattice of organised points or of a surface; a lattice stays what it is."""
    if isinstance(surface, Lattice):
        return surface
    if isinstance(surface, TensorSpline):
        return lattice_of_surface(surface)
    return lattice_of_points(as_grid(surface))


def as_grid(points: ArrayLike) -> Array:
    """Organised points as an array of floats. Raises `InputError` if they are no numbers."""
    try:
        return np.asarray(points, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            "expected organised points, an array of numbers of shape (m, n, 3), got "
            f"{type(points).__name__}; rows must be of one length"
        ) from error


def lattice_of_points(points: Array) -> Lattice:
    """Lattice of organised points; parameters are row and column numbers.

    Parameters
    ----------
    points : shape ``(m, n, 3)``; a pixel is invalid if any coordinate is not finite.

    Raises
    ------
    InputError
        Not a grid, fewer than 4 rows or columns, no four valid points round a
        cell, or all points at one place.
    """
    if points.ndim != 3 or points.shape[2] != 3:
        raise InputError(
            "expected organised points, an array of shape (m, n, 3), got shape "
            f"{points.shape}; for points in no order use 'crispline reconstruct'"
        )
    if min(points.shape[:2]) < MIN_LINES:
        raise InputError(
            f"expected a grid of at least {MIN_LINES} x {MIN_LINES} points, got "
            f"{points.shape[0]} x {points.shape[1]}; a bicubic patch needs that many"
        )
    m, n = points.shape[:2]
    is_valid = _finite(points)
    if not is_valid.any():
        raise InputError(
            f"expected a grid of points, got {m} x {n} points without a single finite one; "
            "look at how invalid pixels are marked"
        )
    u, v = np.arange(float(m)), np.arange(float(n))
    return _normalised(points, is_valid, u, v, points)


def lattice_of_surface(surface: TensorSpline) -> Lattice:
    """Lattice of a B-spline surface: its points at the knots; a patch is a non-empty span.

    Raises
    ------
    InputError
        Fewer than three spans each way, or a surface shrunk to a point.
    """
    (u0, u1), (v0, v1) = surface.domain
    u = np.unique(surface.knots_u[(surface.knots_u >= u0) & (surface.knots_u <= u1)])
    v = np.unique(surface.knots_v[(surface.knots_v >= v0) & (surface.knots_v <= v1)])
    if min(len(u), len(v)) < MIN_LINES:
        raise InputError(
            f"expected a B-spline surface of at least {MIN_LINES - 1} x {MIN_LINES - 1} knot "
            f"spans, got {len(u) - 1} x {len(v) - 1}; too few patches tell flat from curved"
        )
    grid_u, grid_v = np.meshgrid(u, v, indexing="ij")
    points = surface.evaluate(grid_u.ravel(), grid_v.ravel()).reshape(len(u), len(v), 3)
    is_valid = _finite(points)
    return _normalised(points, is_valid, u, v, surface)


def _finite(points: Array) -> Mask:
    return np.asarray(np.isfinite(points).all(axis=2))


def _normalised(
    points: Array, is_valid: Mask, u: Array, v: Array, given: TensorSpline | Array
) -> Lattice:
    ok = is_valid[:-1, :-1] & is_valid[1:, :-1] & is_valid[:-1, 1:] & is_valid[1:, 1:]
    if not ok.any():
        raise InputError(
            "expected a grid with patches, got no four valid points round a cell; "
            "the valid pixels are too scattered for a surface"
        )
    spacing = _spacing(points, ok)
    known = points.reshape(-1, 3) if is_valid.all() else points[is_valid]
    origin = known.mean(axis=0)
    extent = float(np.ptp(known, axis=0).max())
    if not spacing > _MIN_SIDE * max(extent, 1e-300):
        raise InputError(
            "expected points that span a surface, got "
            + ("all points at one place" if extent == 0.0 else "points on a line")
            + "; look at the columns of the file"
        )
    local = points - origin
    local /= spacing
    if len(known) < is_valid.size:
        local[~is_valid] = 0.0
    return Lattice(local, is_valid, u, v, spacing, origin, given)


def _spacing(points: Array, ok: Mask) -> float:
    """Root of the median area of the cells; the median ignores jumps of depth.

    Large grids are thinned by whole rows.
    """
    rows = np.arange(0, len(ok), max(ok.size // _MAX_AREAS, 1))
    if not ok[rows].any():
        rows = np.arange(len(ok))
    ok = ok[rows]
    first = (points[rows + 1, 1:] - points[rows, :-1])[ok]
    second = (points[rows, 1:] - points[rows + 1, :-1])[ok]
    area = 0.5 * np.linalg.norm(np.cross(first, second), axis=1)
    return float(np.sqrt(np.median(area)))
