"""A contour cut into its straight and round pieces.

The border of a pad or a pocket turns at its corners, and no one line or circle explains all of
it. But each of its sides has patches enough to grow from a few of them, and after the longest
are taken the rest is plain.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crispline.fit.choose import PrimitiveFit
from crispline.net.graph import components
from crispline.region.grow import Ground, Growth
from crispline.region.patches import Labels
from crispline.surface import Surface

_CLEARLY_MORE = 1.05  # worth of a curve with more parameters over that of one with fewer ...
_ONE_PATCH = 1.0  # ... beyond what one patch adds by chance
_WINDOW = 3  # rings of patches that a side grows from
_APART = 2  # rings between one such window and the next
_CHANCES = 2  # surfaces that may have grown over a place before no more are tried there
_OWN = 0.5  # share of its patches that no longer side has, of a side that is one
_MIN_REST = 4  # patches that a short side between two others leaves to itself
_OWN_REST = 0.3  # share of its patches that no other has, of such a short side
_EXPLAINED = 0.8  # share of the patches of a contour that its sides must explain
_LOOSE = 1.7  # scatter over that of the ground, beyond which the sides cut a bent contour short


@dataclass(frozen=True)
class Side:
    """A surface along a contour, which of the kinds it is, and the patches it has of it."""

    surface: Surface
    kind: int
    patches: Labels


def sides(ground: Ground, kinds: Sequence[PrimitiveFit], min_patches: int) -> list[Side]:
    """The surfaces that stand along a contour, and its patches shared out among them.

    Parameters
    ----------
    ground : the patches along one contour, all connected.
    kinds : surfaces that may stand there, those of fewest parameters first.
    min_patches : that a side must have.

    Returns
    -------
    One side where one surface explains it all; else as many as it takes; none if these leave a
    part or its scatter unexplained.
    """
    everything = np.arange(len(ground.points))
    whole = _grown(ground, kinds, everything)
    if whole is not None and _largest_rest(ground, whole[0]) < min_patches:
        is_side = len(everything) >= min_patches
        return [Side(whole[0].surface, whole[1], everything)] if is_side else []
    ungrown = ground
    chosen: list[tuple[Surface, int]] = []
    for growth, kind in sorted(_growths(ground, kinds), key=lambda found: -found[0].worth):
        own = growth.patches[ground.is_free[growth.patches]]
        if len(own) >= max(min_patches, _OWN * len(growth.patches)):
            chosen.append((growth.surface, kind))
            ground = ground.without(growth.patches)
    if not chosen or ground.is_free.mean() > 1.0 - _EXPLAINED:
        return []
    # What is between the ends of two long sides may be too short to grow among them.
    piece = components(ground.adjacency, ground.is_free)
    for name in np.unique(piece[ground.is_free]).tolist():
        rest = np.flatnonzero(ground.is_free & (piece == name))
        grown = _grown(ungrown, kinds, rest) if len(rest) >= _MIN_REST else None
        if grown is not None and ground.is_free[grown[0].patches].mean() >= _OWN_REST:
            chosen.append((grown[0].surface, grown[1]))
    away = np.abs([surface.signed_distance(ground.points) for surface, _ in chosen])
    while True:
        sizes = np.bincount(np.argmin(away, axis=0), minlength=len(chosen))
        if sizes.min() >= min_patches:
            break
        away = np.delete(away, np.argmin(sizes), axis=0)
        del chosen[int(np.argmin(sizes))]
    scatter = np.sqrt(np.mean(np.min(away, axis=0)[~ground.is_free] ** 2))
    if scatter > _LOOSE * ground.sigma:
        return []
    nearest = np.argmin(away, axis=0)
    return [Side(*found, np.flatnonzero(nearest == k)) for k, found in enumerate(chosen)]


def _growths(ground: Ground, kinds: Sequence[PrimitiveFit]) -> list[tuple[Growth, int]]:
    """What grows from places all along a contour."""
    found = []
    n_times = np.zeros(len(ground.points), dtype=np.int64)
    for window in _windows(ground):
        if n_times[window].min() < _CHANCES:
            grown = _grown(ground, kinds, window)
            if grown is not None:
                found.append(grown)
                n_times[grown[0].patches] += 1
    return found


def _grown(
    ground: Ground, kinds: Sequence[PrimitiveFit], seeds: Labels
) -> tuple[Growth, int] | None:
    """The simplest of the surfaces that explain most, and which kind it is."""
    growths = [
        (growth, index)
        for index, kind in enumerate(kinds)
        if (growth := ground.grown(kind, seeds)) is not None
    ]
    most = max((growth.worth for growth, _ in growths), default=0.0)
    # The first is the one of fewest parameters: what a few patches add is chance.
    return next((g for g in growths if _CLEARLY_MORE * g[0].worth + _ONE_PATCH >= most), None)


def _largest_rest(ground: Ground, growth: Growth) -> int:
    """Patches of the longest run of a contour that one surface leaves."""
    rest = np.ones(len(ground.points), dtype=bool)
    rest[growth.patches] = False
    piece = components(ground.adjacency, rest)
    return int(np.bincount(piece[rest]).max(initial=0))


def _windows(ground: Ground) -> list[Labels]:
    """Groups of near patches all along a contour."""
    near = ground.adjacency + ground.adjacency.T
    near.setdiag(1)
    reach = [near]
    while len(reach) < max(_WINDOW, _APART):
        reach.append(reach[-1] @ near)
    apart, window = reach[_APART - 1].tocsr(), reach[_WINDOW - 1].tocsr()
    is_covered = np.zeros(len(ground.points), dtype=bool)
    found = []
    for patch in range(len(ground.points)):
        if not is_covered[patch]:
            is_covered[apart[[patch]].indices] = True
            found.append(np.sort(window[[patch]].indices))
    return found
