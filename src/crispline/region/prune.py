"""Give up regions that explain too little to be worth a face."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from crispline.options import RegionOptions
from crispline.region.claim import MISFIT_CAP, OUT_OF_REACH, Claim
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

_OFF = 0.5  # share of the most that a misfit costs beyond which a surface explains nothing


def prune_regions(
    label: Labels,
    fits: Mapping[int, RegionFit],
    evidence: Evidence,
    options: RegionOptions,
    candidates: Collection[int] | None = None,
) -> Labels:
    """Hand the patches of superfluous regions to the neighbours that explain them best.

    A region is superfluous if its neighbours' surfaces explain its points
    nearly as well: the misfit rises by less than ``options.face_cost`` more than
    the borders that go (a label cost, Delong et al. 2012). Smallest first; the
    neighbours of a region that went stay this time. More than a crumb that no surface explains,
    its own or another, stays too: it would only spoil its neighbours.

    Parameters
    ----------
    label, fits : regions and the surface of each.
    candidates : regions that may go; None for all.
    """
    label = label.copy()
    graph = evidence.graph
    claims = {region: Claim(fit, evidence, options) for region, fit in fits.items()}
    names, sizes = np.unique(label, return_counts=True)
    kept: set[int] = set()
    for region in names[np.argsort(sizes, kind="stable")].tolist():
        members = np.flatnonzero(label == region)
        # Larger regions differ from their neighbours by far more than one face costs.
        if region in kept or len(members) > options.max_pruned_patches:
            continue
        if candidates is not None and region not in candidates:
            continue
        beside = label[graph.pairs[graph.sides_of(members)].ravel()]
        neighbours = np.setdiff1d(beside, [region])
        if len(neighbours) == 0:
            continue
        n_border = int((beside.reshape(-1, 2)[:, 0] != beside.reshape(-1, 2)[:, 1]).sum())
        inside = label == region
        own = claims[region].patch_costs(inside)
        near = graph.rings(inside, options.expansion_rings)
        others = np.stack(
            [
                claims[other].patch_costs(inside & claims[other].reach(near & (label == other)))
                for other in neighbours.tolist()
            ]
        )[:, members]
        cheapest = others.min(axis=0)
        if (cheapest >= OUT_OF_REACH).any() or _is_unknown(cheapest, options):
            continue
        rise = float((cheapest - own[members]).sum())
        if rise < options.face_cost + 0.5 * options.border_cost * n_border:
            label[members] = neighbours[np.argmin(others, axis=0)]
            kept |= set(neighbours.tolist())
    return label


def _is_unknown(cost: Array, options: RegionOptions) -> bool:
    """Whether patches of some cost on the best of the neighbours are faces not found yet."""
    is_off = cost > _OFF * MISFIT_CAP
    return int(is_off.sum()) >= options.crumb_patches and bool(is_off.mean() > 0.5)
