"""LAS and LAZ, the files of airborne and mobile scanners."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from crispline.cloud.raw import RawCloud
from crispline.extras import optional

_NORMALS = ("NormalX", "NormalY", "NormalZ")


def read_las(path: Path) -> RawCloud:
    """Points of a LAS or LAZ file in its own coordinates, in double precision.

    Normals are taken from the extra dimensions ``NormalX``, ``NormalY`` and
    ``NormalZ``, which CloudCompare and PDAL write.

    Raises
    ------
    InputError
        laspy, or lazrs for LAZ, is not installed.
    """
    laspy = optional("laspy", "las", "LAS files")
    if path.suffix.lower() == ".laz":
        optional("lazrs", "las", "LAZ files")
    content = laspy.read(path)
    names = set(content.point_format.dimension_names)
    normals = None
    if set(_NORMALS) <= names:
        normals = np.column_stack([np.asarray(content[name]) for name in _NORMALS])
    return RawCloud(np.asarray(content.xyz, dtype=np.float64), normals)
