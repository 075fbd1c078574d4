"""Find faces that other regions have swallowed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.evidence import N_WITNESSES, Evidence
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit

_RINGS = 2  # surfaces of labels this near may explain a patch


def release_swallowed(
    label: Labels,
    fits: Mapping[int, RegionFit],
    evidence: Evidence,
    options: RegionOptions,
) -> Labels:
    """Give patches that no surface near them explains labels of their own, shape ``(m,)``.

    A patch is unexplained if half of its points lie more than
    ``options.swallowed_sigmas`` sigma off every surface within two rings;
    connected groups of ``options.min_patches`` or more become regions.
    """
    graph = evidence.graph
    distance = np.full((len(label), N_WITNESSES), np.inf)
    for region, fit in fits.items():
        near = np.flatnonzero(graph.rings(label == region, _RINGS))
        # Point by point: on a crease each point has a surface, but no surface has them all.
        distance[near] = np.minimum(distance[near], evidence.misfit(fit, near))
    limit = options.swallowed_sigmas * np.maximum(evidence.patch_noise, options.swallowed_floor)
    lost = np.median(distance, axis=1) > limit
    beside = graph.adjacency @ lost.astype(np.float64)
    lost |= beside >= 3.0
    piece = components(graph.adjacency, lost)
    names, sizes = np.unique(piece[lost], return_counts=True)
    label = label.copy()
    for name in names[sizes >= options.min_patches]:
        label[lost & (piece == name)] = label.max() + 1
    return label
