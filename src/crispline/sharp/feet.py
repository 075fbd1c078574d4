"""Nearest points on many surfaces: one call for each surface instead of one for each point."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array


def feet_on_each(
    points: Array, label: Labels, regions: Mapping[int, RegionFit]
) -> tuple[Array, Array]:
    """Nearest points on the surface that is named for each point, and outward normals there.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    label : the region of each point's surface, shape ``(n,)``.
    regions : the surface of every label.

    Returns
    -------
    feet, normals : shape ``(n, 3)`` each; the normals point out of the part.
    """
    feet, normals = np.empty_like(points), np.empty_like(points)
    order = np.argsort(label, kind="stable")
    for mine in np.split(order, np.flatnonzero(np.diff(label[order])) + 1):
        if not len(mine):  # of no points at all
            continue
        region = regions[int(label[mine[0]])]
        feet[mine], own = region.surface.project(points[mine])
        normals[mine] = region.orientation * own
    return feet, normals
