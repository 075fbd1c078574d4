"""Curves in space as a STEP file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge
from OCP.TopoDS import TopoDS_Compound

from crispline import occt
from crispline.cadfile.shape_files import read_shape
from crispline.cadfile.step import step_bytes
from crispline.cadfile.units import OCCT_NAMES, checked_unit
from crispline.curve import Curve
from crispline.errors import InputError, ReconstructionError
from crispline.files import atomic_path


def write_curves(curves: Sequence[Curve], path: Path, unit: str = "mm") -> None:
    """Write curves as STEP, each an edge, whole or not at all.

    Lines, circles and B-splines stay what they are (``GEOMETRIC_CURVE_SET``).

    Parameters
    ----------
    unit : of the numbers, one of `MILLIMETRES`.

    Raises
    ------
    InputError
        No curve, unknown unit, or the file cannot be written.
    ReconstructionError
        OCCT makes no edge of a curve, or reads another number of them from the file.
    """
    name = OCCT_NAMES[checked_unit(unit)]
    if not curves:
        raise InputError(
            f"cannot write '{path}': expected at least one edge, found none, and a STEP file "
            "without a shape cannot be read; write JSON"
        )
    content = step_bytes(_compound(curves), False, name, name)
    with atomic_path(path) as draft:
        draft.write_bytes(content)
        if len(occt.subshapes(read_shape(draft).shape, occt.EDGE)) != len(curves):
            raise ReconstructionError(
                f"'{path}': the STEP file of the edges does not read back as the same edges; "
                "write DXF or JSON instead"
            )


def _compound(curves: Sequence[Curve]) -> Any:
    builder, compound = BRep_Builder(), TopoDS_Compound()
    builder.MakeCompound(compound)
    for curve in curves:
        edge = BRepBuilderAPI_MakeEdge(occt.curve_to_occt(curve), curve.start, curve.end)
        if not edge.IsDone():
            raise ReconstructionError("an edge of the model has no length")
        builder.Add(compound, edge.Edge())
    return compound
