"""Point clouds to files."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from crispline.cloud.pointcloud import PointCloud
from crispline.extras import optional
from crispline.files import atomic_path, check_output
from crispline.surface.base import Array

_XYZ = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_LAS_STEPS = 2**31 - 2
_LAS_DATE = date(1970, 1, 1)


def write_points(path: Path, cloud: PointCloud | ArrayLike) -> None:
    """Write a cloud whole or not at all; the suffix tells the format.

    PLY (binary), PCD (binary), XYZ, TXT and CSV, NPY, NPZ, LAS and LAZ (extra
    ``las``). Normals go along except in NPY; viewpoints in NPZ. Coordinates
    are written in double precision; PLY and PCD take single precision for a
    cloud that loses nothing by it. LAS holds integers by its definition: the step is
    the smallest power of ten that fits (1e-7 for an extent of 100), about the centre.

    Parameters
    ----------
    cloud : points with what belongs to them, or an array of shape ``(n, 3)``.

    Raises
    ------
    InputError
        Unknown suffix, an extra that is missing, or the file cannot be written.
    """
    check_output(path, WRITE_SUFFIXES)
    whole = cloud if isinstance(cloud, PointCloud) else PointCloud.from_arrays(cloud)
    with atomic_path(path) as draft:
        _WRITERS[path.suffix.lower()](draft, whole)


def _columns(cloud: PointCloud) -> Array:
    return np.hstack([part for part in (cloud.points, cloud.normals) if part is not None])


def _names(cloud: PointCloud, normal: tuple[str, ...] = _NORMAL) -> tuple[str, ...]:
    return _XYZ if cloud.normals is None else _XYZ + normal


def _record(cloud: PointCloud) -> NDArray[np.void]:
    """Coordinates in the shortest type that holds them, normals in single precision; a row each."""
    is_single = np.array_equal(cloud.points.astype("<f4"), cloud.points)
    names = _names(cloud)
    kinds = ["<f4" if is_single else "<f8"] * 3 + ["<f4"] * (len(names) - 3)
    record = np.empty(len(cloud), dtype=list(zip(names, kinds, strict=True)))
    for name, column in zip(names, _columns(cloud).T, strict=True):
        record[name] = column
    return record


def _write_ply(path: Path, cloud: PointCloud) -> None:
    record = _record(cloud)
    assert record.dtype.names is not None
    kinds = {4: "float", 8: "double"}
    properties = (f"{kinds[record.dtype[name].itemsize]} {name}" for name in record.dtype.names)
    header = (
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(record)}",
        *(f"property {one}" for one in properties),
        "end_header",
    )
    text = "".join(f"{line}\n" for line in header)
    path.write_bytes(text.encode("ascii") + record.tobytes())


def _write_pcd(path: Path, cloud: PointCloud) -> None:
    from pypcd4.pypcd4 import PointCloud as PcdFile

    record = _record(cloud)
    fields = _names(cloud, ("normal_x", "normal_y", "normal_z"))
    columns = [record[name] for name in _names(cloud)]
    PcdFile.from_points(columns, fields, [column.dtype for column in columns]).save(path)


def _write_text(path: Path, cloud: PointCloud) -> None:
    # Without normals the bare rows that every reader of XYZ takes.
    header = "" if cloud.normals is None else " ".join(_names(cloud))
    np.savetxt(path, _columns(cloud), fmt="%.17g", header=header, comments="# ")


def _write_csv(path: Path, cloud: PointCloud) -> None:
    header = ",".join(_names(cloud))
    np.savetxt(path, _columns(cloud), fmt="%.17g", delimiter=",", header=header, comments="")


def _write_npy(path: Path, cloud: PointCloud) -> None:
    np.save(path, cloud.points)


def _write_npz(path: Path, cloud: PointCloud) -> None:
    arrays = {"normals": cloud.normals, "viewpoints": cloud.viewpoints}
    known: dict[str, Any] = {name: array for name, array in arrays.items() if array is not None}
    np.savez(path, points=cloud.points, **known)


def _write_las(path: Path, cloud: PointCloud) -> None:
    laspy: Any = optional("laspy", "las", "LAS files")
    if path.suffix.lower() == ".laz":
        optional("lazrs", "las", "LAZ files")
    low, high = cloud.points.min(axis=0), cloud.points.max(axis=0)
    centre = np.round(0.5 * (low + high))
    reach = float(np.abs(cloud.points - centre).max())
    step = 10.0 ** math.ceil(math.log10(max(reach, 1e-300) / _LAS_STEPS))
    header = laspy.LasHeader(point_format=6, version="1.4")
    header.offsets, header.scales = centre, np.full(3, step)
    header.generating_software, header.creation_date = "crispline", _LAS_DATE
    if cloud.normals is not None:
        header.add_extra_dims(
            [laspy.ExtraBytesParams(f"Normal{axis}", np.float32) for axis in "XYZ"]
        )
    content = laspy.LasData(header)
    content.xyz = cloud.points
    if cloud.normals is not None:
        for axis, column in zip("XYZ", cloud.normals.T, strict=True):
            content[f"Normal{axis}"] = column
    content.write(path)


_WRITERS: dict[str, Callable[[Path, PointCloud], None]] = {
    ".csv": _write_csv,
    ".las": _write_las,
    ".laz": _write_las,
    ".npy": _write_npy,
    ".npz": _write_npz,
    ".pcd": _write_pcd,
    ".ply": _write_ply,
    ".txt": _write_text,
    ".xyz": _write_text,
}
WRITE_SUFFIXES = tuple(_WRITERS)
