"""The closed surface of a solid: the level set of its indicator."""

from __future__ import annotations

import numpy as np
from skimage.measure import marching_cubes

from crispline.errors import ReconstructionError
from crispline.net.mesh import TriangleMesh, compact
from crispline.net.poisson import Indicator
from crispline.surface.base import Array


def solid_mesh(indicator: Indicator, points: Array, areas: Array) -> TriangleMesh:
    """Triangles of the indicator's level at the points.

    Closed: over whatever the points leave open the level set forms a lid.

    Raises
    ------
    ReconstructionError
        If the indicator has no such level set.
    """
    level = float(np.average(indicator.at(points), weights=areas))
    try:
        vertices, triangles, _, _ = marching_cubes(indicator.values, level, allow_degenerate=False)
    except (ValueError, RuntimeError) as error:
        raise ReconstructionError(
            "no surface could be found through the cloud: the points do not enclose a part; "
            "check the columns of the file and that the scan covers the part"
        ) from error
    return compact(indicator.origin + indicator.cell * vertices, triangles.astype(np.int64))
