"""Surfaces of which a region has only a part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from crispline.fit.choose import PRIMITIVE_FITS, PrimitiveFit
from crispline.fit.residual import rms
from crispline.fit.robust import thinned
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Surface, unit
from crispline.surface.base import Array

_RICHER = {"plane": "cylinder", "cylinder": "torus", "cone": "torus", "sphere": "torus"}
"""What a narrow part of may pass for the simpler kind."""
_N_FIT = 250
_GROWTH_STEPS = 8
_GROWN = 1.02  # growth below this has come to rest
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
    free_forms = [region for region, fit in fits.items() if fit.surface.kind == "bspline"]
    for region in names[sizes <= options.max_pruned_patches].tolist():
        fit = fits.get(region)
        if fit is None or fit.surface.kind not in _RICHER:
            continue
        members = label == region
        near = np.flatnonzero(graph.rings(members, _REACH * options.expansion_rings))
        place = _Place(
            graph.points[near],
            graph.normals[near],
            csr_array(graph.adjacency[near][:, near]),
            np.flatnonzero(members[near]),
            float(np.median(noise[members])),
            float(np.cos(np.radians(options.grow_deg))),
        )
        surface, support = place.grown(PRIMITIVE_FITS[_RICHER[fit.surface.kind]])
        if surface is None or len(support) <= _FARTHER * len(place.support(fit.surface)):
            continue
        if place.turn(support) < _MIN_TURN:
            continue
        residuals = surface.signed_distance(fit.points)
        slack = 1.0 + _STANDARD_ERRORS * float(np.sqrt(2.0 / max(len(residuals), 1)))
        if rms(residuals) ** 2 > slack * rms(fit.residuals) ** 2:
            continue  # it bends over an edge to what lies beyond
        found[region] = replace(fit, surface=surface, residuals=residuals, is_accepted=True)
        taken = near[support]
        label[taken[np.isin(label[taken], free_forms)]] = region
    return label, found


@dataclass(frozen=True)
class _Place:
    """The patches about a region, and which of them are ``members`` of it.

    ``sigma`` is the noise of their centres; normals within ``min_cosine`` of a surface's
    are those of patches on it.
    """

    points: Array
    normals: Array
    adjacency: csr_array
    members: Labels
    sigma: float
    min_cosine: float

    def support(self, surface: Surface) -> Labels:
        """Patches on a surface that hang together with most of the region's."""
        feet, directions = surface.project(self.points)
        residual = np.einsum("ij,ij->i", self.points - feet, directions)
        turn = np.einsum("ij,ij->i", self.normals, directions)
        turn *= np.sign(turn[self.members].sum()) or 1.0
        close = (np.abs(residual) < 3.0 * self.sigma) & (turn > self.min_cosine)
        own = np.asarray(self.members[close[self.members]])
        if len(own) < _KEPT * len(self.members):
            return own
        piece = components(self.adjacency, close)
        pieces, votes = np.unique(piece[own], return_counts=True)
        return np.asarray(np.flatnonzero(close & (piece == pieces[np.argmax(votes)])))

    def turn(self, patches: Labels) -> float:
        """How far the normals of patches lean from their mean, but for a twentieth of them."""
        normals = self.normals[patches]
        middle = unit(normals.mean(axis=0))
        return float(np.arccos(np.clip(np.quantile(normals @ middle, 0.05), -1.0, 1.0)))

    def grown(self, fit: PrimitiveFit) -> tuple[Surface | None, Labels]:
        """The surface of the region, refitted to what it explains until that grows no more."""
        current, surface = self.members, None
        for _ in range(_GROWTH_STEPS):
            sample = current[thinned(len(current), _N_FIT)]
            surface = fit(self.points[sample], self.normals[sample], self.sigma, None, True)
            if surface is None:
                return None, current
            support = self.support(surface)
            if len(support) < _KEPT * len(self.members):
                return None, support
            if len(support) <= _GROWN * len(current):
                return surface, support
            current = support
        return surface, current
