"""Point clouds to files."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crispline.files import atomic_path, check_output
from crispline.surface.base import Array

WRITE_SUFFIXES = (".ply", ".xyz", ".npy")


def write_points(path: Path, points: Array) -> None:
    """Write points, shape ``(n, 3)``, whole or not at all; the suffix tells the format.

    PLY is binary with single precision, as scanners write it (it resolves
    6e-8 of the largest coordinate); XYZ and NPY keep double precision.

    Raises
    ------
    InputError
        Unknown suffix, or the file cannot be written.
    """
    check_output(path, WRITE_SUFFIXES)
    with atomic_path(path) as draft:
        match path.suffix.lower():
            case ".ply":
                draft.write_bytes(_ply_header(len(points)) + points.astype("<f4").tobytes())
            case ".xyz":
                np.savetxt(draft, points, fmt="%.17g")
            case _:
                np.save(draft, points)


def _ply_header(n_points: int) -> bytes:
    lines = (
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {n_points}",
        "property float x",
        "property float y",
        "property float z",
        "end_header",
    )
    return "".join(f"{line}\n" for line in lines).encode("ascii")
