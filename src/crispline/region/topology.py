"""Chains, corners and loops of a labelled net: topology without coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Loop = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Chain:
    """A run of net edges that separates two regions.

    Attributes
    ----------
    vertices : net vertices in order, shape ``(k,)``, ``k >= 2``; first and last
        are corners (three or more chains meet), or equal for a closed chain.
    left, right : region labels on either side, seen from outside the part with
        the chain running forward; -1 for the open border of a net.
    """

    vertices: NDArray[np.int64]
    left: int
    right: int

    @property
    def is_closed(self) -> bool:
        """Whether the chain returns to its first vertex."""
        return bool(self.vertices[0] == self.vertices[-1])


@dataclass(frozen=True)
class Topology:
    """The border network of a labelled net.

    Attributes
    ----------
    chains : see :class:`Chain`.
    loops : for every region label, its closed border loops as
        ``((chain index, +1 forward | -1 backward), ...)`` with the region on
        the left; an empty tuple for a region without a border.
    """

    chains: tuple[Chain, ...]
    loops: Mapping[int, tuple[Loop, ...]]
