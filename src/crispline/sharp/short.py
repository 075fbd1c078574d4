"""Short borders whose corners are one point or have changed places.

Labels are ragged, so near a place where four faces nearly meet they may join the wrong two of
them: the corners at the ends of their border then lie the wrong way round. The other two faces
have a border there instead.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Set

import numpy as np

from crispline.curve import arc_length
from crispline.options import LocateOptions
from crispline.region.topology import Topology
from crispline.sharp.backward import EXACT, is_backward
from crispline.sharp.doubt import Doubt
from crispline.sharp.finder import Finder
from crispline.sharp.network import (
    chains_at,
    contracted,
    exchanged,
    labels_beside,
    loops_keep_two,
)
from crispline.sharp.sites import Sites
from crispline.sharp.trace import guide_along
from crispline.surface.base import Array

_REVERSED_LENGTH = 4.0
"""Corners farther apart than this in the net have not changed places by chance, in spacings."""
_RAGGED = 2.0
"""A chain that leads away from its start is one point though so much longer than one that may
come back: along a chamfer that touches the wall beside it labels run on past their corner."""
_AWAY = 0.5
"""Share of its length by which it leads away."""
_FAR = 4.0
"""Where a border leads to is seen so far from its corner, in spacings."""


def without_short_borders(
    sites: Sites,
    held: Set[int],
    finder: Finder,
    options: LocateOptions,
    *,
    may_exchange: bool = True,
) -> tuple[Sites, list[Doubt]]:
    """Exchange each short border that runs backwards, or has no corner at an end, for one of the
    other two faces at its ends if that has exact corners; let others become a corner.

    Parameters
    ----------
    held : net vertices that stay.
    may_exchange : whether a border need not follow sides of the net.

    Returns
    -------
    The new network, and a doubt per border that became a corner.
    """
    doubts: list[Doubt] = []
    tried: set[tuple[int, int]] = set()
    while True:
        better = _first_exchange(sites, held, tried, finder, options) if may_exchange else None
        if better is not None:
            sites = better
            continue
        short = _first_free(sites, held, options)
        if short is None:
            return sites, doubts
        chain = sites.topology.chains[short]
        start, end = chain.vertices[[0, -1]].tolist()
        kept, lost = (start, end) if end not in held else (end, start)
        sites = _collapse(sites, short, kept, lost, finder)
        names = ", ".join(map(str, labels_beside([chain])))
        text = (
            f"the border of regions {names} near {{place}} is shorter "
            "than its corners are certain and became one corner"
        )
        doubts.append(Doubt(text, sites.vertices[kept]))


def collapsible_chains(sites: Sites, options: LocateOptions) -> Iterator[int]:
    """Indices of the chains whose corners are one point, or have changed places, ascending."""
    for index, chain in enumerate(sites.topology.chains):
        if chain.is_closed:
            continue
        length = arc_length(sites.vertices[chain.vertices])[-1]
        is_one_point = np.linalg.norm(sites.across(index)) <= options.collapse_distance
        is_turned = is_backward(sites, index) and length < _REVERSED_LENGTH
        first, last = sites.vertices[chain.vertices[[0, -1]]]
        is_away = np.linalg.norm(last - first) > _AWAY * length
        is_short = length < options.collapse_length
        is_ragged = is_away and length < _RAGGED * options.collapse_length
        is_spurious = (is_one_point and (is_short or is_ragged)) or (is_turned and is_short)
        if is_spurious and loops_keep_two(sites.topology, index):
            yield index


def _first_free(sites: Sites, held: Set[int], options: LocateOptions) -> int | None:
    """A short chain of which at least one end may go."""
    for index in collapsible_chains(sites, options):
        if not set(sites.topology.chains[index].vertices[[0, -1]].tolist()) <= held:
            return index
    return None


def _first_exchange(
    sites: Sites,
    held: Set[int],
    tried: set[tuple[int, int]],
    finder: Finder,
    options: LocateOptions,
) -> Sites | None:
    """The first exchange that holds, of short borders that run backwards or end nowhere."""
    collapsible = set(collapsible_chains(sites, options))
    for index, chain in enumerate(sites.topology.chains):
        start, end = chain.vertices[[0, -1]].tolist()
        if start == end or (start, end) in tried or not held.isdisjoint((start, end)):
            continue
        is_lost = sites.corners[start].is_fallback or sites.corners[end].is_fallback
        is_short = arc_length(sites.vertices[chain.vertices])[-1] < _REVERSED_LENGTH
        if index in collapsible or (is_lost and is_short):
            tried.add((start, end))
            better = _exchange(sites, index, finder, options)
            if better is not None:
                return better
    return None


def _collapse(sites: Sites, index: int, kept: int, lost: int, finder: Finder) -> Sites:
    """One corner for both ends of a chain, half way between them.

    Labels along a shallow edge may be so ragged that corners lie far from their ends in the net.
    """
    vertices = sites.vertices.copy()
    pair = [sites.corners[kept], sites.corners[lost]]
    if any(corner.is_fallback for corner in pair):
        vertices[kept] = vertices[[kept, lost]].mean(axis=0)
    else:
        vertices[kept] = np.mean([corner.position for corner in pair], axis=0)
    topology = contracted(sites.topology, index, kept, lost)
    borders = (*sites.borders[:index], *sites.borders[index + 1 :])
    corners = {vertex: sites.corners[vertex] for vertex in sites.corners if vertex != lost}
    ending = [chains_at(topology, kept)]
    corners[kept] = finder.corners(vertices[[kept]], ending, topology.chains, borders)[0]
    return Sites(topology, vertices, borders, corners)


def _exchange(sites: Sites, index: int, finder: Finder, options: LocateOptions) -> Sites | None:
    """The border of the other two faces in place of a short one, if it holds."""
    topology = exchanged(sites.topology, index)
    if topology is None:
        return None
    ends = topology.chains[index].vertices[[0, -1]].tolist()
    beside = [[i for i in chains_at(topology, end) if i != index] for end in ends]
    return with_border(sites, topology, index, beside, finder, options)


def with_border(
    sites: Sites,
    topology: Topology,
    index: int,
    beside: Sequence[Sequence[int]],
    finder: Finder,
    options: LocateOptions,
) -> Sites | None:
    """A network with a new border, if its corners are exact and no border runs backwards.

    Parameters
    ----------
    topology : the network with the new chain.
    index : of that chain.
    beside : the other chains at its start and at its end.
    """
    chain = topology.chains[index]
    ends = chain.vertices[[0, -1]].tolist()
    places = np.stack(2 * [sites.vertices[ends].mean(axis=0)])
    found = finder.corners(places, beside, topology.chains, sites.borders)
    if any(corner.is_fallback or corner.gap > EXACT for corner in found):
        return None
    across = found[1].position - found[0].position
    sides = [_towards(topology, sites.vertices, *at) for at in zip(ends, beside, strict=True)]
    # Of faces that are not all convex either pair may meet in such an order; one that meets farther
    # apart than labels are ragged was not hidden by them.
    if not options.collapse_distance < np.linalg.norm(across) < _REVERSED_LENGTH:
        return None
    if across @ (sides[1] - sides[0]) <= 0.0:
        return None
    vertices = sites.vertices.copy()
    vertices[ends] = [corner.position for corner in found]
    (border,) = finder.borders([chain], [guide_along(vertices[ends], False)])
    borders = (*sites.borders[:index], border, *sites.borders[index + 1 :])
    better = Sites(topology, vertices, borders, sites.corners | dict(zip(ends, found, strict=True)))
    outer = (*beside[0], *beside[1])
    return None if any(is_backward(better, other) for other in outer) else better


def _towards(topology: Topology, vertices: Array, vertex: int, around: Sequence[int]) -> Array:
    """Sum of the unit directions in which some chains lead away from one of their ends.

    Parameters
    ----------
    vertices : of the net, shape ``(n, 3)``.
    around : indices of the chains.
    """
    total = np.zeros(3)
    for chain in (topology.chains[index].vertices for index in around):
        path = vertices[chain if int(chain[0]) == vertex else chain[::-1]]
        away = path - path[0]
        distance = np.linalg.norm(away, axis=1)
        far = np.flatnonzero(distance > _FAR)
        last = int(far[0]) if len(far) else len(path) - 1
        total += away[last] / max(distance[last], EXACT)
    return total
