"""Join neighbouring regions that one surface explains."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.fit.bspline import fit_bspline_surface
from crispline.fit.choose import fit_jointly, tested
from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import LabelledCloud
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit

Pair = tuple[int, int]

_MIN_BORDER = 3  # sides; regions that touch less are not neighbours
_JOINT_KINDS = ("plane", "cylinder", "cone", "sphere")


def merge_regions(
    label: Labels,
    fits: Mapping[int, RegionFit],
    labelled: LabelledCloud,
    graph: PatchGraph,
    sigma: float,
    options: RegionOptions,
    fit_options: FitOptions,
    refused: set[tuple[int, int, int, int]],
) -> Labels:
    """One round of merges over the longest smooth borders; each region joins at most once.

    Parameters
    ----------
    fits : surface of every label.
    refused : pairs (with their sizes) already found not to be one surface;
        updated, so that later rounds do not try them again.
    """
    label = label.copy()
    size = np.bincount(label)
    joined: set[int] = set()
    for (a, b), sides in smooth_borders(label, fits, graph, options.merge_deg):
        key = (a, b, int(size[a]), int(size[b]))
        if sides < _MIN_BORDER or a in joined or b in joined or key in refused:
            continue
        parts = [labelled.samples(region, fit_options) for region in (a, b)]
        if _is_one_surface(parts, [fits[a], fits[b]], sigma, fit_options):
            label[label == b] = a
            joined |= {a, b}
        else:
            refused.add(key)
    return label


def smooth_borders(
    label: Labels, fits: Mapping[int, RegionFit], graph: PatchGraph, max_deg: float
) -> list[tuple[Pair, int]]:
    """Neighbouring regions whose surfaces meet at less than ``max_deg``, longest border first."""
    a, b = label[graph.pairs[:, 0]], label[graph.pairs[:, 1]]
    between = np.flatnonzero(a != b)
    middle = graph.points[graph.pairs[between]].mean(axis=1)
    low, high = np.minimum(a, b)[between], np.maximum(a, b)[between]
    order = np.lexsort((high, low))
    breaks = np.flatnonzero(np.diff(low[order]) | np.diff(high[order])) + 1
    found = []
    for group in np.split(order, breaks) if len(order) else []:
        pair = (int(low[group[0]]), int(high[group[0]]))
        sides = [fits[r].surface.project(middle[group])[1] * fits[r].orientation for r in pair]
        cosine = float(np.median(np.einsum("ij,ij->i", *sides)))
        if cosine > np.cos(np.radians(max_deg)):
            found.append((pair, len(group)))
    return sorted(found, key=lambda item: (-item[1], item[0]))


def _is_one_surface(
    parts: list[tuple[np.ndarray, np.ndarray, np.ndarray]],
    fits: list[RegionFit],
    sigma: float,
    options: FitOptions,
) -> bool:
    """Whether one primitive, or one B-spline in place of another, explains both regions."""
    both = [(points, normals) for points, normals, _ in parts]
    if fit_jointly(_JOINT_KINDS, both, sigma, options) is not None:
        return True
    if all(fit.surface.kind != "bspline" for fit in fits):
        return False
    points = np.concatenate([points for points, _, _ in parts])
    normals = np.concatenate([normals for _, normals, _ in parts])
    clearance = np.concatenate([clearance for _, _, clearance in parts])
    free = fit_bspline_surface(points, normals, sigma, options, border_distance=clearance)
    return free is not None and all(
        tested(free, part, sigma, options).is_accepted for part, _, _ in parts
    )
