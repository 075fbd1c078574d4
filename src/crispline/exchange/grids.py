"""Organised points from files: points in rows and columns, as range cameras deliver them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crispline.errors import InputError
from crispline.files import decoded
from crispline.spline.checked import checked_grid
from crispline.surface.base import Array


def read_grid_npy(path: Path) -> Array:
    """Points from an NPY file, shape ``(m, n, 3)``; see `checked_grid` for invalid pixels.

    Raises
    ------
    InputError
        Not an NPY file, or not a grid of points.
    """
    try:
        points = np.load(path, allow_pickle=False)
    except OSError:
        raise
    except Exception as error:  # NumPy parses the header as Python and raises anything
        raise InputError(
            f"'{path}': expected an NPY file, found content that cannot be read as one ({error}); "
            "check that it is complete"
        ) from error
    return checked_grid(points, f"'{path}'")


def read_grid_pcd(path: Path) -> Array:
    """Points from an organised PCD file: its height is the number of rows.

    Returns
    -------
    Shape ``(height, width, 3)``; see `checked_grid` for invalid pixels.

    Raises
    ------
    InputError
        Not a PCD file, one without x, y and z, or one whose points are not organised.
    """
    from pypcd4.pypcd4 import PointCloud

    with decoded(path, "a PCD file with x, y and z"):
        content = PointCloud.from_path(path)
        points = content.numpy(("x", "y", "z"))
    rows, columns = content.metadata.height, content.metadata.width
    if rows < 2 or rows * columns != len(points):
        raise InputError(
            f"'{path}': expected organised points, with a HEIGHT of more than 1, found "
            f"{columns} x {rows} for {len(points)} points; keep the rows of the range image, "
            "or use the reconstruction from unorganised points"
        )
    return checked_grid(points.reshape(rows, columns, 3), f"'{path}'")
