"""What noise and the width of a patch have cut or hidden, put back one kind after the other."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from crispline.net.graph import components
from crispline.net.halfedge import HalfEdges
from crispline.options import FitOptions, RegionOptions
from crispline.region.cleanup import tidy
from crispline.region.evidence import Evidence
from crispline.region.expand import expand_regions
from crispline.region.fitting import held_fit
from crispline.region.narrow.balls import with_balls
from crispline.region.narrow.bevels import with_bevels
from crispline.region.narrow.coaxial import broken_rings
from crispline.region.narrow.ends import with_ends
from crispline.region.narrow.groove import with_grooves
from crispline.region.narrow.necks import with_necks
from crispline.region.narrow.openings import with_openings
from crispline.region.narrow.pieces import bridged, shared_by_pieces
from crispline.region.narrow.ring import with_rings
from crispline.region.narrow.rounds import with_rounds
from crispline.region.narrow.step import with_step_walls
from crispline.region.narrow.straights import with_straights
from crispline.region.narrow.strips import joined_strips
from crispline.region.narrow.turns import with_turns
from crispline.region.narrow.wedge import with_wedges
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

_TURN_PASSES = 2  # walls are fitted again without what they had of a round

Refit = Callable[[Labels], Mapping[int, RegionFit]]


def restored(
    label: Labels,
    fits: Mapping[int, RegionFit],
    refit: Refit,
    net_vertices: Array,
    quads: HalfEdges,
    evidence: Evidence,
    options: RegionOptions,
    fit_options: FitOptions,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels and fits with the narrow faces, and with faces whole that a narrow place has parted.

    Narrow faces keep the surfaces to which their neighbours hold them; the others are fitted
    again.

    Parameters
    ----------
    label, fits : regions and the surface of each.
    refit : the surface of every region of new labels.
    net_vertices, quads : the net that the patches belong to.
    """
    graph = evidence.graph
    known: dict[int, RegionFit] = {}
    low: set[int] = set()

    def settle(new: Labels, found: Mapping[int, RegionFit]) -> None:
        nonlocal label, fits
        label = tidy(new, quads, options.min_patches, low)
        known.update(found)
        fits = _held(refit(label), known, label, new, evidence)

    whole = with_necks(label, fits, evidence, options)
    if not np.array_equal(whole, label):
        settle(whole, {})
    new, bends = with_straights(label, fits, evidence, options)
    if bends:
        new = expand_regions(new, {**fits, **bends}, evidence, options)
        settle(new, bends)
    new, walls = with_openings(label, fits, evidence, options)
    if walls:
        settle(new, walls)
    new, cuts = with_bevels(label, fits, {}, evidence, options, only_clear=True)
    if cuts:
        settle(closed_rings(new, cuts, graph, options), cuts)
    new, rounds = with_rounds(label, fits, cuts, evidence, options)
    if rounds:
        settle(closed_rings(new, rounds, graph, options), rounds)
    new, bevels = with_bevels(label, fits, {**rounds, **cuts}, evidence, options)
    if bevels:
        settle(closed_rings(new, bevels, graph, options), bevels)
    new, balls = with_balls(label, fits, evidence, options)
    if balls:
        settle(expand_regions(new, {**fits, **balls}, evidence, options), balls)
    for _ in range(_TURN_PASSES):
        new, turns = with_turns(label, fits, evidence, options, fit_options)
        if not turns:
            break
        settle(expand_regions(new, {**fits, **turns}, evidence, options), turns)
    new, rings = with_rings(label, fits, evidence, options)
    if rings:
        new = expand_regions(new, {**fits, **rings}, evidence, options)
        settle(closed_rings(new, rings, graph, options), rings)
    new, grooves = with_grooves(label, fits, evidence, quads, options)
    if grooves:
        settle(new, grooves)
    broken = broken_rings(label, fits, evidence, options)
    whole = closed_rings(label, broken, graph, options)
    if not np.array_equal(whole, label):
        settle(whole, broken)
    pieces = shared_by_pieces(label, fits, evidence, options)
    if pieces:
        new = expand_regions(label, {**fits, **pieces}, evidence, options)
        settle(bridged(new, fits, pieces, graph, options), pieces)
    new, walls = with_step_walls(label, fits, evidence, options)
    if walls:
        low |= walls.keys()
        settle(new, walls)
    new, grown = with_wedges(label, fits, graph, quads, options)
    if grown:
        # Where a wall is lower than a patch, the points of its patches are not its own.
        settle(new, {name: fits[name] for name in grown})
    whole = joined_strips(label, fits, evidence, options, fit_options)
    if not np.array_equal(whole, label):
        parted, held = label, fits
        settle(whole, {})
        fits = {**fits, **{r: fit for r, fit in held.items() if _is_same(r, parted, label)}}
    return with_ends(label, fits, net_vertices, quads, evidence, options)


def _is_same(region: int, first: Labels, second: Labels) -> bool:
    return np.array_equal(first == region, second == region)


def closed_rings(
    label: Labels, rings: Mapping[int, RegionFit], graph: PatchGraph, options: RegionOptions
) -> Labels:
    """Labels after closing the gaps through which the neighbours of a ring touch.

    Where a face is a patch wide, noise breaks it into pieces; the larger faces that have most of
    its border touch there.
    """
    label = label.copy()
    for name, fit in rings.items():
        own = label == name
        beside, sides = np.unique(label[graph.rings(own, 1) & ~own], return_counts=True)
        if len(beside) < 2:
            continue
        pair = beside[np.argsort(-sides, kind="stable")[:2]]
        touching = (np.sort(label[graph.pairs], axis=1) == np.sort(pair)).all(axis=1)
        gap = np.zeros(len(label), dtype=bool)
        gap[graph.pairs[touching]] = True
        gap &= np.abs(fit.surface.signed_distance(graph.points)) < options.ring_gap
        piece = components(graph.adjacency, own | gap)
        label[gap & np.isin(piece, piece[own])] = name
    return label


def _held(
    fits: Mapping[int, RegionFit],
    known: Mapping[int, RegionFit],
    label: Labels,
    before: Labels,
    evidence: Evidence,
) -> dict[int, RegionFit]:
    """The fits with those known, also on the pieces that a region has been cut into."""
    held = {**fits, **{region: fit for region, fit in known.items() if region in fits}}
    for region, fit in known.items():
        for piece in np.setdiff1d(label[before == region], before).tolist():
            held[piece] = held_fit(fit.surface, np.flatnonzero(label == piece), evidence)
    return held
