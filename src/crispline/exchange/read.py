"""B-spline surfaces and organised points from files; the suffix tells the format."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from crispline.errors import InputError
from crispline.exchange.geomdl import read_json
from crispline.exchange.grids import read_grid_npy, read_grid_pcd
from crispline.exchange.npz import read_npz
from crispline.files import readable
from crispline.spline.tensor import CUBIC, TensorSpline
from crispline.surface.base import Array

READ_SUFFIXES = (".step", ".stp", ".iges", ".igs", ".json", ".npz", ".npy", ".pcd")


@dataclass(frozen=True)
class SurfaceFile:
    """What a file held.

    Attributes
    ----------
    surfaces : each a bicubic `TensorSpline` (lower degrees are elevated, which is
        exact) or organised points of shape ``(m, n, 3)``, NaN at invalid pixels.
    unit : length unit that the file names ("mm", "in" ...); None if it names none.
    n_trimmed : how many faces cover a part of their surface that no parameter
        rectangle bounds; of these ``surfaces`` holds the whole rectangle about it.
    left_out : kinds of faces that are no B-splines, and how many there are.
    """

    surfaces: tuple[TensorSpline | Array, ...]
    unit: str | None = None
    n_trimmed: int = 0
    left_out: Mapping[str, int] = field(default_factory=dict)


def read_surfaces(path: str | PathLike[str]) -> tuple[TensorSpline | Array, ...]:
    """The surfaces in a file; `read_surface_file` also tells their unit and what was left out.

    STEP and IGES (faces with B-spline surfaces), JSON of geomdl, NPZ (see
    `crispline.exchange.npz` for the fields), and organised points: NPY of shape
    ``(m, n, 3)`` and PCD with a height. Numbers stay in the file's own unit.

    Raises
    ------
    InputError
        Missing or empty file, unknown suffix, content that is not of the format,
        no B-spline surface or grid of points in it, or a degree above 3.
    """
    return read_surface_file(path).surfaces


def read_surface_file(path: str | PathLike[str]) -> SurfaceFile:
    """Like `read_surfaces`, with the file's unit and what was left out."""
    path = Path(path)
    with readable(path, READ_SUFFIXES, "a surface"):
        return _read(path)


def _read(path: Path) -> SurfaceFile:
    match path.suffix.lower():
        case ".npy":
            return SurfaceFile((read_grid_npy(path),))
        case ".pcd":
            return SurfaceFile((read_grid_pcd(path),))
        case ".json":
            splines, n_trimmed = read_json(path)
            return SurfaceFile(_cubic(splines, path), n_trimmed=n_trimmed)
        case ".npz":
            return SurfaceFile(_cubic(read_npz(path), path))
        case _:
            from crispline.cadfile.surface_files import read_faces

            found = read_faces(path)
            return SurfaceFile(
                _cubic(found.splines, path), found.unit, found.n_trimmed, found.left_out
            )


def _cubic(splines: tuple[TensorSpline, ...], path: Path) -> tuple[TensorSpline, ...]:
    for number, spline in enumerate(splines, start=1):
        if max(spline.degree_u, spline.degree_v) > CUBIC:
            raise InputError(
                f"'{path}', surface {number}: expected degrees 1 to {CUBIC}, found "
                f"{spline.degree_u} and {spline.degree_v}; approximate it with a bicubic surface "
                "where the file was made"
            )
    return tuple(spline.elevated(CUBIC) for spline in splines)
