"""The two sides of thin walls, told apart by the indicator of the whole cloud.

A spanning tree hops from one side of a thin wall to the other here and there, and principal
components mix them, but the indicator averages over many normals: its gradient looks outward
where single normals do not (after Hou et al. 2022, Iterative Poisson surface reconstruction).
"""

from __future__ import annotations

import numpy as np

from crispline.cloud.facing import OPPOSITE, separated
from crispline.cloud.nearest import nearest
from crispline.cloud.normals import principal_normals
from crispline.cloud.scale import N_NEIGHBOURS
from crispline.cloud.working import WorkingCloud
from crispline.net.poisson import point_areas, poisson_indicator
from crispline.surface.base import Array

FINE_CELL = 0.7
"""Cell of the grid, in spacings, on which the two sides of a thin wall stay apart."""

_MIN_OPPOSITE = 3
"""So many of the nearest points must face the other way: fewer are stray normals ..."""
_MIN_SHARE = 5e-4
"""... round this share of the points; parts without thin walls have at most a tenth of it."""
_ROUNDS = 2
_K = 14
"""Points of a normal: fewer than elsewhere, as walls are seldom wide."""
_CLEAR = 0.5
"""Normals that make a smaller cosine with the gradient mix two faces: the gradient is better."""
_CLEARLY = 1.0 + 1e-6
_CHUNK = 50_000


def has_near_sheets(cloud: WorkingCloud, normals: Array, threads: int = -1) -> bool:
    """Whether sheets that face opposite ways lie within reach of each other's points.

    Parameters
    ----------
    cloud : ``n`` points.
    normals : outward unit normals, shape ``(n, 3)``.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    k = min(N_NEIGHBOURS, len(normals))
    n_near = 0
    for begin in range(0, len(normals), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        _, around = nearest(cloud.tree, cloud.points[rows], k, threads)
        is_opposite = np.einsum("nki,ni->nk", normals[around], normals[rows]) < OPPOSITE
        n_near += int(np.sum(is_opposite.sum(axis=1) >= _MIN_OPPOSITE))
    return bool(n_near > _MIN_SHARE * len(normals))


def are_apart(cloud: WorkingCloud, threads: int = -1) -> bool:
    """Whether the neighbours of a cloud leave out those on other sheets."""
    reach, _ = nearest(cloud.tree, cloud.points, cloud.neighbours.shape[1], threads)
    return bool(np.mean(cloud.distances[:, -1] > _CLEARLY * reach[:, -1]) > _MIN_SHARE)


def told_apart(
    cloud: WorkingCloud, normals: Array, threads: int = -1
) -> tuple[WorkingCloud, Array]:
    """The cloud with neighbours on the own sheet only, and normals made from these.

    Parameters
    ----------
    cloud : ``n`` points.
    normals : outward unit normals, shape ``(n, 3)``; most of them are right. Those of points
        without another sheet near them stay.
    threads : threads for queries and transforms; the result does not depend on it.
    """
    own, found = cloud, normals
    for _ in range(_ROUNDS):
        areas = point_areas(own.distances)
        indicator = poisson_indicator(cloud.points, found, areas, FINE_CELL, threads=threads)
        outward = -indicator.gradient(cloud.points)
        own = separated(cloud, outward, threads=threads)
        is_near = (own.neighbours != cloud.neighbours).any(axis=1)
        anew = principal_normals(own.points, own.neighbours[is_near], _K)
        cosine = np.einsum("ni,ni->n", anew, outward[is_near])
        anew = np.where(cosine < 0.0, -1.0, 1.0)[:, None] * anew
        anew = np.where((np.abs(cosine) < _CLEAR)[:, None], outward[is_near], anew)
        found = normals.copy()
        found[is_near] = anew
    return own, found
