"""Edges that end before a face which touches them: where a round chamfer meets the flat of a nut.

A cone that turns the corners of a prism touches its sides, or nearly so. Close to such a point
its face is narrower than the labels can tell: its two pieces end on either side, with an edge
between their tips that hardly leaves the cone. That edge is the point.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence, Set
from functools import cache
from itertools import product

import numpy as np

from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.network import (
    chains_by_end,
    contracted,
    corner_vertices,
    labels_beside,
    loops_keep_two,
    shortened,
)
from crispline.sharp.trace import MAX_MOVE, guide_along
from crispline.surface.base import Array
from crispline.surface.intersect import intersect

_LOST = 0.8  # a tip of a face that is nowhere wider than this may have no label, spacings
_STRAIGHT = 1e-3  # a surface whose distance bends less along an edge crosses it, spacings


def met_at_touches(
    topology: Topology,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    options: LocateOptions,
    held: Set[int] = frozenset(),
) -> tuple[Topology, Array, set[int]]:
    """The border network after finding the corners beside a surface that touches an edge.

    That surface is the same at both ends of the edge, on two faces. An edge that does not cross
    it shrinks to the corner where the two are nearest; one that does ends where it crosses.

    Parameters
    ----------
    topology : chains, corners and loops of the labels.
    net_vertices : spacings, shape ``(n, 3)``.
    regions : the fitted surface of every label.
    options : what counts as being on a surface.
    held : vertices at which all edges stay as long as they are.

    Returns
    -------
    The network, the vertices and the corners to which an edge has shrunk. The surfaces there may
    miss each other by a little, so that their curves pass the corner side by side: only those
    that are drawn to it end at an angle.
    """

    @cache
    def are_one(first: int, second: int) -> bool:
        return _are_one(regions[first], regions[second], options.corner_gap)

    touches: set[int] = set()
    crossed: set[tuple[int, int]] = set()
    while True:
        around = chains_by_end(topology, corner_vertices(topology))
        for index, chain in enumerate(topology.chains):
            start, end = int(chain.vertices[0]), int(chain.vertices[-1])
            if (start, end) in crossed:
                continue
            if start == end or -1 in (chain.left, chain.right) or not held.isdisjoint((start, end)):
                continue
            beyond = [
                set(labels_beside(topology.chains[k] for k in around[vertex]))
                for vertex in (start, end)
            ]
            places = _touches(chain, beyond, net_vertices, regions, are_one, options)
            if len(places) and loops_keep_two(topology, index):
                break
        else:
            return topology, net_vertices, touches
        net_vertices = net_vertices.copy()
        net_vertices[start], net_vertices[end] = places[0], places[-1]
        if len(places) == 1:
            topology = contracted(topology, index, start, end)
            touches = touches - {end} | {start}
        else:
            topology = shortened(topology, index)
            crossed.add((start, end))


def _touches(
    chain: Chain,
    beyond: Sequence[set[int]],
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    are_one: Callable[[int, int], bool],
    options: LocateOptions,
) -> Array:
    """The one place where an edge touches the surface beyond its ends, or the two where it crosses.

    Shape ``(k, 3)``; none where it does neither. ``beyond`` are the regions round its two ends.
    """
    nowhere = np.empty((0, 3))
    own = (chain.left, chain.right)
    pairs = [
        pair
        for pair in product(*(sorted(labels.difference(own)) for labels in beyond))
        if pair[0] != pair[1]
        and are_one(*pair)
        and not any(are_one(*sorted((pair[0], label))) for label in own)
    ]
    if not pairs:
        return nowhere
    guide = guide_along(net_vertices[chain.vertices], is_closed=False).points
    along, gap = intersect(guide, [regions[label].surface for label in own])
    if gap.max() > options.corner_gap or np.linalg.norm(along - guide, axis=1).max() > MAX_MOVE:
        return nowhere
    off = regions[pairs[0][0]].surface.signed_distance(along)
    if np.abs(off).max() > _LOST or np.abs(off).min() > options.corner_gap:
        return nowhere
    # Across a tangent the distance of a surface is a parabola.
    last = len(off) - 1
    bend, slope, height = np.polyfit(np.arange(last + 1.0), off, 2)
    if abs(bend) * last**2 < _STRAIGHT:
        return nowhere
    middle, inside = -0.5 * slope / bend, 0.25 * (slope / bend) ** 2 - height / bend
    if inside <= 0.0:
        return np.asarray(along[[round(np.clip(middle, 0, last))]])
    crossings = middle + np.sqrt(inside) * np.array([-1.0, 1.0])
    if crossings[0] < 0.0 and crossings[1] > last:
        return nowhere
    return np.asarray(along[np.round(np.clip(crossings, 0, last)).astype(int)])


def _are_one(first: RegionFit, second: RegionFit, max_gap: float) -> bool:
    """Whether the feet of each of two faces' points lie on the surface of the other."""
    return first.surface.kind == second.surface.kind and all(
        len(of.points) > 0
        and np.abs(one.surface.signed_distance(of.surface.project(of.points)[0])).max() < max_gap
        for one, of in ((first, second), (second, first))
    )
