"""STEP and IGES files of B-spline faces, with numbers in the file's own length unit.

OCCT works in millimetres. Here a surface keeps the numbers that stand in its
file, and the unit goes along as a name: what is read in inches and written with
``unit="in"`` has the same numbers again.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from OCP.BRepCheck import BRepCheck_Analyzer

from crispline import occt
from crispline.cadfile.iges import iges_bytes
from crispline.cadfile.shape_files import STEP_SUFFIXES, read_millimetres
from crispline.cadfile.step import step_bytes
from crispline.cadfile.units import MILLIMETRES, OCCT_NAMES, checked_unit
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path
from crispline.occt.surfaces import face_shape, faces_from_occt, scaled
from crispline.spline.tensor import TensorSpline


@dataclass(frozen=True)
class FaceFile:
    """The B-spline faces of a STEP or IGES file.

    Attributes
    ----------
    splines : lengths in ``unit``; normals on the outer sides of the faces.
    unit : one of `MILLIMETRES`; the file's own, or "mm" if that is a rarer one,
        whose lengths are then converted.
    n_trimmed : how many faces cover a part of their surface that no parameter
        rectangle bounds; of these ``splines`` holds the whole rectangle about it.
    left_out : kinds of the other faces, and how many there are.
    """

    splines: tuple[TensorSpline, ...]
    unit: str
    n_trimmed: int
    left_out: Mapping[str, int]


def read_faces(path: Path) -> FaceFile:
    """The B-spline (and Bezier) faces in a STEP or IGES file; the suffix tells which.

    Raises
    ------
    InputError
        Not such a file, or one without a B-spline face; the sentence names the
        kinds of faces that were found.
    """
    shape, unit = read_millimetres(path)
    faces = faces_from_occt(shape, f"'{path}'")
    if not faces.splines:
        kind = "a STEP" if path.suffix.lower() in STEP_SUFFIXES else "an IGES"
        kinds = ", ".join(f"{count} {name}" for name, count in sorted(faces.left_out.items()))
        raise InputError(
            f"'{path}': expected {kind} file with B-spline faces, found "
            f"{f'faces of other kinds ({kinds})' if kinds else 'no face'}; "
            "convert the faces to B-splines (NURBS) where the file was made"
        )
    splines = tuple(scaled(spline, 1.0 / MILLIMETRES[unit]) for spline in faces.splines)
    return FaceFile(splines, unit, faces.n_trimmed, faces.left_out)


def write_faces(path: Path, splines: Sequence[TensorSpline], unit: str = "mm") -> None:
    """Write surfaces as the faces of a STEP or IGES file; the suffix tells which.

    Every surface becomes one face, creased or not, bounded by the ends of its
    domain. The file appears whole or not at all, with the same bytes for the
    same surfaces.

    Parameters
    ----------
    unit : one of `MILLIMETRES`; the numbers are taken to be in it.

    Raises
    ------
    InputError
        Unknown unit, or the file cannot be written.
    ReconstructionError
        OCCT makes no valid face of a surface, or cannot read it back.
    """
    checked_unit(unit)
    shape = face_shape([scaled(spline, MILLIMETRES[unit]) for spline in splines])
    name = OCCT_NAMES[unit]
    is_step = path.suffix.lower() in STEP_SUFFIXES
    content: Callable[[bool], bytes] = (
        (lambda has_pcurves: step_bytes(shape, has_pcurves, name))
        if is_step
        else (lambda _: iges_bytes(shape, name))
    )
    with atomic_path(path) as draft:
        for has_pcurves in (False, True):
            draft.write_bytes(content(has_pcurves))
            if _is_sound(draft, len(splines)):
                return
        raise ReconstructionError(
            f"'{path}': the surfaces are valid in memory, but the file of them does not read "
            "back as the same faces; write NPZ or JSON instead"
        )


def _is_sound(path: Path, n_faces: int) -> bool:
    try:
        shape, _ = read_millimetres(path)
    except InputError:
        return False
    n_read = len(occt.subshapes(shape, occt.FACE))
    return n_read == n_faces and bool(BRepCheck_Analyzer(shape).IsValid())
