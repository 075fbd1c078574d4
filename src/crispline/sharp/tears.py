"""Tears in thin walls, and bridges over slits: borders of surfaces that never meet so.

Where a wall is hardly thicker than the points are apart, the net has holes through it, and gaps
in the narrow face at its end. The labels then show the two sides of the wall with a border in
common, though the surfaces tell that they are apart there, back to back. Over a slit the net runs
from one side to the other, and the labels show a ring round that, though the surfaces meet in a
straight line or not at all. No such border is one of the part, and leaving it out mends the wall.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.network import Use, corner_vertices, cycles, relinked, successors
from crispline.surface.base import Array

_BACK_TO_BACK = np.cos(np.radians(120.0))  # between the outward normals of the sides of a wall
_APART = 1.0  # surfaces so far from each other do not meet there, spacings
_MOST = 0.8  # share of a border at which that must be so
_TURNS = 0.05  # mean square sine between directions on a ring; less is a straight line
_MIN_SINE = 0.3  # of the angle between surfaces that surely do not touch
_MAX_GAP = 12.0  # a tear from end to end, or round; a longer one may be what is there, spacings
_COVERED = 1.0  # with a point this near to its middle, on either side, a hole is none, spacings


def mended(
    topology: Topology, net_vertices: Array, regions: Mapping[int, RegionFit], cloud: cKDTree
) -> tuple[Topology, list[Chain]]:
    """The border network without the tears of thin walls and the bridges over slits.

    A closed tear is a hole through the wall, or a bridge; it goes if the points show none. An open
    one cuts the face at the end of the wall, from one side of it to the other; the borders of that
    face go on over the gap.

    Parameters
    ----------
    topology : chains, corners and loops of the labels.
    net_vertices : spacings, shape ``(n, 3)``.
    regions : the fitted surface of every label.
    cloud : the raw points, spacings.

    Returns
    -------
    The network, and the chains that went.
    """
    gone: list[Chain] = []
    is_open = True
    while is_open:  # one that is mended may let another be, or make a ring of it
        is_open = False
        for index, chain in enumerate(topology.chains):
            if not _is_tear(chain, net_vertices, regions):
                continue
            whole = _without(topology, index, net_vertices, regions, cloud)
            if whole is not None:
                topology, is_open = whole, True
                gone.append(chain)
                break
    return topology, gone


def _without(
    topology: Topology,
    index: int,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    cloud: cKDTree,
) -> Topology | None:
    """The network without a tear; None if it has to stay."""
    chain = topology.chains[index]
    if chain.is_closed and int(chain.vertices[0]) not in corner_vertices(topology):
        return _without_hole(topology, index, net_vertices, regions, cloud)
    return _without_gap(topology, index, net_vertices)


def _is_tear(chain: Chain, net_vertices: Array, regions: Mapping[int, RegionFit]) -> bool:
    """Whether the surfaces beside a chain are the two sides of a wall, or no ring is on both."""
    if -1 in (chain.left, chain.right):
        return False
    places = net_vertices[chain.vertices]
    length = np.linalg.norm(np.diff(places, axis=0), axis=1).sum()
    if length > np.pi * _MAX_GAP:
        return False
    sides = [regions[chain.left], regions[chain.right]]
    (first, up), (second, down) = (side.surface.project(places) for side in sides)
    facing = sides[0].orientation * sides[1].orientation * np.einsum("ij,ij->i", up, down)
    is_apart = np.linalg.norm(first - second, axis=1) > _APART
    if np.mean(is_apart & (facing < _BACK_TO_BACK)) >= _MOST:
        return True
    return chain.is_closed and _meet_straight(up, down)


def _meet_straight(first: Array, second: Array) -> bool:
    """Whether the curve on which surfaces of some normals meet runs the same way everywhere.

    Parameters
    ----------
    first, second : of the two surfaces, at places on a ring, shape ``(n, 3)``.
    """
    along = np.cross(first, second)
    sizes = np.linalg.norm(along, axis=1, keepdims=True)
    if sizes.min() < _MIN_SINE:
        return False
    along /= sizes
    largest = np.linalg.eigvalsh(along.T @ along / len(along))[-1]
    return bool(1.0 - largest < _TURNS)


def _without_hole(
    topology: Topology,
    index: int,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    cloud: cKDTree,
) -> Topology | None:
    """The network without a closed chain; None if the scan has a hole there."""
    chain = topology.chains[index]
    sides = (chain.left, chain.right)
    if any(len(topology.loops[label]) < 2 for label in sides):
        return None
    middle = net_vertices[chain.vertices[:-1]].mean(axis=0)[None]
    feet = np.concatenate([regions[label].surface.project(middle)[0] for label in sides])
    if np.min(cloud.query(feet)[0]) > _COVERED:
        return None
    chains = dict(enumerate(topology.chains))
    del chains[index]
    loops = [loop for found in topology.loops.values() for loop in found if loop[0][0] != index]
    return relinked(chains, loops, topology.loops)


def _without_gap(topology: Topology, index: int, net_vertices: Array) -> Topology | None:
    """The network without an open chain between two corners of the same three faces.

    The borders of the third face go on from one corner to the other. None if other faces meet
    there.
    """
    gap = topology.chains[index]
    if np.linalg.norm(np.subtract(*net_vertices[gap.vertices[[0, -1]]])) > _MAX_GAP:
        return None
    follows = successors(topology)
    before = {after: use for use, after in follows.items()}
    # Either side of the wall comes to the gap and leaves it along the third face.
    ways = [(before[index, side], follows[index, side]) for side in (1, -1)]
    (to_left, from_left), (to_right, from_right) = ways
    third = _other_side(topology.chains, to_left)
    is_alone = follows.get(_turned(from_right)) == _turned(to_left)
    is_alone &= follows.get(_turned(from_left)) == _turned(to_right)
    if not is_alone or third != _other_side(topology.chains, to_right):
        return None
    chains, name = dict(enumerate(topology.chains)), {}
    for (to, away), label in zip(ways, (gap.left, gap.right), strict=True):
        follows[to], follows[_turned(away)] = away, _turned(to)
        vertices = _along(topology.chains, to)
        ahead = vertices[:1] if to == away else _along(topology.chains, away)
        chains.pop(away[0], None)
        chains[to[0]] = Chain(np.concatenate([vertices, ahead]), label, third)
        for use in (to, away):
            name[use], name[_turned(use)] = (to[0], 1), (to[0], -1)
    del chains[index], follows[index, 1], follows[index, -1]
    loops = [[name.get(use, use) for use in loop] for loop in cycles(follows)]
    once = [[use for k, use in enumerate(loop) if use != loop[k - 1]] or loop[:1] for loop in loops]
    return relinked(chains, once, topology.loops)


def _turned(use: Use) -> Use:
    """The same chain, run through the other way."""
    return use[0], -use[1]


def _along(chains: Sequence[Chain], use: Use) -> NDArray[np.int64]:
    """Vertices of a chain in the order in which it is used."""
    return chains[use[0]].vertices[:: use[1]]


def _other_side(chains: Sequence[Chain], use: Use) -> int:
    """The region on the right of a chain as it is used."""
    chain = chains[use[0]]
    return chain.right if use[1] > 0 else chain.left
