"""B-splines that are a few primitives."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from crispline.fit.choose import PRIMITIVE_FITS, choose_surface
from crispline.options import FitOptions, RegionOptions
from crispline.region.patches import Labels, PatchGraph
from crispline.region.split import split_into_surfaces
from crispline.surface.base import Array

_MAX_PARTS = 3
_COVERED = 0.8  # share of the region that the parts must have; neighbours may take the rest


def resolved(
    label: Labels,
    candidates: Collection[int],
    graph: PatchGraph,
    is_sharp: NDArray[np.bool_],
    noise: Array,
    options: RegionOptions,
    fit_options: FitOptions,
) -> Labels:
    """Labels after taking small B-splines apart that two or three primitives explain.

    A fillet that grew over the round of its corner is neither cylinder nor torus any more,
    and a B-spline explains what is left of both. It has a hundred parameters and more, the
    primitives have a dozen.

    Parameters
    ----------
    candidates : regions that were primitives and became B-splines when their borders moved;
        not those that were merged, because nothing but a B-spline explains the whole.
    is_sharp, noise, fit_options : see :func:`crispline.region.split.split_into_surfaces`.
    """
    names, sizes = np.unique(label, return_counts=True)
    for region in names[sizes <= options.max_pruned_patches].tolist():
        if region not in candidates:
            continue
        trial, _ = split_into_surfaces(
            label, graph, is_sharp, noise, options, fit_options, [region]
        )
        members = np.flatnonzero(label == region)
        parts = [members[trial[members] == n] for n in range(label.max() + 1, trial.max() + 1)]
        if not 1 < len(parts) <= _MAX_PARTS:
            continue
        if sum(map(len, parts)) < _COVERED * len(members):
            continue
        if all(_is_primitive(part, graph, noise, fit_options) for part in parts):
            label = trial
    return label


def _is_primitive(part: Labels, graph: PatchGraph, noise: Array, options: FitOptions) -> bool:
    points, normals, sigma = graph.points[part], graph.normals[part], float(np.median(noise[part]))
    return choose_surface(points, normals, sigma, options, tuple(PRIMITIVE_FITS)).is_accepted
