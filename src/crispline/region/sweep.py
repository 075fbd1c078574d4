"""Smooth neighbours that are pieces of one face swept along a line or turned about an axis.

Between its creases a spline that was swept has no primitive in it, yet noise lets a few
cylinders or tori pass for most of it. They leave more in the residuals than a profile does
that takes hardly more numbers to tell, and their borders are nowhere in the part.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from crispline.fit.extrusion import fit_extrusion
from crispline.fit.revolution import fit_revolution
from crispline.fit.robust import thinned
from crispline.fit.verdict import explains
from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import LabelledCloud, fitted_region
from crispline.region.merge import MIN_BORDER, Samples, chi_square, gentle_borders
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import ExtrudedSurface, RevolvedSurface, Surface
from crispline.surface.base import Array

_NOISE_SHARE = 0.02  # fits differ by this much per point for reasons that are no faces
_MAX_ROUNDS = 8
_ABOUT_AXIS = {"cylinder": 4, "cone": 4, "sphere": 2, "torus": 4, "revolution": 4}

Pair = tuple[int, int]


class SweptFit(Protocol):
    """The fit of a swept profile."""

    def __call__(
        self,
        points: Array,
        normals: Array,
        sigma: float,
        options: FitOptions,
        *,
        border_distance: Array | None = None,
    ) -> Surface | None: ...


@dataclass(frozen=True)
class Sweep:
    """A way to sweep a profile.

    Attributes
    ----------
    fit : of one face.
    result : what it finds.
    pieces : the kinds that a piece of such a face may pass for.
    strips : and those that a small piece beside one of these may pass for.
    shared : how many numbers of each kind tell the place of the sweep, which the pieces have in
        common.
    """

    fit: SweptFit
    result: type[Surface]
    pieces: tuple[str, ...]
    strips: tuple[str, ...]
    shared: Mapping[str, int]

    def numbers(self, surface: Surface) -> int:
        """Numbers that a surface takes once the place of the sweep is known."""
        return surface.n_parameters - self.shared.get(surface.kind, 0)


SWEEPS = (
    Sweep(fit_extrusion, ExtrudedSurface, ("cylinder", "cone", "bspline"), ("plane",), {}),
    Sweep(
        fit_revolution,
        RevolvedSurface,
        (*_ABOUT_AXIS, "bspline"),
        (),
        _ABOUT_AXIS,
    ),
)


def with_sweeps(
    label: Labels,
    fits: Mapping[int, RegionFit],
    labelled: LabelledCloud,
    graph: PatchGraph,
    options: RegionOptions,
    fit_options: FitOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels after joining neighbours that one swept profile explains better.

    Better is: with the shorter description, residuals and parameters together. So cylinders
    that touch as designed stay, as nothing is left in their residuals. Pairs are tried first,
    then all that hang together: small pieces leave little, each by itself.

    Parameters
    ----------
    label, fits : regions and surface of each.

    Returns
    -------
    The labels, and the surfaces of the joined regions.
    """
    search = _Search(label.copy(), dict(fits), labelled, graph, options, fit_options)
    for _ in range(_MAX_ROUNDS):
        if not search.join_pairs():
            break
    search.join_groups()
    return search.label, {region: search.fits[region] for region in search.joined}


