"""Surfaces of which a region has only a part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from crispline.fit.choose import PRIMITIVE_FITS
from crispline.fit.residual import rms
from crispline.options import RegionOptions
from crispline.region.grow import Ground
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import FREE_FORMS, unit
from crispline.surface.base import Array

_RICHER = {"plane": "cylinder", "cylinder": "torus", "cone": "torus", "sphere": "torus"}
"""What a narrow part of may pass for the simpler kind."""
_GROWTH_STEPS = 8
_KEPT = 0.7  # share of the region's patches that the richer surface must explain
_FARTHER = 1.25  # patches that it must explain, over those that the region's surface does
_STANDARD_ERRORS = 2.0  # by which it may explain the region's own points worse than now
_REACH = 2  # in expansion reaches
_MIN_TURN = np.radians(30.0)  # of the normals, to either side: less may be a piece of a free form


def completed(
    label: Labels,
    fits: Mapping[int, RegionFit],
    graph: PatchGraph,
    noise: Array,
    options: RegionOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels and fits after giving small regions the surface that goes on around them.

    A round between two faces touches both, and each of them takes its share; what is left
    of a cylinder passes for a plane, of a torus for a sphere, and as such it never grows
    again. But it is on the cylinder or torus that the patches beside it lie too: a region
    becomes one if that explains clearly more patches about it than its own surface.

    Parameters
    ----------
    fits : surface of every label.
    noise : of the patch centres, shape ``(m,)``, spacings.

    Returns
    -------
    The labels, B-spline patches on such a surface given to it, as a B-spline explains what
    primitives do; and the fits.
    """
    label, found = label.copy(), dict(fits)
    names, sizes = np.unique(label, return_counts=True)
    free_forms = [region for region, fit in fits.items() if fit.surface.kind in FREE_FORMS]
    for region in names[sizes <= options.max_pruned_patches].tolist():
        fit = fits.get(region)
        if fit is None or fit.surface.kind not in _RICHER:
            continue
        members = label == region
        near = np.flatnonzero(graph.rings(members, _REACH * options.expansion_rings))
        own = np.flatnonzero(members[near])
        ground = Ground(
            graph.points[near],
            graph.normals[near],
            csr_array(graph.adjacency[near][:, near]),
            np.ones(len(near), dtype=bool),
            float(np.median(noise[members])),
            float(np.cos(np.radians(options.grow_deg))),
            _KEPT,
            _GROWTH_STEPS,
        )
        growth = ground.grown(PRIMITIVE_FITS[_RICHER[fit.surface.kind]], own)
        if growth is None:
            continue
        surface, taken = growth.surface, near[growth.patches]
        if len(taken) <= _FARTHER * len(ground.support(fit.surface, own)[0]):
            continue
        if _turn(graph.normals[taken]) < _MIN_TURN:
            continue
        residuals = surface.signed_distance(fit.points)
        slack = 1.0 + _STANDARD_ERRORS * float(np.sqrt(2.0 / max(len(residuals), 1)))
        if rms(residuals) ** 2 > slack * rms(fit.residuals) ** 2:
            continue  # it bends over an edge to what lies beyond
        found[region] = replace(fit, surface=surface, residuals=residuals, is_accepted=True)
        label[taken[np.isin(label[taken], free_forms)]] = region
    return label, found


def _turn(normals: Array) -> float:
    """How far normals ``(n, 3)`` lean from their mean, but for a twentieth of them."""
    middle = unit(normals.mean(axis=0))
    return float(np.arccos(np.clip(np.quantile(normals @ middle, 0.05), -1.0, 1.0)))
