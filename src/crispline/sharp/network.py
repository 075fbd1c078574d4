"""Changes to the border network of a labelled net that keep it a consistent manifold."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from crispline.region.topology import Chain, Loop, Topology

Use = tuple[int, int]
"""Index of a chain, and +1 if it is run through forward, else -1."""


def corner_vertices(topology: Topology) -> list[int]:
    """Net vertices at which chains end, ascending; a closed chain that meets no other has none."""
    ends = [chain.vertices[[0, -1]] for chain in topology.chains]
    vertices, count = np.unique(np.array(ends, dtype=np.int64), return_counts=True)
    n_ends = dict(zip(vertices.tolist(), count.tolist(), strict=True))
    lone = {int(c.vertices[0]) for c in topology.chains if c.is_closed}
    return [vertex for vertex in n_ends if vertex not in lone or n_ends[vertex] > 2]


def chains_at(topology: Topology, vertex: int) -> list[int]:
    """Indices of the chains that start or end at a vertex."""
    return [
        index
        for index, chain in enumerate(topology.chains)
        if vertex in (chain.vertices[0], chain.vertices[-1])
    ]


def chains_by_end(topology: Topology, vertices: Collection[int]) -> dict[int, list[int]]:
    """For each of some vertices the same as :func:`chains_at`, in the order of the vertices."""
    found: dict[int, list[int]] = {vertex: [] for vertex in vertices}
    for index, chain in enumerate(topology.chains):
        for vertex in {int(chain.vertices[0]), int(chain.vertices[-1])} & found.keys():
            found[vertex].append(index)
    return found


def labels_beside(chains: Iterable[Chain]) -> list[int]:
    """The regions beside chains, ascending, without the open border."""
    return sorted({label for chain in chains for label in (chain.left, chain.right)} - {-1})


def side_labels(chain: Chain) -> list[int]:
    """The regions on the left and right of a chain, without the open border."""
    return [label for label in (chain.left, chain.right) if label != -1]


def contracted(topology: Topology, index: int, kept: int, lost: int) -> Topology:
    """Shrink a chain to a point: one of its ends becomes the other everywhere.

    The chain must have two different ends; then one vertex and one edge go, so
    the Euler characteristic stays.
    """
    chains = tuple(
        _with_end_moved(chain, lost, kept)
        for position, chain in enumerate(topology.chains)
        if position != index
    )
    loops = {
        region: tuple(
            tuple((chain - (chain > index), side) for chain, side in loop if chain != index)
            for loop in region_loops
        )
        for region, region_loops in topology.loops.items()
    }
    return Topology(chains, loops)


def exchanged(topology: Topology, index: int) -> Topology | None:
    """Put a border between the two regions at the ends of a chain in place of the chain.

    Seen with the chain running north, from its south end (third region A) to its north end
    (third region B) between L in the west and R in the east, the new one runs from west to east
    between B and A, and has the vertices of the old ends.

    Returns
    -------
    The network with the new chain under the old index; None where fewer than four regions and
    four other chains meet at the two ends, or a loop would be left with less than two chains.
    """
    chain = topology.chains[index]
    start, end = chain.vertices[[0, -1]].tolist()
    south, north = ([i for i in chains_at(topology, v) if i != index] for v in (start, end))
    labels = labels_beside(topology.chains[i] for i in (index, *south, *north))
    outer = {*south, *north}
    if (len(south), len(north), len(outer), len(labels)) != (2, 2, 4, 4):
        return None
    if not loops_keep_two(topology, index):
        return None
    beside = {
        (i in south, side): i
        for i in outer
        for side in (chain.left, chain.right)
        if side in side_labels(topology.chains[i])
    }
    if len(beside) != 4:
        return None
    south_east, north_west = beside[True, chain.right], beside[False, chain.left]
    ahead, behind = (
        next(label for label in side_labels(topology.chains[i]) if label != side)
        for i, side in ((north_west, chain.left), (south_east, chain.right))
    )
    chains = list(topology.chains)
    chains[index] = Chain(chain.vertices[[0, -1]], ahead, behind)
    chains[south_east] = _with_end_moved(chains[south_east], start, end)
    chains[north_west] = _with_end_moved(chains[north_west], end, start)
    # The region in the north runs along it from west to east, the one in the south back.
    after = {(north_west, ahead): (index, 1), (south_east, behind): (index, -1)}

    loops = {
        region: tuple(tuple(use for use in loop if use[0] != index) for loop in found)
        for region, found in topology.loops.items()
    }
    return Topology(tuple(chains), _with_uses(loops, after))


def around_corner(topology: Topology, vertex: int) -> list[tuple[int, int]]:
    """The regions at a vertex, anticlockwise, each with the chain between it and the next one.

    Empty where a region or a chain comes there twice, or the net ends.
    """
    arriving: dict[int, int] = {}
    leaving: dict[int, int] = {}
    for region, loops in topology.loops.items():
        for loop in loops:
            for use, after in zip(loop, loop[1:] + loop[:1], strict=True):
                if _tip(topology, use) != vertex:
                    continue
                if region in arriving or after[0] in leaving:
                    return []
                arriving[region], leaving[after[0]] = use[0], region
    if not arriving:
        return []
    region = min(arriving)
    found = []
    for _ in arriving:
        found.append((region, arriving[region]))
        if arriving[region] not in leaving:
            return []
        region = leaving[arriving[region]]
    return found if region == found[0][0] and len(set(found)) == len(found) else []


def parted(topology: Topology, vertex: int, around: Sequence[tuple[int, int]]) -> Topology | None:
    """Make two corners of one of four regions, with a border of the first and the third between.

    The corner with the second region stays at the vertex, that with the fourth goes to the next
    vertex along the border of the third and the fourth.

    Parameters
    ----------
    around : see :func:`around_corner`.

    Returns
    -------
    The network with the new chain as its last; None if that border has no inner vertex.
    """
    (first, before), _, (third, moving), (_, last) = around
    vertices = topology.chains[moving].vertices
    if len(vertices) < 3:
        return None
    is_start = int(vertices[0]) == vertex
    other = int(vertices[1] if is_start else vertices[-2])
    chains = list(topology.chains)
    rest = vertices[1:] if is_start else vertices[:-1]
    chains[moving] = replace(chains[moving], vertices=rest)
    chains[last] = _with_end_moved(chains[last], vertex, other)
    chains.append(Chain(np.array([vertex, other]), first, third))
    added = {(before, first): (len(chains) - 1, 1), (moving, third): (len(chains) - 1, -1)}
    return Topology(tuple(chains), _with_uses(topology.loops, added))


def split(topology: Topology, index: int, position: int) -> Topology:
    """Cut a chain at the inner vertex ``vertices[position]``, which becomes a corner.

    The first part keeps the index, the second part is appended.
    """
    chain = topology.chains[index]
    first = replace(chain, vertices=chain.vertices[: position + 1])
    second = replace(chain, vertices=chain.vertices[position:])
    chains = (*topology.chains[:index], first, *topology.chains[index + 1 :], second)
    parts = {(index, 1): ((index, 1), (len(chains) - 1, 1))}
    parts[index, -1] = ((len(chains) - 1, -1), (index, -1))

    def cut(loop: Loop) -> Loop:
        return tuple(part for use in loop for part in parts.get(use, (use,)))

    loops = {
        region: tuple(cut(loop) for loop in region_loops)
        for region, region_loops in topology.loops.items()
    }
    return Topology(chains, loops)


def rotated(topology: Topology, index: int, position: int) -> Topology:
    """Let a closed chain start at its vertex ``vertices[position]``."""
    chain = topology.chains[index]
    ring = np.roll(chain.vertices[:-1], -position)
    turned = replace(chain, vertices=np.append(ring, ring[0]))
    chains = (*topology.chains[:index], turned, *topology.chains[index + 1 :])
    return replace(topology, chains=chains)


def shortened(topology: Topology, index: int) -> Topology:
    """Leave only the two ends of a chain."""
    chain = topology.chains[index]
    direct = replace(chain, vertices=chain.vertices[[0, -1]])
    chains = (*topology.chains[:index], direct, *topology.chains[index + 1 :])
    return replace(topology, chains=chains)


def successors(topology: Topology) -> dict[Use, Use]:
    """What follows every use of a chain in its loop."""
    return {
        use: loop[(k + 1) % len(loop)]
        for loops in topology.loops.values()
        for loop in loops
        for k, use in enumerate(loop)
    }


def cycles(follows: Mapping[Use, Use]) -> list[list[Use]]:
    """The loops that a map to successors stands for."""
    left = dict(follows)
    found = []
    while left:
        loop = [next(iter(left))]
        while (after := left.pop(loop[-1])) != loop[0]:
            loop.append(after)
        found.append(loop)
    return found


def relinked(
    chains: Mapping[int, Chain], loops: Iterable[Sequence[Use]], labels: Iterable[int]
) -> Topology:
    """The network of some chains and loops, the chains numbered anew in their order.

    Parameters
    ----------
    chains : by the numbers that the loops call them.
    loops : uses of chains, with their region on the left.
    labels : of all regions, also of those without a loop.
    """
    number = {old: new for new, old in enumerate(sorted(chains))}
    of_region: dict[int, list[Loop]] = {label: [] for label in labels}
    for loop in loops:
        chain, side = chains[loop[0][0]], loop[0][1]
        own = tuple((number[index], sign) for index, sign in loop)
        of_region[chain.left if side > 0 else chain.right].append(own)
    ordered = tuple(chains[old] for old in sorted(chains))
    return Topology(ordered, {label: tuple(found) for label, found in of_region.items()})


def _with_uses(
    loops: Mapping[int, tuple[Loop, ...]], after: Mapping[Use, Use]
) -> dict[int, tuple[Loop, ...]]:
    """Loops with new uses of chains, each after the use of a chain by a region."""

    def renewed(region: int, loop: Loop) -> Loop:
        new = [(use, after.get((use[0], region))) for use in loop]
        return tuple(one for pair in new for one in pair if one is not None)

    return {
        region: tuple(renewed(region, loop) for loop in found) for region, found in loops.items()
    }


def _tip(topology: Topology, use: Use) -> int:
    """Vertex at which a use of a chain ends."""
    return int(topology.chains[use[0]].vertices[-1 if use[1] > 0 else 0])


def loops_keep_two(topology: Topology, index: int) -> bool:
    """Whether every loop through a chain has at least two others."""
    return all(
        len(loop) > 2
        for region_loops in topology.loops.values()
        for loop in region_loops
        if any(chain == index for chain, _ in loop)
    )


def _with_end_moved(chain: Chain, lost: int, kept: int) -> Chain:
    """The chain with every end at ``lost`` moved to ``kept``."""
    vertices = chain.vertices.copy()
    for end in (0, -1):
        if vertices[end] == lost:
            vertices[end] = kept
    return replace(chain, vertices=vertices)
