"""Regions amended for what locating or building their faces has shown."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from crispline.net.graph import components
from crispline.net.halfedge import HalfEdges
from crispline.options import RegionOptions
from crispline.region.cleanup import tidy
from crispline.region.evidence import Evidence
from crispline.region.expand import expand_regions
from crispline.region.prune import prune_regions
from crispline.region.segment import Segmentation
from crispline.surface.base import Array

_NEAR_RINGS = 3  # of patches round a place, about spacings


def without_regions(
    regions: Segmentation,
    failing: Collection[int],
    evidence: Evidence,
    quads: HalfEdges,
    options: RegionOptions,
) -> Segmentation | None:
    """The regions without those of some that their neighbours explain as well.

    The others keep their surfaces and their numbers.

    Returns
    -------
    None if every one of them is needed.
    """
    label = prune_regions(regions.label, regions.fits, evidence, options, failing)
    if np.array_equal(label, regions.label):
        return None
    label = tidy(label, quads, options.min_patches)
    if label.max() > regions.label.max():
        return None  # another region would fall apart
    fits = {name: regions.fits[name] for name in np.unique(label).tolist()}
    return replace(regions, label=label, fits=fits)


def moved_near(
    regions: Segmentation,
    places: Array,
    evidence: Evidence,
    quads: HalfEdges,
    options: RegionOptions,
) -> Segmentation | None:
    """The regions with borders where the last surfaces put them, near some places.

    Borders settle on a part of the points, and before narrow faces are found. All surfaces stay.

    Parameters
    ----------
    places : shape ``(n, 3)``; what moves is connected to patches near one of these.

    Returns
    -------
    None if nothing moves, or a region would go or fall apart.
    """
    graph = evidence.graph
    moved = expand_regions(regions.label, regions.fits, evidence, options)
    piece = components(graph.adjacency, moved != regions.label)
    near = np.zeros(len(graph), dtype=bool)
    near[cKDTree(graph.points).query(places)[1]] = True
    near = graph.rings(near, _NEAR_RINGS)
    label = np.where(np.isin(piece, piece[near]), moved, regions.label)
    label = tidy(label, quads, options.min_patches)
    if np.array_equal(label, regions.label):
        return None
    has_all = np.array_equal(np.unique(label), np.unique(regions.label))
    return replace(regions, label=label) if has_all else None
