"""A border network with what was found for it."""

from __future__ import annotations

from dataclasses import dataclass

from crispline.region.topology import Topology
from crispline.sharp.corner import Corner
from crispline.sharp.crease import Border
from crispline.surface.base import Array


@dataclass(frozen=True)
class Sites:
    """A border network with what was found for it.

    Attributes
    ----------
    topology : the network.
    vertices : of the net, shape ``(n, 3)``.
    borders : of every chain.
    corners : by the net vertex where chains end.
    """

    topology: Topology
    vertices: Array
    borders: tuple[Border, ...]
    corners: dict[int, Corner]

    def ends(self, index: int) -> tuple[int, int]:
        """Net vertices where a chain starts and ends."""
        start, end = self.topology.chains[index].vertices[[0, -1]].tolist()
        return start, end

    def across(self, index: int) -> Array:
        """From the corner at the start of a chain to that at its end."""
        start, end = self.ends(index)
        return self.corners[end].position - self.corners[start].position
