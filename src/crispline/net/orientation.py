"""Choose among orientations of the normals by how well an indicator explains the points."""

from __future__ import annotations

import itertools

import numpy as np

from crispline.cloud.normals import orient_by_spanning_tree, principal_normals
from crispline.cloud.working import WorkingCloud
from crispline.net.poisson import point_areas, poisson_indicator
from crispline.options import NetOptions
from crispline.surface.base import Array


def oriented_normals(
    cloud: WorkingCloud, options: NetOptions, threads: int = -1
) -> tuple[Array, float]:
    """Outward unit normals, shape ``(n, 3)``, and the spread of their indicator.

    No single spanning-tree setting is safe on every part, but a wrong
    orientation shows: the Poisson indicator then scatters at the points. So
    settings are tried in turn and the smallest *spread* (scatter at the points
    over the jump across the surface) wins. The search ends when two settings
    agree on the smallest spread and it is below ``options.good_spread``.
    """
    areas = point_areas(cloud.distances)
    best: tuple[float, Array] | None = None
    for k in options.normal_neighbours:
        normals = principal_normals(cloud.points, cloud.neighbours, k)
        for bending, offset_weight in itertools.product((2.0, 1.0, 0.0), (0.25, 1.0)):
            oriented = orient_by_spanning_tree(
                cloud.points, normals, cloud.neighbours, bending, offset_weight
            )
            spread = indicator_spread(cloud.points, oriented, areas, threads)
            confirmed = best is not None and abs(spread - best[0]) < 0.05 * best[0]
            if best is None or spread < best[0]:
                best = spread, oriented
            if confirmed and best[0] < options.good_spread:
                return best[1], best[0]
    if best is None:
        raise ValueError("options.normal_neighbours must not be empty")
    return best[1], best[0]


def indicator_spread(points: Array, normals: Array, areas: Array, threads: int = -1) -> float:
    """Scatter of the indicator at the points over its jump across the surface."""
    cell = 1.5
    indicator = poisson_indicator(points, normals, areas, cell, threads=threads)
    reach = 1.5 * indicator.cell
    jump = np.median(
        indicator.at(points - reach * normals) - indicator.at(points + reach * normals)
    )
    return float(np.std(indicator.at(points)) / max(abs(float(jump)), 1e-12))
