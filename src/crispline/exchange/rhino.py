"""Trimmed solids as 3DM, the files of Rhino."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from crispline.cadfile.opennurbs import encode
from crispline.cadfile.rhino import brep_tables
from crispline.errors import ReconstructionError
from crispline.extras import optional
from crispline.files import atomic_path

_UNITS: Mapping[str, str] = {
    "um": "Microns",
    "mm": "Millimeters",
    "cm": "Centimeters",
    "m": "Meters",
    "km": "Kilometers",
    "mil": "Mils",
    "in": "Inches",
    "ft": "Feet",
}
_VERSION = 7


def write_3dm(shape: Any, path: Path, unit: str = "mm") -> None:
    """Write a shape as one trimmed solid (or shell) of NURBS faces, whole or not at all.

    openNURBS decodes the solid and checks it; the file is read back. The bytes
    differ from file to file, as the library puts the time and a random identifier in.

    Parameters
    ----------
    shape : ``TopoDS_Shape``.
    unit : of its numbers, one of `crispline.cadfile.units.MILLIMETRES`.

    Raises
    ------
    InputError
        rhino3dm is not installed, or the file cannot be written.
    ReconstructionError
        openNURBS finds a fault in the solid.
    """
    rhino3dm = optional("rhino3dm", "rhino", "3DM files")
    tables = brep_tables(shape)
    # The envelope of the archive, with the version of the library, from a solid of its own.
    envelope = rhino3dm.Brep.CreateFromSphere(
        rhino3dm.Sphere(rhino3dm.Point3d(0.0, 0.0, 0.0), 1.0)
    ).Encode()
    envelope["data"] = base64.b64encode(encode(tables)).decode("ascii")
    solid = rhino3dm.CommonObject.Decode(envelope)
    if solid is None or not solid.IsValid or solid.IsSolid != tables.is_solid:
        raise _refused(path)
    model = rhino3dm.File3dm()
    model.Settings.ModelUnitSystem = getattr(rhino3dm.UnitSystem, _UNITS[unit])
    model.Objects.AddBrep(solid)
    with atomic_path(path) as draft:
        model.Write(str(draft), _VERSION)
        copy = rhino3dm.File3dm.Read(str(draft))
        if copy is None or len(copy.Objects) != 1 or not copy.Objects[0].Geometry.IsValid:
            raise _refused(path)


def _refused(path: Path) -> ReconstructionError:
    return ReconstructionError(
        f"cannot write '{path}': expected a solid that openNURBS finds valid, got one that it "
        "does not; write STEP, which Rhino reads as well"
    )
