"""The point cloud as a value."""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crispline.errors import InputError
from crispline.surface.base import Array


@dataclass(frozen=True, eq=False)
class PointCloud:
    """Finite points in space, in the user's unit of length.

    Attributes
    ----------
    points : coordinates, shape ``(n, 3)``, float64, ``n >= 1``.
    normals : unit normals, shape ``(n, 3)``, zero where the source has none; or None.
    viewpoints : where the scanner stood for each point, shape ``(n, 3)``, or None.
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
    viewpoints: Array | None = None

    def __post_init__(self) -> None:
        named = {"points": self.points, "normals": self.normals, "viewpoints": self.viewpoints}
        for name, values in named.items():
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
        cls,
        points: ArrayLike,
        normals: ArrayLike | None = None,
        viewpoints: ArrayLike | None = None,
        *,
        source: str = "points",
    ) -> PointCloud:
        """Check raw arrays and drop the rows whose coordinates are not finite.

        Parameters
        ----------
        points : real numbers, shape ``(n, 3)``.
        normals : directions of any length, shape ``(n, 3)``; those that are zero or not
            finite become zero: not known.
        viewpoints : where the scanner stood for each point, shape ``(n, 3)``; kept
            only if they are finite.
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
        is_finite = np.asarray(np.isfinite(coordinates).all(axis=1))
        if not is_finite.any():
            found = f"{len(coordinates)} rows, all NaN or infinite" if len(coordinates) else "none"
            raise InputError(
                f"{source}: expected points with finite coordinates, found {found}; "
                "check that the export wrote coordinates"
            )
        kept = {
            name: _beside(values, name, is_finite, source)
            for name, values in (("normals", normals), ("viewpoints", viewpoints))
        }
        return cls(
            points=coordinates[is_finite],
            normals=_unit_or_none(kept["normals"]),
            n_dropped=int(np.count_nonzero(~is_finite)),
            viewpoints=_finite_or_none(kept["viewpoints"]),
        )

    @classmethod
    def from_any(cls, source: object) -> PointCloud:
        """A cloud out of whatever holds points.

        A `PointCloud` as it is, a file name (see `crispline.read_points`), a
        point cloud of Open3D (with its normals; legacy or tensor), a point cloud
        or the vertices of a mesh of trimesh, points of PyVista, or an array of
        shape ``(n, 3)``. None of these packages is imported.

        Raises
        ------
        InputError
            None of these, or numbers that make no cloud; see `from_arrays`.
        """
        if isinstance(source, cls):
            return source
        if isinstance(source, str | PathLike):
            from crispline.cloud.read import read_points

            return read_points(source)
        points, normals = _held(source)
        return cls.from_arrays(points, normals)


def _held(source: Any) -> tuple[Any, Any]:
    """Points and normals of an object, told by the names that the packages give them."""
    if hasattr(source, "point") and hasattr(source.point, "positions"):  # open3d.t.geometry
        positions = source.point
        has_normals = "normals" in positions
        return positions.positions.numpy(), positions.normals.numpy() if has_normals else None
    if hasattr(source, "has_normals"):  # open3d.geometry
        normals = np.asarray(source.normals) if source.has_normals() else None
        return np.asarray(source.points), normals
    for name in ("vertices", "points"):  # trimesh; PyVista
        if hasattr(source, name):
            return np.asarray(getattr(source, name)), None
    return source, None


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


def _beside(
    values: ArrayLike | None, name: str, is_kept: NDArray[np.bool_], source: str
) -> Array | None:
    """The rows that go with the kept points."""
    if values is None:
        return None
    rows = _rows_of_three(values, f"{source} ({name})")
    if len(rows) != len(is_kept):
        raise InputError(
            f"{source}: expected one row of {name} per point, "
            f"got {len(rows)} {name} for {len(is_kept)} points"
        )
    return rows[is_kept]


def _unit_or_none(directions: Array | None) -> Array | None:
    if directions is None:
        return None
    length = np.linalg.norm(directions, axis=1, keepdims=True)
    is_known = np.isfinite(length) & (length > 0.0)
    if not is_known.any():
        return None
    return np.where(is_known, directions, 0.0) / np.where(is_known, length, 1.0)


def _finite_or_none(rows: Array | None) -> Array | None:
    return rows if rows is not None and np.isfinite(rows).all() else None
