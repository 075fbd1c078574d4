"""IGES files (5.3): one shape, the same bytes for the same shape."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_ReturnStatus
from OCP.IGESControl import IGESControl_Controller, IGESControl_Reader, IGESControl_Writer
from OCP.IGESData import IGESData_IGESWriter
from OCP.IGESSelect import IGESSelect_WorkLibrary
from OCP.Interface import Interface_Static
from OCP.TCollection import TCollection_HAsciiString

from crispline.cadfile.damage import iges_damage
from crispline.cadfile.step import quieten
from crispline.cadfile.units import MILLIMETRES
from crispline.errors import ReconstructionError

_NAME = "crispline"
_TIME_STAMP = "19700101.000000"


class UnreadableError(Exception):
    """The file holds no shape, for the reason given."""


def read_iges(content: bytes) -> tuple[Any, str]:
    """The shape in an IGES file, in millimetres, and the unit of the file.

    The unit is "mm" if it is none of `MILLIMETRES`.

    Raises
    ------
    UnreadableError
        Not such a file, or one without a shape.
    """
    damage = iges_damage(content)
    if damage is not None:
        raise UnreadableError(damage)
    _initialise()
    Interface_Static.SetIVal_s("read.iges.bspline.continuity", 0)  # creases stay creases
    reader = IGESControl_Reader()
    # OCCT reads IGES by name only, and says nothing about letters outside ASCII.
    with tempfile.TemporaryDirectory(prefix="crispline-") as folder:
        copy = Path(folder) / "shape.igs"
        copy.write_bytes(content)
        status = reader.ReadFile(str(copy))
    if status != IFSelect_ReturnStatus.IFSelect_RetDone or not reader.TransferRoots():
        raise UnreadableError("it holds no shape")
    value = reader.IGESModel().GlobalSection().UnitValue()
    near = (name for name, factor in MILLIMETRES.items() if abs(value - factor) < 1e-6 * factor)
    return reader.OneShape(), next(near, "mm")


def iges_bytes(shape: Any, unit: str = "MM", is_solid: bool = False) -> bytes:
    """The content of an IGES file of a shape in millimetres.

    Parameters
    ----------
    unit : OCCT's name of the file's length unit.
    is_solid : whether faces share their edges (entities 186 and 514), as the faces of
        a solid do; else each is a surface of its own, trimmed by its border (144).

    Raises
    ------
    ReconstructionError
        OCCT cannot translate the shape.
    """
    _initialise()
    writer = IGESControl_Writer(unit, int(is_solid))
    if not writer.AddShape(shape):
        raise ReconstructionError("the IGES writer cannot translate the shape")
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
        raise ReconstructionError("the IGES writer cannot write the shape")
    return stream.getvalue()


def _initialise() -> None:
    quieten()
    IGESControl_Controller.Init_s()
    Interface_Static.SetCVal_s("xstep.cascade.unit", "MM")
