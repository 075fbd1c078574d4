"""STEP files (AP242): one shape, the same bytes for the same shape."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.StepBasic import StepBasic_Product
from OCP.STEPControl import (
    STEPControl_Controller,
    STEPControl_Reader,
    STEPControl_StepModelType,
    STEPControl_Writer,
)
from OCP.StepData import StepData_StepWriter
from OCP.StepRepr import StepRepr_NextAssemblyUsageOccurrence
from OCP.TCollection import TCollection_HAsciiString

from crispline import occt
from crispline.cadfile.readback import is_same_solid
from crispline.cadfile.styled import FaceStyle, styled_writer
from crispline.cadfile.units import MILLIMETRES, OCCT_NAMES, checked_unit
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path

_NAME = "crispline"
_LONG_NUMBER = re.compile(rb"(\d\.\d{15})E([+-]\d{2,3})")
_TIME_STAMP = "1970-01-01T00:00:00"


def write_step(
    shape: Any, path: str | PathLike[str], unit: str = "mm", styles: Sequence[FaceStyle] = ()
) -> None:
    """Write a shape as a STEP file (AP242).

    The file appears whole or not at all. Curves in the parameter planes are left
    out, as readers make better ones themselves; if OCCT then reads an invalid
    shape back, they are written.

    Parameters
    ----------
    unit : of the shape's numbers, one of `MILLIMETRES`; they stand in the file as they are.
    styles : name and colour of every face in exploration order, or none at all.

    Raises
    ------
    ReconstructionError
        If OCCT cannot write the shape, or reads another shape from the file.
    InputError
        Unknown unit, or the file cannot be written.
    """
    name = OCCT_NAMES[checked_unit(unit)]
    for has_pcurves in (False, True):
        content = step_bytes(shape, has_pcurves, name, name, styles)
        if is_same_solid(_read(content), shape, MILLIMETRES[unit]):
            break
    else:
        raise ReconstructionError(
            "the model is valid in memory, but the STEP file of it does not read back as the "
            "same solid; borders with large gaps are the usual cause: scan them more densely"
        )
    with atomic_path(Path(path)) as draft:
        draft.write_bytes(content)


def faces_lost_in_step(shape: Any) -> tuple[int, ...]:
    """Faces that a STEP file of a shape spoils, in exploration order.

    Readers make new curves on the faces, and where borders have large gaps these may cross.

    Returns
    -------
    Empty if the file reads back as the same shape. Else the faces that are faulty in it, or
    those of the largest tolerance if none is by itself.
    """
    for has_pcurves in (True, False):
        copy = _read(step_bytes(shape, has_pcurves))
        if is_same_solid(copy, shape):
            return ()
    faces = occt.subshapes(shape, occt.FACE)
    if copy is not None and len(occt.subshapes(copy, occt.FACE)) == len(faces):
        analyser = BRepCheck_Analyzer(copy)
        copies = enumerate(occt.subshapes(copy, occt.FACE))
        faulty = tuple(index for index, face in copies if not analyser.IsValid(face))
        if faulty:
            return faulty
    tolerances = [occt.largest_tolerance(face, occt.VERTEX) for face in faces]
    return tuple(i for i, value in enumerate(tolerances) if value == max(tolerances))


def step_bytes(
    shape: Any,
    has_pcurves: bool,
    unit: str = "MM",
    shape_unit: str = "MM",
    styles: Sequence[FaceStyle] = (),
) -> bytes:
    """The content of a STEP file; equal for equal shapes, whenever it is made.

    ``unit`` and ``shape_unit`` are OCCT's names of the file's and the shape's length unit.
    """
    quieten()
    Interface_Static.SetIVal_s("write.surfacecurve.mode", int(has_pcurves))
    Interface_Static.SetCVal_s("write.step.schema", "AP242DIS")
    Interface_Static.SetCVal_s("write.step.unit", unit)
    Interface_Static.SetCVal_s("xstep.cascade.unit", shape_unit)
    writer = styled_writer(shape, styles) if styles else _plain_writer(shape)
    if writer is None:
        raise ReconstructionError("the STEP writer cannot translate the model")
    model = writer.Model()  # which lives no longer than its writer
    header = APIHeaderSection_MakeHeader(model)
    header.SetName(_text(_NAME))
    header.SetOriginatingSystem(_text(_NAME))
    header.SetTimeStamp(_text(_TIME_STAMP))
    # OCCT numbers parts, and their uses in an assembly, on from file to file.
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepBasic_Product):
            entity.SetName(_text(f"{_NAME} {number}"))
            entity.SetId(_text(f"{_NAME} {number}"))
        elif isinstance(entity, StepRepr_NextAssemblyUsageOccurrence):
            entity.SetId(_text(str(number)))
    # STEPControl_Writer.WriteStream rounds to 13 digits: too few for a part far from the
    # origin. OCCT's own suppression of zeros spoils longer numbers, so it is done here.
    printer = StepData_StepWriter(model)
    printer.FloatWriter().SetFormat("%.15E", True)
    printer.FloatWriter().SetZeroSuppress(False)
    printer.SendModel(model.Protocol())
    stream = io.BytesIO()
    if not printer.Print(stream):
        raise ReconstructionError("the STEP writer cannot write the model")
    return _LONG_NUMBER.sub(_shortened, stream.getvalue())


def _plain_writer(shape: Any) -> Any:
    writer = STEPControl_Writer()
    status = writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    return writer if status == IFSelect_ReturnStatus.IFSelect_RetDone else None


def _shortened(number: re.Match[bytes]) -> bytes:
    mantissa, exponent = number.groups()
    return mantissa.rstrip(b"0") + (b"" if exponent == b"+00" else b"E" + exponent)


def _text(text: str) -> Any:
    return TCollection_HAsciiString(text)


def read_step(path: str | PathLike[str]) -> Any:
    """The shape in a STEP file, lengths in millimetres.

    Raises
    ------
    InputError
        If the file is not a STEP file with a shape in it.
    """
    shape = _read(Path(path).read_bytes())
    if shape is None:
        raise InputError(f"{path}: expected a STEP file with a shape, found none that can be read")
    return shape


def _read(content: bytes) -> Any:
    reader = open_step(content)
    return reader.OneShape() if reader is not None and reader.TransferRoots() else None


def open_step(content: bytes) -> Any:
    """A ``STEPControl_Reader`` that has loaded a file, or None if it is no STEP file.

    Its shapes, once transferred, are in millimetres whatever the file's unit.
    """
    quieten()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
    reader = STEPControl_Reader()
    status = reader.ReadStream(_NAME, io.BytesIO(content))
    return reader if status == IFSelect_ReturnStatus.IFSelect_RetDone else None


def quieten() -> None:
    """Load the STEP module, and keep OCCT from printing its progress and its complaints."""
    STEPControl_Controller.Init_s()
    messenger = Message.DefaultMessenger_s()
    for printer in list(messenger.Printers()):
        messenger.RemovePrinter(printer)
