"""Corners that labels cannot show: where two surfaces touch and their crease turns."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from crispline.region.regionfit import RegionFit
from crispline.region.topology import Topology
from crispline.sharp.contact import branch_points
from crispline.sharp.network import corner_vertices, rotated, split
from crispline.sharp.trace import guide_along
from crispline.surface.base import Array


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
