"""Models to files, for CAD and for display; the suffix tells the format."""

from __future__ import annotations

from os import PathLike
from pathlib import Path
from typing import Any

from crispline.cadfile.units import checked_unit
from crispline.errors import ReconstructionError
from crispline.exchange.palette import kind_colour
from crispline.files import check_output

SHAPE_SUFFIXES = (".brep", ".brp", ".iges", ".igs", ".step", ".stp")
TRIANGLE_SUFFIXES = (".glb", ".obj", ".ply", ".stl")
MODEL_SUFFIXES = (*SHAPE_SUFFIXES, ".3dm", *TRIANGLE_SUFFIXES)

_SHARE_OF_SPACING = 0.1
_SHARE_OF_SIZE = 1.0 / 2000.0


def write_model(
    model: Any, path: str | PathLike[str], unit: str = "mm", tolerance: float | None = None
) -> None:
    """Write a model whole or not at all; but for 3DM the same bytes for the same model.

    STEP (AP242; every face with a name such as ``cylinder 4`` and the colour of
    its kind), IGES and BREP hold the exact faces, 3DM (extra ``rhino``) NURBS faces,
    trimmed and joined; GLB, STL, OBJ and PLY triangles. STEP, IGES and 3DM files
    are read back and checked before they appear.

    Parameters
    ----------
    model : a `Reconstruction`, a ``TopoDS_Shape``, or an object of CadQuery or build123d.
        The numbers in the names are those of ``Reconstruction.faces``.
    unit : of the model's numbers ("mm", "um", "cm", "m", "km", "in", "mil", "ft"). STEP,
        IGES and 3DM name it: 5 in metres is read as 5000 in a program that works in millimetres.
        GLB is in metres by definition; the other formats have numbers only.
    tolerance : largest distance of triangles from the faces, in ``unit``; a tenth of the
        point spacing, or 1/2000 of the diagonal of a mere shape.

    Raises
    ------
    InputError
        Unknown suffix or unit, or the file cannot be written.
    ReconstructionError
        There is no valid model, or the file of it does not read back as the same.
    """
    path = Path(path)
    check_output(path, MODEL_SUFFIXES)
    checked_unit(unit)

    # OCCT takes half a second to load, and this module is imported where none is needed.
    from crispline.cadfile.shape_files import write_shape
    from crispline.cadfile.styled import FaceStyle
    from crispline.exchange.triangles import write_triangles
    from crispline.occt.measure import diagonal
    from crispline.occt.surfaces import face_kinds

    # Objects of CadQuery and build123d, which wrap a shape, have a method `solid` too.
    shape, order = getattr(model, "wrapped", model), None
    if shape is model and hasattr(model, "solid"):
        if not model.valid:
            raise ReconstructionError("there is no valid model to write", model)
        shape, order = model.solid.shape, model.solid.face_order
        tolerance = tolerance or _SHARE_OF_SPACING * model.spacing
    kinds = face_kinds(shape)
    order = range(len(kinds)) if order is None else order
    # Index -1 stands for a patch of the bicubic surface, which is no face of the model.
    kinds = tuple("patch" if k < 0 else kind for kind, k in zip(kinds, order, strict=True))
    if path.suffix.lower() in TRIANGLE_SUFFIXES:
        tolerance = tolerance or _SHARE_OF_SIZE * diagonal(shape)
        write_triangles(shape, path, unit, tolerance, kinds)
        return
    if path.suffix.lower() == ".3dm":
        from crispline.exchange.rhino import write_3dm

        write_3dm(shape, path, unit)
        return
    numbers = [place if k < 0 else k for place, k in enumerate(order)]
    styles = [
        FaceStyle(f"{kind} {number}", kind_colour(kind))
        for kind, number in zip(kinds, numbers, strict=True)
    ]
    write_shape(shape, path, unit, styles)


def convert_model(
    source: str | PathLike[str], path: str | PathLike[str], tolerance: float | None = None
) -> str:
    """Write the shape in a STEP, IGES or BREP file in another format, in its own unit.

    Returns
    -------
    The unit; "mm" for BREP, which names none.

    Raises
    ------
    InputError
        A file that cannot be read or written; see `write_model`.
    ReconstructionError
        The shape does not read back as the same.
    """
    check_output(Path(path), MODEL_SUFFIXES)
    from crispline.cadfile.shape_files import read_shape

    found = read_shape(Path(source))
    write_model(found.shape, path, found.unit, tolerance)
    return found.unit
