"""Sharpened surfaces to files; the suffix tells the format."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from crispline.errors import InputError
from crispline.exchange.mesh import write_mesh
from crispline.exchange.write import WRITE_SUFFIXES, write_surfaces
from crispline.files import check_output
from crispline.spline.creased import PolygonNet, subdivided
from crispline.spline.tensor import CUBIC, TensorSpline

if TYPE_CHECKING:
    from crispline.grid.sharpen import Sharpened

_MESH = (".ply", ".obj")
_STEP = (".step", ".stp")


def write_sharpened(
    results: Sequence[Sharpened], path: str | PathLike[str], unit: str = "mm", level: int = 3
) -> None:
    """Write sharpened surfaces whole or not at all.

    A tensor product becomes one surface in STEP, IGES, JSON (of geomdl) and NPZ. A
    creased net becomes a shell of few surfaces that share their edges in STEP, and
    those surfaces one by one in the others. PLY and OBJ get triangles.

    Parameters
    ----------
    unit : of the numbers, for STEP and IGES; see :func:`crispline.exchange.write.write_surfaces`.
    level : each patch has ``2**level`` steps a side in PLY and OBJ.

    Raises
    ------
    InputError
        Unknown suffix or unit, or the file cannot be written.
    ReconstructionError
        OCCT makes no valid shape of the surface.
    """
    path = Path(path)
    check_output(path, WRITE_SUFFIXES)
    suffix = path.suffix.lower()
    if suffix in _MESH:
        meshes = [result.mesh(level) for result in results]
        first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
        triangles = [faces + start for (_, faces), start in zip(meshes, first, strict=True)]
        write_mesh(path, np.concatenate([v for v, _ in meshes]), np.concatenate(triangles))
        return
    surfaces = [result.surface for result in results]
    if suffix in _STEP and len(surfaces) == 1 and isinstance(surfaces[0], PolygonNet):
        _write_shell(surfaces[0], path, unit)
        return
    pieces = [piece for surface in surfaces for piece in _pieces(surface)]
    write_surfaces(path, pieces, unit)


def _pieces(surface: TensorSpline | PolygonNet) -> Sequence[TensorSpline]:
    from crispline.spline.quilt import quilt

    if isinstance(surface, TensorSpline):
        return (surface,)
    faces = quilt(subdivided(surface)).faces
    return [TensorSpline(CUBIC, CUBIC, f.knots_u, f.knots_v, f.control_points) for f in faces]


def _write_shell(net: PolygonNet, path: Path, unit: str) -> None:
    from crispline.brep.patchwork import build_patchwork, write_patchwork
    from crispline.cadfile.units import MILLIMETRES

    if unit not in MILLIMETRES:
        raise InputError(
            f"expected a length unit out of {', '.join(MILLIMETRES)}, got '{unit}'; choose one"
        )
    in_mm = replace(net, vertices=net.vertices * MILLIMETRES[unit])
    write_patchwork(build_patchwork(subdivided(in_mm)), path)
