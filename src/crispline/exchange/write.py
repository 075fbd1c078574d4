"""B-spline surfaces to files; the suffix tells the format."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

import numpy as np

from crispline.errors import InputError
from crispline.exchange.geomdl import write_json
from crispline.exchange.mesh import tessellate, write_mesh
from crispline.exchange.npz import write_npz
from crispline.files import check_output
from crispline.spline.tensor import TensorSpline

WRITE_SUFFIXES = (".step", ".stp", ".iges", ".igs", ".json", ".npz", ".ply", ".obj")


def write_surfaces(
    path: str | PathLike[str],
    surfaces: TensorSpline | Sequence[TensorSpline],
    unit: str = "mm",
    per_span: int = 4,
) -> None:
    """Write surfaces whole or not at all; the same bytes for the same surfaces.

    STEP and IGES get one face for each surface, creased or not, over clamped
    knots. JSON (of geomdl) and NPZ keep the knots as they are and every digit.
    PLY and OBJ get triangles.

    Parameters
    ----------
    unit : of the numbers ("mm", "um", "cm", "m", "km", "in", "mil", "ft"); STEP and
        IGES name it, the other formats have none.
    per_span : pieces of each span between knots, both ways, for triangles.

    Raises
    ------
    InputError
        No surface, one with values that are not finite, unknown suffix or unit,
        or the file cannot be written.
    ReconstructionError
        OCCT makes no valid face of a surface.
    """
    path = Path(path)
    check_output(path, WRITE_SUFFIXES)
    splines = [surfaces] if isinstance(surfaces, TensorSpline) else list(surfaces)
    if not splines:
        raise InputError(f"cannot write '{path}': expected at least one surface, got none")
    for number, spline in enumerate(splines, start=1):
        n_bad = int(np.count_nonzero(~np.isfinite(spline.control_points).all(axis=2)))
        if n_bad:
            raise InputError(
                f"cannot write '{path}': expected finite control points, surface {number} has "
                f"{n_bad} that are not; fill or cut off the invalid pixels first"
            )
    match path.suffix.lower():
        case ".json":
            write_json(path, splines)
        case ".npz":
            write_npz(path, splines)
        case ".ply" | ".obj":
            meshes = [tessellate(spline, per_span) for spline in splines]
            first = np.cumsum([0, *(len(vertices) for vertices, _ in meshes[:-1])])
            write_mesh(
                path,
                np.concatenate([vertices for vertices, _ in meshes]),
                np.concatenate(
                    [triangles + i for (_, triangles), i in zip(meshes, first, strict=True)]
                ),
            )
        case _:
            from crispline.cadfile.surface_files import write_faces

            write_faces(path, splines, unit)
