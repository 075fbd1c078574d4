"""What the fitted surfaces tell about the border network: missing corners, spurious chains."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from crispline.curve import arc_length
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Topology
from crispline.sharp.contact import branch_points
from crispline.sharp.corner import Corner
from crispline.sharp.network import corner_vertices, rotated, split
from crispline.sharp.trace import guide_along
from crispline.surface.base import Array

_REVERSED_LENGTH = 4.0


def split_at_branches(
    topology: Topology, net_vertices: Array, regions: Mapping[int, RegionFit]
) -> Topology:
    """Put a corner wherever the crease of two surfaces turns because they touch there.

    Labels show no corner at such a point: the same two regions lie beside the
    crease before and after it. A closed chain is cut at two such points or not
    at all.
    """
    corners = set(corner_vertices(topology))
    for index, chain in enumerate(topology.chains):
        if chain.right == -1 or chain.left == -1:
            continue
        left, right = regions[chain.left], regions[chain.right]
        is_ring = chain.is_closed and int(chain.vertices[0]) not in corners
        branches = branch_points(
            guide_along(net_vertices[chain.vertices], is_ring),
            (left.surface, right.surface),
            (left.orientation, right.orientation),
        )
        path = net_vertices[chain.vertices[:-1]]
        nearest = {int(np.linalg.norm(path - branch, axis=1).argmin()) for branch in branches}
        positions = sorted(nearest)
        if is_ring:
            if len(positions) < 2:
                continue
            topology = rotated(topology, index, positions[0])
            positions = [position - positions[0] for position in positions[1:]]
        # From the back, so that the front part keeps its index and its positions.
        for position in reversed(positions):
            if 1 < position < len(path) - 1:
                topology = split(topology, index, position)
    return topology


def collapsible_chains(
    topology: Topology,
    net_vertices: Array,
    corners: Mapping[int, Corner],
    options: LocateOptions,
) -> Iterator[int]:
    """Indices of the chains whose corners are one point, or have changed places, ascending."""
    for index, chain in enumerate(topology.chains):
        start, end = int(chain.vertices[0]), int(chain.vertices[-1])
        if chain.is_closed:
            continue
        length = arc_length(net_vertices[chain.vertices])[-1]
        located = corners[end].position - corners[start].position
        in_net = net_vertices[end] - net_vertices[start]
        is_one_point = np.linalg.norm(located) <= options.collapse_distance
        is_reversed = located @ in_net < 0.0 and length < _REVERSED_LENGTH
        is_spurious = length < options.collapse_length and (is_one_point or is_reversed)
        if is_spurious and loops_keep_two(topology, index):
            yield index


def loops_keep_two(topology: Topology, index: int) -> bool:
    """Whether every loop through a chain has at least two others."""
    return all(
        len(loop) > 2
        for region_loops in topology.loops.values()
        for loop in region_loops
        if any(chain == index for chain, _ in loop)
    )
