"""Any shape from and to STEP, IGES and OCCT's own BREP; the suffix tells which.

The numbers of a shape are those of its file, and the unit goes along as a name.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from OCP.BRepTools import BRepTools
from OCP.collections import Sequence_TCollection_AsciiString

from crispline import occt
from crispline.cadfile.damage import step_damage
from crispline.cadfile.iges import UnreadableError, iges_bytes, read_iges
from crispline.cadfile.readback import is_same_solid
from crispline.cadfile.step import open_step, write_step
from crispline.cadfile.styled import FaceStyle
from crispline.cadfile.units import MILLIMETRES, OCCT_NAMES, STEP_NAMES, checked_unit
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path, readable
from crispline.surface import Similarity

STEP_SUFFIXES = (".step", ".stp")
IGES_SUFFIXES = (".iges", ".igs")
BREP_SUFFIXES = (".brep", ".brp")
SHAPE_SUFFIXES = BREP_SUFFIXES + IGES_SUFFIXES + STEP_SUFFIXES


@dataclass(frozen=True)
class ShapeFile:
    """What a file held.

    Attributes
    ----------
    shape : ``TopoDS_Shape``, lengths in ``unit``.
    unit : one of `MILLIMETRES`; the file's own, or "mm" if that is a rarer one (lengths
        are then converted) or, in a BREP file, is not told.
    """

    shape: Any
    unit: str


def read_shape(path: Path) -> ShapeFile:
    """The shape in a STEP, IGES or BREP file, with the file's numbers and its unit.

    Raises
    ------
    InputError
        Missing file, unknown suffix, or content that cannot be read as such a file.
    """
    with readable(path, SHAPE_SUFFIXES, "a shape"):
        shape, unit = read_millimetres(path)
    return ShapeFile(_scaled(shape, 1.0 / MILLIMETRES[unit]), unit)


def read_millimetres(path: Path) -> tuple[Any, str]:
    """The shape in a file, in millimetres, and the unit that the file is in."""
    suffix = path.suffix.lower()
    kind, read = (
        ("a STEP", _read_step)
        if suffix in STEP_SUFFIXES
        else ("an IGES", read_iges)
        if suffix in IGES_SUFFIXES
        else ("a BREP", _read_brep)
    )
    try:
        return read(path.read_bytes())
    except UnreadableError as error:
        raise InputError(
            f"'{path}': expected {kind} file with a shape, found content that cannot be read as "
            f"one ({error}); check that it is complete and its suffix right"
        ) from error


def write_shape(shape: Any, path: Path, unit: str = "mm", styles: Sequence[FaceStyle] = ()) -> None:
    """Write a shape whole or not at all, and only if it reads back the same.

    Parameters
    ----------
    unit : of the shape's numbers. STEP and IGES name it; BREP files have none.
    styles : name and colour of every face for STEP, in exploration order, or none at all.

    Raises
    ------
    ReconstructionError
        OCCT cannot write the shape, or reads another one from the file.
    InputError
        Unknown unit, or the file cannot be written.
    """
    suffix = path.suffix.lower()
    if suffix in STEP_SUFFIXES:
        write_step(shape, path, unit, styles)
        return
    factor = MILLIMETRES[checked_unit(unit)]
    if suffix in IGES_SUFFIXES:
        content = iges_bytes(_scaled(shape, factor), OCCT_NAMES[unit], is_solid=True)
        if not is_same_solid(_iges_or_none(content), shape, factor):
            raise ReconstructionError(
                "the model is valid in memory, but the IGES file of it does not read back as "
                "the same solid; write STEP instead"
            )
    else:
        BRepTools.Clean_s(shape)  # triangles left by a measurement are no part of it
        content = occt.to_text(shape)
    with atomic_path(path) as draft:
        draft.write_bytes(content)


def _scaled(shape: Any, factor: float) -> Any:
    if factor == 1.0:
        return shape
    return occt.transform(shape, Similarity(factor, np.eye(3), np.zeros(3)))


def _iges_or_none(content: bytes) -> Any:
    try:
        return read_iges(content)[0]
    except UnreadableError:
        return None


def _read_step(content: bytes) -> tuple[Any, str]:
    reader = open_step(content)
    if reader is None:
        raise UnreadableError("its syntax is not that of STEP")
    damage = step_damage(reader)
    if damage is not None:
        raise UnreadableError(damage)
    lengths, angles, solid_angles = (Sequence_TCollection_AsciiString() for _ in range(3))
    reader.FileUnits(lengths, angles, solid_angles)
    names = {name.ToCString().lower() for name in lengths}
    if not reader.TransferRoots():
        raise UnreadableError("it holds no shape")
    unit = STEP_NAMES.get(names.pop(), "mm") if len(names) == 1 else "mm"
    return reader.OneShape(), unit


def _read_brep(content: bytes) -> tuple[Any, str]:
    shape = occt.from_text(content)
    if shape.IsNull():
        raise UnreadableError("it holds no shape")
    return shape, "mm"
