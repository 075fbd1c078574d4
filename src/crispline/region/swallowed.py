"""Find faces that other regions have swallowed, and what spoils those that swallow it."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.evidence import N_WITNESSES, Evidence
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

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
    lost = _is_off(distance, np.arange(len(label)), evidence, options)
    beside = graph.adjacency @ lost.astype(np.float64)
    lost |= beside >= 3.0
    piece = components(graph.adjacency, lost)
    names, sizes = np.unique(piece[lost], return_counts=True)
    label = label.copy()
    for name in names[sizes >= options.min_patches]:
        label[lost & (piece == name)] = label.max() + 1
    return label


def without_spoils(
    label: Labels,
    before: Labels,
    fits: Mapping[int, RegionFit],
    fits_before: Mapping[int, RegionFit],
    evidence: Evidence,
    options: RegionOptions,
) -> Labels:
    """Labels in which regions that lost their surface to an expansion give back what spoilt it.

    Patches that no surface explains go to whichever is least wrong. If they are many, that one
    fails too.

    Parameters
    ----------
    label, before : after and before the expansion, shape ``(m,)``.
    fits, fits_before : surfaces fitted to each.
    """
    label = label.copy()
    for region, fit in fits_before.items():
        if region not in fits or fits[region].is_accepted or not fit.is_accepted:
            continue
        taken = np.flatnonzero((label == region) & (before != region))
        spoils = taken[_is_off(evidence.misfit(fit, taken), taken, evidence, options)]
        label[spoils] = before[spoils]
    return label


def _is_off(
    distance: Array, patches: Labels, evidence: Evidence, options: RegionOptions
) -> NDArray[np.bool_]:
    """Whether half of the points of some patches lie off a surface for more than noise.

    Parameters
    ----------
    distance : of ``k`` points of each of the ``patches``, shape ``(n, k)``.
    """
    noise = np.maximum(evidence.patch_noise[patches], options.swallowed_floor)
    return np.asarray(np.median(distance, axis=1) > options.swallowed_sigmas * noise)
