"""Corners of four faces that are two corners of three.

Where a narrow face ends, or two edges pass close by each other, the labels of four faces may meet
in one vertex of the net. Four surfaces have no common point unless they were made to; two pairs
of three have, with a short border between.
"""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from crispline.options import LocateOptions
from crispline.sharp.finder import Finder
from crispline.sharp.network import around_corner, parted
from crispline.sharp.short import EXACT, Sites, is_reversed, towards
from crispline.sharp.trace import guide_along


def with_corners_parted(
    sites: Sites, held: Set[int], finder: Finder, options: LocateOptions
) -> Sites:
    """Part each corner of four surfaces without a common point, if that gives two exact ones.

    Parameters
    ----------
    held : net vertices that stay.
    """
    for vertex, corner in sorted(sites.corners.items()):
        if vertex in held or not corner.is_fallback or corner.gap <= options.corner_gap:
            continue
        around = around_corner(sites.topology, vertex)
        if len(around) != 4:
            continue
        ways = [_parted(sites, vertex, around[k:] + around[:k], finder, options) for k in range(4)]
        found = [way for way in ways if way is not None]
        if found:
            sites = found[0]
    return sites


def _parted(
    sites: Sites,
    vertex: int,
    around: list[tuple[int, int]],
    finder: Finder,
    options: LocateOptions,
) -> Sites | None:
    """The network with a border between the first and the third region, if it holds."""
    topology = parted(sites.topology, vertex, around)
    if topology is None:
        return None
    chain = topology.chains[-1]
    other = int(chain.vertices[-1])
    if other in sites.corners:
        return None
    outer = [index for _, index in around]
    places = np.stack(2 * [sites.vertices[vertex]])
    pairs = [outer[:2], outer[2:]]
    found = finder.corners(places, pairs, topology.chains, sites.borders)
    if any(corner.is_fallback or corner.gap > EXACT for corner in found):
        return None
    across = found[1].position - found[0].position
    sides = [towards(sites.topology, sites.vertices, vertex, pair) for pair in pairs]
    if np.linalg.norm(across) <= options.collapse_distance:
        return None
    if across @ (sides[1] - sides[0]) <= 0.0:
        return None
    vertices = sites.vertices.copy()
    vertices[[vertex, other]] = [corner.position for corner in found]
    (border,) = finder.borders([chain], [guide_along(vertices[[vertex, other]], False)])
    corners = sites.corners | {vertex: found[0], other: found[1]}
    better = Sites(topology, vertices, (*sites.borders, border), corners)
    if any(is_reversed(better, topology.chains[index]) for index in outer):
        return None
    return better
