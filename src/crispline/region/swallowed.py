"""Find faces that other regions have swallowed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.cloud.working import WorkingCloud
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.expand import N_POINTS, misfit
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit

_RINGS = 2  # surfaces of labels this near may explain a patch


def release_swallowed(
    label: Labels,
    fits: Mapping[int, RegionFit],
    cloud: WorkingCloud,
    graph: PatchGraph,
    sigma: float,
    min_patches: int,
    options: RegionOptions,
) -> Labels:
    """Give patches that no surface near them explains labels of their own, shape ``(m,)``.

    A patch is unexplained if half of its points lie more than
    ``options.swallowed_sigmas`` sigma off every surface within two rings;
    connected groups of ``min_patches`` or more become regions.
    """
    distance = np.full((len(label), N_POINTS), np.inf)
    for region, fit in fits.items():
        near = np.flatnonzero(graph.rings(label == region, _RINGS))
        # Point by point: on a crease each point has a surface, but no surface has them all.
        distance[near] = np.minimum(distance[near], misfit(fit, near, cloud, graph))
    limit = options.swallowed_sigmas * max(sigma, 0.08)
    lost = np.median(distance, axis=1) > limit
    beside = graph.adjacency @ lost.astype(np.float64)
    lost |= beside >= 3.0
    piece = components(graph.adjacency, lost)
    names, sizes = np.unique(piece[lost], return_counts=True)
    label = label.copy()
    for name in names[sizes >= min_patches]:
        label[lost & (piece == name)] = label.max() + 1
    return label
