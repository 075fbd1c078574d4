"""Point clouds from files."""

from __future__ import annotations

from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.raw import RawCloud
from crispline.cloud.read_arrays import read_npy, read_npz
from crispline.cloud.read_e57 import read_e57
from crispline.cloud.read_las import read_las
from crispline.cloud.text import parse_table
from crispline.files import decoded, readable


def read_points(path: str | PathLike[str]) -> PointCloud:
    """Read a point cloud; the suffix tells the format.

    PLY, PCD, LAS and LAZ (extra ``las``), E57 (extra ``e57``), NPY, NPZ, text
    tables (XYZ, TXT, CSV, ASC, PTS) and the vertices of OBJ, STL and OFF meshes.
    Points keep the order of the file; only STL, which repeats every vertex for
    each of its triangles, is reduced to its distinct vertices. Coordinates are
    float64 all the way. Rows with NaN or infinite coordinates are dropped and
    counted in `PointCloud.n_dropped`.

    Raises
    ------
    InputError
        Missing or empty file, unknown suffix, content that is not of the
        format, no point with finite coordinates, or a package that reads the
        format is not installed.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    with (
        readable(path, tuple(_READERS), "points"),
        decoded(path, f"a {suffix[1:].upper()} file"),
    ):
        raw = _READERS[suffix](path)
    return PointCloud.from_arrays(raw.points, raw.normals, raw.viewpoints, source=f"'{path}'")


def _read_ply(path: Path) -> RawCloud:
    from trimesh.exchange.ply import load_ply

    with path.open("rb") as file:
        # Texture repair would split and reorder the vertices.
        content = load_ply(file, fix_texture=False, skip_materials=True)
    points = content.get("vertices", np.empty((0, 3)))
    n_declared = content["metadata"]["_ply_raw"]["vertex"]["length"]
    if len(points) != n_declared:
        raise ValueError(f"{n_declared} vertices declared, {len(points)} present")
    return RawCloud(points, content.get("vertex_normals"))


def _read_stl(path: Path) -> RawCloud:
    from trimesh.exchange.stl import load_stl

    with path.open("rb") as file:
        content = load_stl(file)
    solids = content.get("geometry", {"": content}).values()
    corners = [solid["vertices"] for solid in solids]
    if not corners:
        raise ValueError("no triangle")
    return RawCloud(np.unique(np.concatenate(corners), axis=0))


def _read_off(path: Path) -> RawCloud:
    from trimesh.exchange.off import load_off

    with path.open("rb") as file:
        return RawCloud(load_off(file)["vertices"])


def _read_pcd(path: Path) -> RawCloud:
    from pypcd4.pypcd4 import PointCloud as PcdFile

    content = PcdFile.from_path(path)
    points = content.numpy(("x", "y", "z"))
    has_normals = {"normal_x", "normal_y", "normal_z"} <= set(content.fields)
    normals = content.numpy(("normal_x", "normal_y", "normal_z")) if has_normals else None
    viewpoint = np.array(content.metadata.viewpoint[:3])
    # Every writer puts the origin there if it knows none; only a range image is seen from it.
    is_known = viewpoint.any() or content.metadata.height > 1
    return RawCloud(points, normals, np.broadcast_to(viewpoint, points.shape) if is_known else None)


def _read_text(path: Path) -> RawCloud:
    return _table(path)


def _read_obj(path: Path) -> RawCloud:
    # The vertex records themselves: mesh loaders drop vertices that no face uses.
    return _table(path, keyword="v")


def _table(path: Path, keyword: str = "") -> RawCloud:
    return RawCloud(*parse_table(_text(path), f"'{path}'", keyword=keyword))


def _text(path: Path) -> str:
    content = path.read_bytes()
    if b"\0" in content:
        raise ValueError("binary data")
    return content.decode("utf-8-sig", errors="replace")


_READERS: dict[str, Callable[[Path], RawCloud]] = {
    ".asc": _read_text,
    ".csv": _read_text,
    ".e57": read_e57,
    ".las": read_las,
    ".laz": read_las,
    ".npy": read_npy,
    ".npz": read_npz,
    ".obj": _read_obj,
    ".off": _read_off,
    ".pcd": _read_pcd,
    ".ply": _read_ply,
    ".pts": _read_text,
    ".stl": _read_stl,
    ".txt": _read_text,
    ".xyz": _read_text,
}
READ_SUFFIXES = tuple(_READERS)
