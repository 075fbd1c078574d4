"""E57 (ASTM E2807), the files of terrestrial scanners: several scans, each with its pose."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from crispline.cloud.raw import RawCloud
from crispline.errors import InputError
from crispline.extras import optional
from crispline.surface.base import Array

_CARTESIAN = ("cartesianX", "cartesianY", "cartesianZ")
_SPHERICAL = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")


def read_e57(path: Path) -> RawCloud:
    """All scans of an E57 file, joined in the file's common frame.

    Points that a scan marks as invalid (pixels of an organised scan without a
    return) become NaN. The viewpoint of a point is the origin of its scan's pose.

    Raises
    ------
    InputError
        pye57 is not installed, or the file holds no scan with points.
    """
    pye57 = optional("pye57", "e57", "E57 files")
    with pye57.E57(str(path)) as file:
        scans = [_scan(file, index) for index in range(file.scan_count)]
    scans = [scan for scan in scans if len(scan[0])]
    if not scans:
        raise InputError(f"'{path}': expected scans with points, found none; export it again")
    return RawCloud(
        np.concatenate([points for points, _ in scans]),
        viewpoints=np.concatenate(
            [np.broadcast_to(origin, points.shape) for points, origin in scans]
        ),
    )


def _scan(file: Any, index: int) -> tuple[Array, Array]:
    """Points of one scan, shape ``(n, 3)``, and its origin, both in the common frame."""
    header = file.get_header(index)
    origin = np.asarray(header.translation, dtype=np.float64)
    if header.point_count == 0:
        return np.empty((0, 3)), origin
    fields = file.read_scan_raw(index, ignore_unsupported_fields=True)
    if set(_CARTESIAN) <= set(fields):
        points = np.column_stack([fields[name] for name in _CARTESIAN])
        state = fields.get("cartesianInvalidState")
    elif set(_SPHERICAL) <= set(fields):
        points = _from_spherical(*(fields[name] for name in _SPHERICAL))
        state = fields.get("sphericalInvalidState")
    else:
        raise ValueError(f"scan {index + 1} has neither Cartesian nor spherical coordinates")
    w, x, y, z = header.rotation
    placed = Rotation.from_quat([x, y, z, w]).apply(points) + origin
    if state is not None:
        # State 1 knows the direction of a point only, state 2 nothing.
        placed[np.asarray(state) != 0] = np.nan
    return placed, origin


def _from_spherical(distance: Array, azimuth: Array, elevation: Array) -> Array:
    """Cartesian coordinates, shape ``(n, 3)``; angles in radians, elevation from the xy plane.

    References
    ----------
    ASTM E2807, section on coordinate systems.
    """
    level = distance * np.cos(elevation)
    return np.column_stack(
        [level * np.cos(azimuth), level * np.sin(azimuth), distance * np.sin(elevation)]
    )
