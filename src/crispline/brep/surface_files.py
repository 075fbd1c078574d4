"""STEP and IGES files of B-spline faces, with numbers in the file's own length unit.

OCCT works in millimetres. Here a surface keeps the numbers that stand in its
file, and the unit goes along as a name: what is read in inches and written with
``unit="in"`` has the same numbers again.
"""

from __future__ import annotations

import io
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.collections import Sequence_TCollection_AsciiString
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Controller, IGESControl_Reader, IGESControl_Writer
from OCP.IGESData import IGESData_IGESWriter
from OCP.IGESSelect import IGESSelect_WorkLibrary
from OCP.Interface import Interface_Static
from OCP.TCollection import TCollection_HAsciiString

from crispline.brep import occt
from crispline.brep.damage import iges_damage, step_damage
from crispline.brep.step import open_step, quieten, step_bytes
from crispline.brep.surfaces import face_shape, faces_from_occt, scaled
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path
from crispline.spline.tensor import TensorSpline

MILLIMETRES: Mapping[str, float] = {
    "mm": 1.0,
    "um": 1e-3,
    "cm": 10.0,
    "m": 1e3,
    "km": 1e6,
    "in": 25.4,
    "mil": 0.0254,
    "ft": 304.8,
}
"""Millimetres in every unit that a file may be written in."""

_OCCT_NAMES = {name: name.upper() for name in MILLIMETRES} | {"in": "INCH"}
_STEP_NAMES = {
    "millimetre": "mm",
    "micrometre": "um",
    "centimetre": "cm",
    "metre": "m",
    "kilometre": "km",
    "inch": "in",
    "mil": "mil",
    "foot": "ft",
}
_NAME = "crispline"
_TIME_STAMP = "19700101.000000"


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
    is_step = path.suffix.lower() in (".step", ".stp")
    kind, read = ("a STEP", _read_step) if is_step else ("an IGES", _read_iges)
    try:
        shape, unit = read(path)
    except _UnreadableError as error:
        raise InputError(
            f"'{path}': expected {kind} file with a shape, found content that cannot be read as "
            f"one ({error}); check that it is complete and its suffix right"
        ) from error
    faces = faces_from_occt(shape, f"'{path}'")
    if not faces.splines:
        kinds = ", ".join(f"{count} {name}" for name, count in sorted(faces.left_out.items()))
        raise InputError(
            f"'{path}': expected {kind} file with B-spline faces, found "
            f"{f'faces of other kinds ({kinds})' if kinds else 'no face'}; "
            "convert the faces to B-splines (NURBS) where the file was made"
        )
    splines = tuple(scaled(spline, 1.0 / MILLIMETRES[unit]) for spline in faces.splines)
    return FaceFile(splines, unit, faces.n_trimmed, faces.left_out)


class _UnreadableError(Exception):
    """The file holds no shape, for the reason given."""


def _read_step(path: Path) -> tuple[Any, str]:
    reader = open_step(path.read_bytes())
    if reader is None:
        raise _UnreadableError("its syntax is not that of STEP")
    damage = step_damage(reader)
    if damage is not None:
        raise _UnreadableError(damage)
    lengths, angles, solid_angles = (Sequence_TCollection_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    names = {name.ToCString().lower() for name in lengths}
    if not reader.TransferRoots():
        raise _UnreadableError("it holds no shape")
    unit = _STEP_NAMES.get(names.pop(), "mm") if len(names) == 1 else "mm"
    return reader.OneShape(), unit


def _read_iges(path: Path) -> tuple[Any, str]:
    content = path.read_bytes()
    damage = iges_damage(content)
    if damage is not None:
        raise _UnreadableError(damage)
    quieten()
    IGESControl_Controller.Init_s()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    Interface_Static.SetIVal_s("read.iges.bspline.continuity", 0)  # creases stay creases
    reader = IGESControl_Reader()
    # OCCT reads IGES by name only, and says nothing about letters outside ASCII.
    with tempfile.TemporaryDirectory(prefix="crispline-") as folder:
        copy = Path(folder) / "surface.igs"
        copy.write_bytes(content)
        status = reader.ReadFile(str(copy))
    if status != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.TransferRoots():
        raise _UnreadableError("it holds no shape")
    value = reader.IGESModel().GlobalSection().UnitValue()
    near = (name for name, factor in MILLIMETRES.items() if abs(value - factor) < 1e-6 * factor)
    return reader.OneShape(), next(near, "mm")


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
    if unit not in MILLIMETRES:
        raise InputError(
            f"expected a length unit out of {', '.join(MILLIMETRES)}, got '{unit}'; choose one"
        )
    shape = face_shape([scaled(spline, MILLIMETRES[unit]) for spline in splines])
    is_step = path.suffix.lower() in (".step", ".stp")
    read = _read_step if is_step else _read_iges
    content: Callable[[bool], bytes] = (
        (lambda has_pcurves: step_bytes(shape, has_pcurves, _OCCT_NAMES[unit]))
        if is_step
        else (lambda _: _iges_bytes(shape, _OCCT_NAMES[unit]))
    )
    with atomic_path(path) as draft:
        for has_pcurves in (False, True):
            draft.write_bytes(content(has_pcurves))
            if _is_sound(read, draft, len(splines)):
                return
        raise ReconstructionError(
            f"'{path}': the surfaces are valid in memory, but the file of them does not read "
            "back as the same faces; write NPZ or JSON instead"
        )


def _is_sound(read: Callable[[Path], tuple[Any, str]], path: Path, n_faces: int) -> bool:
    try:
        shape, _ = read(path)
    except _UnreadableError:
        return False
    n_read = len(occt.subshapes(shape, occt.FACE))
    return n_read == n_faces and bool(BRepCheck_Analyzer(shape).IsValid())


def _iges_bytes(shape: Any, unit: str) -> bytes:
    """The content of an IGES file, each surface trimmed by its natural border."""
    quieten()
    IGESControl_Controller.Init_s()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    writer = IGESControl_Writer(unit, 0)
    if not writer.AddShape(shape):
        raise ReconstructionError("the IGES writer cannot translate the surfaces")
    writer.ComputeModel()
    model = writer.Model()
    header = model.GlobalSection()
    for set_text, text in (
        (header.SetFileName, _NAME),
        (header.SetAuthorName, _NAME),  # else the name of the user
        (header.SetDate, _TIME_STAMP),
        (header.SetLastChangeDate, _TIME_STAMP),
    ):
        set_text(TCollection_HAsciiString(text))
    model.SetGlobalSection(header)
    # IGESControl_Writer.Write rounds to 10 digits.
    printer = IGESData_IGESWriter(model)
    printer.FloatWriter().SetFormat("%.16E", True)
    printer.FloatWriter().SetZeroSuppress(False)
    printer.SendModel(IGESSelect_WorkLibrary.DefineProtocol_s())
    stream = io.BytesIO()
    if not printer.Print(stream):
        raise ReconstructionError("the IGES writer cannot write the surfaces")
    return stream.getvalue()
