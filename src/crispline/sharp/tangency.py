"""Surfaces adjusted to each other: smooth borders close, regular positions hold.

Noise leaves two surfaces that touch in the design apart by a fraction of it, or
lets them cut a little into each other, along the whole border. Where noise
explains the gap at the places of equal normals, it is made zero there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from crispline.fit.constrained import Adjustment, Pair, estimate, is_proper
from crispline.fit.regularize import regularize
from crispline.fit.starts import extent
from crispline.options import FitOptions, LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Topology
from crispline.sharp.contact import Contact
from crispline.sharp.crease import Border, touching_border
from crispline.sharp.network import corner_vertices
from crispline.sharp.trace import MAX_MOVE, guide_along
from crispline.surface import Surface
from crispline.surface.base import Array
from crispline.surface.intersect import intersect, newton_step

_N_PLACES = 9
_CORRECTIONS = 2
_MAX_RISE = 60.0  # of the chi-square of one surface, which has at most 7 parameters


@dataclass(frozen=True)
class Tangency:
    """Two surfaces that touch along a curve.

    Attributes
    ----------
    members : which two.
    orientations : +1 if a surface's own normal points out of the part, else -1.
    places : points of equal normals on either surface, shape ``(n, 3)``.
    """

    members: tuple[int, int]
    orientations: tuple[int, int]
    places: Array

    def at(self, first: Surface, second: Surface) -> Tangency:
        """The same with its places moved to where the normals are equal now."""
        places = self.places
        contact = Contact(first, second, self.orientations[0] * self.orientations[1])
        for _ in range(_CORRECTIONS):
            places = places + newton_step(places, [first, second, contact])
        return replace(self, places=places)

    def values(self, first: Surface, second: Surface) -> Array:
        """Gaps at the places, shape ``(n,)``, spacings."""
        ahead, behind = (
            orientation * surface.signed_distance(self.places)
            for orientation, surface in zip(self.orientations, (first, second), strict=True)
        )
        return np.asarray(ahead - behind)

    def derivatives(self, pair: Pair, position: int) -> Array:
        """Of the gaps, by the parameters of one of the two surfaces, shape ``(n, p)``."""
        sign = self.orientations[position] * (1.0 if position == 0 else -1.0)
        return sign * pair[position].distance_derivatives(self.places)


def adjusted(
    topology: Topology,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    sigma: float,
    fit_options: FitOptions,
    options: LocateOptions,
) -> dict[int, RegionFit]:
    """The fits after closing their smooth borders, as far as noise explains it.

    Parameters
    ----------
    topology, net_vertices, regions : as for :func:`crispline.sharp.locate.locate`.
    sigma : noise of the raw points, spacings.
    fit_options : whether to regularise as well.
    options : which borders count as smooth.
    """
    sigma = max(sigma, fit_options.sigma_floor)
    estimates = {
        label: found
        for label, fit in sorted(regions.items())
        if (found := estimate(fit.surface, fit.points, sigma)) is not None
    }
    adjustment = Adjustment(estimates)
    free_form: set[int] = set()
    anchors = corner_vertices(topology)
    for chain in sorted(topology.chains, key=lambda chain: -len(chain.vertices)):
        pair = (chain.left, chain.right)
        if not all(label in estimates for label in pair):
            continue
        is_ring = chain.is_closed and int(chain.vertices[0]) not in anchors
        guide = guide_along(net_vertices[chain.vertices], is_ring)
        tangency = _tangency(
            pair, touching_border(guide, [regions[label] for label in pair], options)
        )
        if tangency is not None and not adjustment.propose(tangency):
            # Designed primitives touch or cross; pieces of a free form do neither cleanly.
            free_form |= set(pair)
    if fit_options.regularize:
        regular = [label for label in estimates if label not in free_form]
        surfaces = {label: regions[label].surface for label in regular}
        sizes = np.array([extent(regions[label].points) for label in regular])
        regularize(adjustment, surfaces, sizes)
    while True:
        moved = _refitted(adjustment.solved(), regions)
        worst = _most_spoilt(moved, regions, sigma)
        if worst is None:
            return {**regions, **moved}
        adjustment.forget(worst)


def _tangency(pair: tuple[int, int], border: Border | None) -> Tangency | None:
    """The relation at a border where two surfaces seem to touch; None at any other."""
    if border is None or all(surface.kind == "plane" for surface in border.surfaces):
        return None
    guide = border.guide.points
    starts = guide[np.linspace(0, len(guide) - 1, _N_PLACES + 2).round().astype(int)[1:-1]]
    places, _ = intersect(starts, border.constraints)
    places = places[np.linalg.norm(places - starts, axis=1) <= MAX_MOVE]
    if len(places) <= _N_PLACES // 2:
        return None
    return Tangency(pair, (border.orientations[0], border.orientations[1]), places)


def _refitted(
    surfaces: Mapping[int, Surface], regions: Mapping[int, RegionFit]
) -> dict[int, RegionFit]:
    """The fits on their new surfaces."""
    return {
        label: replace(
            regions[label],
            surface=surface,
            residuals=surface.signed_distance(regions[label].points),
        )
        for label, surface in surfaces.items()
    }


def _most_spoilt(
    moved: Mapping[int, RegionFit], regions: Mapping[int, RegionFit], sigma: float
) -> int | None:
    """A surface that is none any more, or has left its points most; None if noise explains all.

    The price of a relation is worked out to first order: a surface that its points
    hold loosely may not be where that said.
    """
    for label, fit in sorted(moved.items()):
        if not is_proper(fit.surface, regions[label].surface):
            return label
    rise = {label: _chi_square(fit) - _chi_square(regions[label]) for label, fit in moved.items()}
    worst = max(rise, key=lambda label: (rise[label], label), default=None)
    return None if worst is None or rise[worst] <= _MAX_RISE * sigma**2 else worst


def _chi_square(fit: RegionFit) -> float:
    """Sum of squared residuals; infinite for a surface that is nowhere."""
    total = float(np.square(fit.residuals).sum())
    return total if np.isfinite(total) else np.inf
