"""One corner: the common point of the three or more surfaces round it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from crispline.options import LocateOptions
from crispline.surface import Surface
from crispline.surface.base import Array
from crispline.surface.intersect import (
    Constraint,
    damped_intersect,
    distance,
    equations,
    intersect,
)

_DAMPING = 0.1
_EXACT = 1e-6
_MIN_CONDITION = 0.15


@dataclass(frozen=True)
class Corner:
    """A located corner.

    Attributes
    ----------
    position : shape ``(3,)``.
    gap : largest distance to the surfaces round it, spacings.
    is_fallback : whether the surfaces have no acceptable common point.
    """

    position: Array
    gap: float
    is_fallback: bool


def locate_corner(
    net_vertex: Array,
    surfaces: Sequence[Surface],
    contacts: Sequence[Constraint],
    cloud: cKDTree,
    max_cloud_distance: float,
    options: LocateOptions,
) -> Corner:
    """Locate a corner.

    Parameters
    ----------
    net_vertex : where the net has it, shape ``(3,)``.
    surfaces : of the regions round it.
    contacts : where the smooth borders that end here run; without them nothing
        tells the position across a smooth border.
    cloud : the raw points.
    max_cloud_distance : largest distance of the corner to the cloud, spacings.
    options : what is accepted.

    Returns
    -------
    Corner
        The common point; else the compromise between the surfaces and the net;
        else the net's vertex.
    """
    constraints = [*surfaces, *contacts]
    position = intersect(net_vertex[None], constraints)[0][0]
    gap = float(distance(position[None], surfaces)[0])
    # Labels hardly tell where a smooth border runs: the net is far off across it.
    move = options.corner_move_smooth if contacts else options.corner_move
    if gap < _EXACT and _condition(position, constraints) > _MIN_CONDITION:
        move = options.corner_move_exact
    if (
        gap < options.corner_gap
        and np.linalg.norm(position - net_vertex) <= move
        and cloud.query(position)[0] <= max_cloud_distance
    ):
        return Corner(position, gap, is_fallback=False)
    position, gap = damped_intersect(net_vertex, surfaces, _DAMPING)
    if np.linalg.norm(position - net_vertex) <= options.corner_move:
        return Corner(position, gap, is_fallback=True)
    gap = float(distance(net_vertex[None], surfaces)[0])
    return Corner(net_vertex.copy(), gap, is_fallback=True)


def _condition(position: Array, constraints: Sequence[Constraint]) -> float:
    """Third singular value of the normals: how firmly they hold the point, at most about 1."""
    normals, _ = equations(position[None], constraints)
    values = np.linalg.svd(normals[0], compute_uv=False)
    return float(values[2]) if len(values) > 2 else 0.0
