"""The point cloud as a value."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from crispline.errors import InputError
from crispline.surface.base import Array


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Finite points in space, in the user's unit of length.

    Attributes
    ----------
    points : coordinates, shape ``(n, 3)``, float64, ``n >= 1``.
    normals : unit normals, shape ``(n, 3)``, or None.
    n_dropped : rows of the source that held NaN or infinite coordinates and
        were left out (organised scans mark their invalid pixels so).

    Raises
    ------
    InputError
        Shapes or values other than these; `from_arrays` takes raw data.
    """

    points: Array
    normals: Array | None = None
    n_dropped: int = 0

    def __post_init__(self) -> None:
        for name, values in (("points", self.points), ("normals", self.normals)):
            if values is None:
                continue
            if values.ndim != 2 or values.shape[1] != 3 or len(values) != len(self.points):
                raise InputError(f"{name}: expected an array of shape (n, 3), got {values.shape}")
            if len(values) == 0 or not np.isfinite(values).all():
                raise InputError(
                    f"{name}: expected at least one row, all finite; "
                    "PointCloud.from_arrays drops rows that are not"
                )

    def __len__(self) -> int:
        return len(self.points)

    @classmethod
    def from_arrays(
        cls, points: ArrayLike, normals: ArrayLike | None = None, *, source: str = "points"
    ) -> PointCloud:
        """Check raw arrays and drop the rows whose coordinates are not finite.

        Parameters
        ----------
        points : real numbers, shape ``(n, 3)``.
        normals : directions of any length, shape ``(n, 3)``. They are kept only
            if every point that remains has a finite one other than zero.
        source : what error messages call the data, for example a file name.

        Raises
        ------
        InputError
            Not numbers, another shape, or no finite row.

        Examples
        --------
        >>> cloud = PointCloud.from_arrays([[0, 0, 1], [0, float("nan"), 1]])
        >>> cloud.points.tolist(), cloud.n_dropped
        ([[0.0, 0.0, 1.0]], 1)
        """
        coordinates = _rows_of_three(points, source)
        is_finite = np.isfinite(coordinates).all(axis=1)
        if not is_finite.any():
            found = f"{len(coordinates)} rows, all NaN or infinite" if len(coordinates) else "none"
            raise InputError(
                f"{source}: expected points with finite coordinates, found {found}; "
                "check that the export wrote coordinates"
            )
        directions = None
        if normals is not None:
            directions = _rows_of_three(normals, f"{source} (normals)")
            if len(directions) != len(coordinates):
                raise InputError(
                    f"{source}: expected one normal per point, "
                    f"got {len(directions)} normals for {len(coordinates)} points"
                )
            directions = _unit_or_none(directions[is_finite])
        return cls(coordinates[is_finite], directions, int(np.count_nonzero(~is_finite)))


def _rows_of_three(values: ArrayLike, source: str) -> Array:
    try:
        array = np.asarray(values)
    except ValueError as error:  # rows of different lengths
        raise InputError(f"{source}: expected an array of shape (n, 3), got {error}") from error
    if array.ndim != 2 or array.shape[1] != 3:
        hint = "; transpose it" if array.ndim == 2 and array.shape[0] == 3 else ""
        raise InputError(f"{source}: expected an array of shape (n, 3), got {array.shape}{hint}")
    if array.dtype.kind not in "iuf":
        raise InputError(f"{source}: expected real numbers, got values of type {array.dtype}")
    return np.ascontiguousarray(array, dtype=np.float64)


def _unit_or_none(directions: Array) -> Array | None:
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    usable = np.isfinite(length) & (length > 0.0)
    return directions / length if usable.all() else None
