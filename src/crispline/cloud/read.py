"""Point clouds from files."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.text import parse_table
from crispline.files import decoded, readable

# Points and, if the file has them, normals; both shape (n, 3) and as they stand in the file.
_Raw = tuple[NDArray[np.generic], NDArray[np.generic] | None]


def read_points(path: str | PathLike[str]) -> PointCloud:
    """Read a point cloud; the suffix tells the format.

    PLY, PCD, NPY (an array of shape ``(n, 3)`` or wider), text tables (XYZ, TXT,
    CSV, ASC, PTS) and the vertices of OBJ, STL and OFF meshes. Points keep the
    order of the file; only STL, which repeats every vertex for each of its
    triangles, is reduced to its distinct vertices. Rows with NaN or infinite
    coordinates are dropped and counted in `PointCloud.n_dropped`.

    Raises
    ------
    InputError
        Missing or empty file, unknown suffix, content that is not of the
        format, or no point with finite coordinates.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    with (
        readable(path, tuple(_READERS), "points"),
        decoded(path, f"a {suffix[1:].upper()} file"),
    ):
        points, normals = _READERS[suffix](path)
    return PointCloud.from_arrays(points, normals, source=f"'{path}'")


def _read_ply(path: Path) -> _Raw:
    from trimesh.exchange.ply import load_ply

    with path.open("rb") as file:
        # Texture repair would split and reorder the vertices.
        content = load_ply(file, fix_texture=False, skip_materials=True)
    points = content.get("vertices", np.empty((0, 3)))
    n_declared = content["metadata"]["_ply_raw"]["vertex"]["length"]
    if len(points) != n_declared:
        raise ValueError(f"{n_declared} vertices declared, {len(points)} present")
    return points, content.get("vertex_normals")


def _read_stl(path: Path) -> _Raw:
    from trimesh.exchange.stl import load_stl

    with path.open("rb") as file:
        content = load_stl(file)
    solids = content.get("geometry", {"": content}).values()
    corners = [solid["vertices"] for solid in solids]
    if not corners:
        raise ValueError("no triangle")
    return np.unique(np.concatenate(corners), axis=0), None


def _read_off(path: Path) -> _Raw:
    from trimesh.exchange.off import load_off

    with path.open("rb") as file:
        return load_off(file)["vertices"], None


def _read_pcd(path: Path) -> _Raw:
    from pypcd4.pypcd4 import PointCloud as PcdFile

    content = PcdFile.from_path(path)
    has_normals = {"normal_x", "normal_y", "normal_z"} <= set(content.fields)
    normals = content.numpy(("normal_x", "normal_y", "normal_z")) if has_normals else None
    return content.numpy(("x", "y", "z")), normals


def _read_npy(path: Path) -> _Raw:
    array = np.load(path, allow_pickle=False)
    if array.ndim == 2 and array.shape[0] != 3:  # three rows are more likely a transposed cloud
        array = array[:, :3]
    return array, None


def _read_text(path: Path) -> _Raw:
    return parse_table(_text(path), f"'{path}'")


def _read_obj(path: Path) -> _Raw:
    # The vertex records themselves: mesh loaders drop vertices that no face uses.
    return parse_table(_text(path), f"'{path}'", keyword="v")


def _text(path: Path) -> str:
    content = path.read_bytes()
    if b"\0" in content:
        raise ValueError("binary data")
    return content.decode("utf-8-sig", errors="replace")


_READERS: dict[str, Callable[[Path], _Raw]] = {
    ".asc": _read_text,
    ".csv": _read_text,
    ".npy": _read_npy,
    ".obj": _read_obj,
    ".off": _read_off,
    ".pcd": _read_pcd,
    ".ply": _read_ply,
    ".pts": _read_text,
    ".stl": _read_stl,
    ".txt": _read_text,
    ".xyz": _read_text,
}
