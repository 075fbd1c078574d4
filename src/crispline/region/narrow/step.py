"""Walls of low steps: the faces that must be between a plane and what shares a border with it.

Parallel planes do not meet, nor do a plane and a curved face that runs along beside it. Where the
regions of two do all the same, the wall between them is a row or two of patches high, which no
seed fits into, or what is left of it are crumbs that lean any way. But its direction is known,
the normal of the plane, and where it stands the border tells: a line or a circle across that
direction holds it well, or, round a pad or a pocket, several that meet at its corners.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from crispline.fit.choose import PrimitiveFit
from crispline.fit.swept import (
    Profile,
    ProfileFit,
    Translation,
    concentric,
    fit_circle,
    fit_line,
)
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.claim import Claim, misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.grow import Ground
from crispline.region.narrow.contour import Side, sides
from crispline.region.narrow.rise import Fits, LowStep, Mask, low_steps
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Surface
from crispline.surface.base import Array

_RAGGED = 0.35  # scatter of the patches along a border about the true one, spacings
_KEPT = 0.8  # share of the patches along a border that its wall must explain
_OFF = 2.0  # sigmas; points so far off both faces are those of the wall between them ...
_NEAR = 1.5  # ... if no farther from where the patches have it, spacings
_MIN_POINTS = 6
_MIN_PATCHES = 8  # of a wall, two rows along its border: one that a groove or a pad ends with
_CLEARLY = 5.0  # by how much a curve with more parameters must be likelier, nats
_GROWTH_STEPS = 6
_RINGS = 2  # patches so near to a wall may be its own
_ANY_NORMAL = -2.0  # the net rounds a low wall


def with_step_walls(
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the walls between planes and faces along them, and the surfaces of these walls.

    Crumbs that stand between the two give way where a wall passes. Pieces of border that
    neither lines nor circles explain stay as they are. Where crumbs stand everywhere between the
    two, walls must explain the points better than these, each face counted.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    walls: dict[int, RegionFit] = {}
    for step in list(low_steps(label, fits, evidence.graph, options)):
        for piece, found in _walls(step, label, fits, evidence):
            name = int(label.max()) + 1
            parts = {plane: fits[plane] for plane in step.planes}
            new = {name + k: fit for k, (fit, _) in enumerate(found)}
            claims = [Claim(fit, evidence, options) for fit in (*parts.values(), *new.values())]
            near = evidence.graph.rings(piece, _RINGS)
            near &= np.isin(label, (*step.planes, *step.crumbs))
            costs = np.array([claim.patch_costs(near)[near] for claim in claims])
            if not step.must_be:
                crumbs = np.intersect1d(step.crumbs, label[piece])
                gain = _cost(label, near, fits, evidence, options) - np.min(costs, axis=0).sum()
                if gain < options.face_cost * (len(found) - len(crumbs)):
                    continue
            label[near] = np.array([*parts, *new])[np.argmin(costs, axis=0)]
            for wall, (_, patches) in zip(new, found, strict=True):
                label[patches] = wall  # all of them: no gap may remain
            walls |= new
    return label, walls


def _cost(
    label: Labels, near: Mask, fits: Fits, evidence: Evidence, options: RegionOptions
) -> float:
    """Of some patches, each on the surface of its region."""
    own = [(name, near & (label == name)) for name in np.unique(label[near]).tolist()]
    return float(
        sum(Claim(fits[n], evidence, options).patch_costs(mask)[mask].sum() for n, mask in own)
    )


def _walls(
    step: LowStep, label: Labels, fits: Fits, evidence: Evidence
) -> Iterator[tuple[Mask, list[tuple[RegionFit, Labels]]]]:
    """The walls of every piece of the border, its patches, and those of each wall."""
    graph = evidence.graph
    along = step.touching | np.isin(label, step.crumbs)
    along |= _pinches(along, graph) & np.isin(label, step.planes)
    piece = components(graph.adjacency, along)
    profiles = [*(concentric(centre) for centre in step.centres), fit_line, fit_circle]
    kinds = [_swept(profile, step.sweep) for profile in profiles]
    for name in np.unique(piece[step.touching if step.must_be else along]):
        members = np.flatnonzero(along & (piece == name))
        ground = Ground(
            graph.points[members],
            graph.normals[members],
            csr_array(graph.adjacency[members][:, members]),
            np.ones(len(members), dtype=bool),
            _RAGGED,
            _ANY_NORMAL,
            _KEPT,
            _GROWTH_STEPS,
        )
        found = [
            (
                _snug(side, members[side.patches], piece == name, step, profiles, fits, evidence),
                side,
            )
            for side in sides(ground, kinds, _MIN_PATCHES)
        ]
        if found:
            yield piece == name, [(fit, members[side.patches]) for fit, side in found]


def _pinches(along: Mask, graph: PatchGraph) -> Mask:
    """Patches beside two of some that have only a vertex in common, where a wall falls apart."""
    rows = np.flatnonzero(~along & (graph.adjacency @ along.astype(np.int64) > 1))
    members = np.flatnonzero(along)
    inner = graph.adjacency[members][:, members]
    beside = graph.adjacency[rows][:, members]
    # Ordered pairs of members beside a patch, and those of them that a third member links.
    n_beside = np.asarray(beside.sum(axis=1)).ravel()
    linked = ((inner + inner @ inner) > 0).astype(np.int64)
    n_linked = np.asarray(beside.multiply(beside @ linked).sum(axis=1)).ravel() - n_beside
    found = np.zeros(len(along), dtype=bool)
    found[rows[n_linked < n_beside * (n_beside - 1)]] = True
    return found


def _snug(
    side: Side,
    patches: Labels,
    contour: Mask,
    step: LowStep,
    profiles: Sequence[ProfileFit],
    fits: Fits,
    evidence: Evidence,
) -> RegionFit:
    """A wall on the raw points that neither of the faces beside it has, if these are enough.

    A circle about the axis of a neighbour has the fewest parameters, but these points are too
    few to tell which axis, if any: the patches have told.
    """
    usual = len(step.centres)
    kinds = [*([side.kind] if side.kind < usual else []), *range(usual, len(profiles))]
    own = np.zeros(len(evidence.graph), dtype=bool)
    own[patches] = True
    near = evidence.graph.rings(own, 1) & (own | ~contour)
    rows = np.flatnonzero(near[evidence.patch])
    points, sigma = evidence.points[rows], evidence.noise[rows]
    off = np.min(
        [np.abs(fits[face].surface.signed_distance(points)) for face in step.planes], axis=0
    )
    is_own = (off > _OFF * sigma) & (np.abs(side.surface.signed_distance(points)) < _NEAR)
    if is_own.sum() < _MIN_POINTS:
        return held_fit(side.surface, patches, evidence)
    points, sigma = points[is_own], sigma[is_own]
    flat = step.sweep.flattened(points)
    found, least = side.surface, np.inf
    for kind in kinds:
        curve = profiles[kind](flat, float(np.median(sigma)))
        if curve is not None:
            surface = step.sweep.surface(curve)
            cost = float(misfit(surface.signed_distance(points), sigma).sum())
            if cost + _CLEARLY < least:
                found, least = surface, cost
    return held_fit(found, patches, evidence)


def _swept(fit_profile: ProfileFit, sweep: Translation) -> PrimitiveFit:
    """The fit of a profile as that of a surface."""

    def fit(
        points: Array,
        _normals: Array,
        sigma: float,
        _start: Any = None,
        _draft: bool = False,
        /,
    ) -> Surface | None:
        profile: Profile | None = fit_profile(sweep.flattened(points), sigma)
        return None if profile is None else sweep.surface(profile)

    return fit
