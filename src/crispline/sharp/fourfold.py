"""Corners of four faces that are two corners of three.

Where a narrow face ends, or two edges pass close by each other, the labels of four faces may meet
in one vertex of the net. Four surfaces have no common point unless they were made to; two pairs
of three have, with a short border between.
"""

from __future__ import annotations

from collections.abc import Set

from crispline.options import LocateOptions
from crispline.sharp.finder import Finder
from crispline.sharp.network import around_corner, parted
from crispline.sharp.short import with_border
from crispline.sharp.sites import Sites


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
    index = len(topology.chains) - 1
    if int(topology.chains[index].vertices[-1]) in sites.corners:
        return None
    outer = [chain for _, chain in around]
    return with_border(sites, topology, index, [outer[:2], outer[2:]], finder, options)
