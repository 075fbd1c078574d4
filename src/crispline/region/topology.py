"""Chains, corners and loops of a labelled net: topology without coordinates."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.net.halfedge import HalfEdges

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


def border_topology(quads: HalfEdges, label: NDArray[np.int64]) -> Topology:
    """Chains and loops of a labelled quad net.

    Loops are followed by turning about the vertex inside the region, so regions
    that touch themselves or others in a single vertex are told apart.

    Parameters
    ----------
    quads : connectivity of the net.
    label : region of every quad, shape ``(m,)``.
    """
    quad, following, twin = quads.quad, quads.next, quads.twin
    left = label[quad]
    right = np.where(twin >= 0, left[np.maximum(twin, 0)], -1)
    is_border = left != right
    successor = following.copy()
    inner = is_border & ~is_border[successor]
    while inner.any():
        successor[inner] = following[twin[successor[inner]]]
        inner = is_border & ~is_border[successor]

    once = is_border & ((twin < 0) | (np.arange(len(twin)) < twin))
    valence = np.bincount(quads.origin[once], minlength=quads.n_vertices)
    valence += np.bincount(quads.target[once], minlength=quads.n_vertices)
    starts_at_corner = is_border & (valence[quads.origin] != 2)
    first_uses: dict[int, tuple[int, int]] = {}
    last_uses: dict[tuple[int, int], int] = {}
    chains: list[Chain] = []
    visited = np.zeros(len(twin), dtype=bool)
    border = np.flatnonzero(is_border)
    for start in np.concatenate([np.flatnonzero(starts_at_corner), border]).tolist():
        if visited[start]:
            continue
        run = [start]
        while valence[quads.target[run[-1]]] == 2 and successor[run[-1]] != start:
            run.append(int(successor[run[-1]]))
        opposite = twin[run]
        visited[run] = True
        visited[opposite[opposite >= 0]] = True
        index = len(chains)
        vertices = np.append(quads.origin[run], quads.target[run[-1]])
        chains.append(Chain(vertices, int(left[start]), int(right[start])))
        first_uses[start], last_uses[index, 1] = (index, 1), run[-1]
        if right[start] >= 0:
            first_uses[int(opposite[-1])] = (index, -1)
            last_uses[index, -1] = int(opposite[0])

    loops: dict[int, list[Loop]] = {int(region): [] for region in np.unique(label)}
    seen: set[tuple[int, int]] = set()
    for use in last_uses:
        loop: list[tuple[int, int]] = []
        current = use
        while current not in seen:
            seen.add(current)
            loop.append(current)
            current = first_uses[int(successor[last_uses[current]])]
        if loop:
            chain = chains[use[0]]
            loops[chain.left if use[1] > 0 else chain.right].append(tuple(loop))
    return Topology(tuple(chains), {region: tuple(found) for region, found in loops.items()})
