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
from crispline.region.patches import Labels, PatchGraph
from crispline.region.prune import prune_regions
from crispline.region.segment import Segmentation
from crispline.surface.base import Array

_NEAR_RINGS = 3  # of patches round a place, about spacings
_NARROW_RINGS = 3  # of patches from its border that cover a narrow region, about spacings


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
    return _fewer(regions, label, quads, options)


def without_narrow(
    regions: Segmentation,
    failing: Collection[int],
    graph: PatchGraph,
    quads: HalfEdges,
    options: RegionOptions,
) -> Segmentation | None:
    """The regions without those of some that are as narrow as they are small.

    A few rows of points say that something is there, but not what it is. Each patch
    goes to the region of the nearest patch that stays; all surfaces stay.

    Returns
    -------
    None if none of them is narrow.
    """
    label = regions.label.copy()
    for region in sorted(failing):
        inside = regions.label == region
        is_narrow = graph.rings(~inside, _NARROW_RINGS).all()
        if is_narrow and inside.sum() <= options.max_pruned_patches:
            label[inside] = -1
    gone = label < 0
    if not gone.any() or gone.all():
        return None
    nearest = cKDTree(graph.points[~gone]).query(graph.points[gone])[1]
    label[gone] = label[~gone][nearest]
    return _fewer(regions, label, quads, options)


def _fewer(
    regions: Segmentation, label: Labels, quads: HalfEdges, options: RegionOptions
) -> Segmentation | None:
    """The regions with labels of which some are gone; None if none is, or another falls apart."""
    if np.array_equal(label, regions.label):
        return None
    label = _tidied(label, regions, quads, options)
    if label.max() > regions.label.max():
        return None
    fits = {name: regions.fits[name] for name in np.unique(label).tolist()}
    return replace(regions, label=label, fits=fits)


def _tidied(
    label: Labels, regions: Segmentation, quads: HalfEdges, options: RegionOptions
) -> Labels:
    """New labels made tidy; walls of a few patches stay, where nothing has changed."""
    changed = label != regions.label
    touched = np.union1d(label[changed], regions.label[changed])
    held = np.setdiff1d(label, touched).tolist()
    return tidy(label, quads, options.min_patches, held)


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
    label = _tidied(label, regions, quads, options)
    if np.array_equal(label, regions.label):
        return None
    has_all = np.array_equal(np.unique(label), np.unique(regions.label))
    return replace(regions, label=label) if has_all else None