@dataclass
class _Search:
    """Regions that are joined step by step."""

    label: Labels
    fits: dict[int, RegionFit]
    labelled: LabelledCloud
    graph: PatchGraph
    options: RegionOptions
    fit_options: FitOptions
    joined: set[int] = field(default_factory=set)
    refused: set[Pair] = field(default_factory=set)
    samples: dict[int, Samples] = field(default_factory=dict)

    def borders(self) -> Iterator[Pair]:
        """Neighbours that go over into each other smoothly, those of the longest border first."""
        gentle = gentle_borders(self.label, self.fits, self.graph, self.options.merge_deg)
        yield from (pair for pair, sides, _ in gentle if sides >= MIN_BORDER)

    def join_pairs(self) -> bool:
        """Join pairs; whether there were any."""
        changed = False
        for pair in self.borders():
            if pair in self.refused or not set(pair) <= set(self.fits):
                continue
            sweeps = [sweep for sweep in SWEEPS if self.may_be_swept(pair, sweep)]
            if sweeps and self.join(pair, sweeps):
                self.refused = {p for p in self.refused if pair[0] not in p}
                changed = True
            else:
                self.refused.add(pair)
        return changed

    def join_groups(self) -> None:
        """Join three and more that hang together."""
        for sweep in SWEEPS:
            pairs = [pair for pair in self.borders() if self.may_be_swept(pair, sweep)]
            for group in connected(pairs):
                if len(group) > 2:
                    self.join(group, [sweep])

    def may_be_swept(self, pair: Pair, sweep: Sweep) -> bool:
        """Whether two surfaces may be pieces of one that was swept."""
        two = [self.fits[region] for region in pair]
        smaller, larger = sorted(two, key=lambda fit: len(fit.points))
        kinds = sweep.pieces
        return larger.surface.kind in kinds and smaller.surface.kind in (*kinds, *sweep.strips)

    def join(self, regions: Sequence[int], sweeps: Sequence[Sweep]) -> bool:
        """Make one region of several if one surface is the better description."""
        for region in regions:
            if region not in self.samples:
                self.samples[region] = self.labelled.samples(region, self.fit_options)
        parts = [self.samples[region] for region in regions]
        fits = [self.fits[region] for region in regions]
        one = _joint(sweeps, parts, fits, self.labelled.sigma(*regions), self.fit_options)
        if one is None:
            return False
        kept, *gone = regions
        self.label[np.isin(self.label, gone)] = kept
        self.samples[kept] = _together(parts)
        self.fits[kept] = one
        for region in gone:
            del self.fits[region]
        self.joined = (self.joined - set(gone)) | {kept}
        return True


def connected(pairs: Sequence[Pair]) -> list[tuple[int, ...]]:
    """Names that pairs hold together, each group in ascending order.

    >>> connected([(1, 2), (5, 6), (2, 9)])
    [(1, 2, 9), (5, 6)]
    """
    groups: list[set[int]] = []
    for pair in pairs:
        touching = [group for group in groups if group & set(pair)]
        groups = [group for group in groups if not group & set(pair)]
        groups.append(set(pair).union(*touching))
    return sorted(tuple(sorted(group)) for group in groups)


def _together(parts: Sequence[Samples]) -> Samples:
    points, normals, clearance = zip(*parts, strict=True)
    return np.concatenate(points), np.concatenate(normals), np.concatenate(clearance)


def _joint(
    sweeps: Sequence[Sweep],
    parts: Sequence[Samples],
    fits: Sequence[RegionFit],
    sigma: float,
    options: FitOptions,
) -> RegionFit | None:
    """One swept profile for several regions; None if none pays."""
    points, normals, clearance = _together(parts)
    kept = thinned(len(points), 2 * options.max_points)
    sigma = max(sigma, options.sigma_floor)
    n = len(points)
    apart = chi_square(
        [(fit.surface, part) for fit, (part, _, _) in zip(fits, parts, strict=True)], sigma
    )
    for sweep in sweeps:
        surface = sweep.fit(
            points[kept], normals[kept], sigma, options, border_distance=clearance[kept]
        )
        if surface is None:
            continue
        spared = sum(sweep.numbers(fit.surface) for fit in fits) - sweep.numbers(surface)
        # Where there is a swept spline already, another takes no place from primitives.
        is_known = any(isinstance(fit.surface, sweep.result) for fit in fits)
        slack = 0.0 if is_known else _NOISE_SHARE * n
        together = chi_square([(surface, part) for part, _, _ in parts], sigma)
        if together + slack > apart + 2.0 * spared * float(np.log(n)):
            continue
        if all(explains(surface, part, facing, sigma, options) for part, facing, _ in parts):
            return fitted_region(surface, points, normals, True)
    return None
