"""Names and colours of faces in STEP files, through OCCT's document of shapes (XCAF)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from OCP.Interface import Interface_Static
from OCP.Quantity import Quantity_Color, Quantity_TypeOfColor
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_StepModelType
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_ColorType, XCAFDoc_DocumentTool

from crispline import occt


@dataclass(frozen=True)
class FaceStyle:
    """How other programs show a face.

    Attributes
    ----------
    name : in the tree of the part.
    colour : red, green and blue from 0 to 1 (sRGB).
    """

    name: str
    colour: tuple[float, float, float]


def styled_writer(shape: Any, styles: Sequence[FaceStyle]) -> Any:
    """A ``STEPControl_Writer`` that has translated a shape, with a style for each of its faces.

    Parameters
    ----------
    shape : any ``TopoDS_Shape``.
    styles : one for every face, in exploration order.

    Returns
    -------
    None if OCCT cannot translate the shape.
    """
    STEPCAFControl_Controller.Init_s()
    Interface_Static.SetIVal_s("write.stepcaf.subshapes.name", 1)
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    colours = XCAFDoc_DocumentTool.ColorTool_s(document.Main())
    root = shapes.AddShape(shape, False)
    for face, style in zip(occt.subshapes(shape, occt.FACE), styles, strict=True):
        label = shapes.AddSubShape(root, face)
        TDataStd_Name.Set_s(label, TCollection_ExtendedString(style.name))
        colour = Quantity_Color(*style.colour, Quantity_TypeOfColor.Quantity_TOC_sRGB)
        colours.SetColor(label, colour, XCAFDoc_ColorType.XCAFDoc_ColorSurf)
    writer = STEPCAFControl_Writer()
    is_done = writer.Transfer(document, STEPControl_StepModelType.STEPControl_AsIs)
    return writer.Writer() if is_done else None
