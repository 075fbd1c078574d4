"""Crossings joined to edges: polylines from corner to corner, to the border, or closed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.grid.corners import Corners, cell_crossings
from crispline.grid.crossings import Crossings
from crispline.surface.base import Array

Index = NDArray[np.int64]


def polylines(crossings: Crossings, corners: Corners, shape: tuple[int, ...]) -> list[Array]:
    """The edges as polylines of located points, each of shape ``(k, 3)``, ``k >= 2``.

    Two crossings of a cell are joined, those of a cell with a corner to the corner.
    A polyline ends where other than two pieces meet; a closed one repeats its first
    point. In the order of their first crossings.
    """
    points = np.concatenate([crossings.points, corners.points])
    pieces = _pieces(crossings, corners, (shape[0], shape[1]))
    neighbours: list[list[int]] = [[] for _ in points]
    for a, b in pieces.tolist():
        neighbours[a].append(b)
        neighbours[b].append(a)
    left = {(a, b) for a, b in pieces.tolist()} | {(b, a) for a, b in pieces.tolist()}
    ends = [k for k, near in enumerate(neighbours) if len(near) != 2]
    found = []
    # First from the ends; what then is left is closed.
    for start in [*ends, *range(len(points))]:
        for then in neighbours[start]:
            if (start, then) not in left:
                continue
            path = [start, then]
            left -= {(start, then), (then, start)}
            while len(neighbours[path[-1]]) == 2 and path[-1] != start:
                here = path[-1]
                onward = [k for k in neighbours[here] if (here, k) in left]
                if not onward:
                    break
                left -= {(here, onward[0]), (onward[0], here)}
                path.append(onward[0])
            found.append(points[path])
    return found


def _pieces(crossings: Crossings, corners: Corners, shape: tuple[int, int]) -> Index:
    """Pairs of points that a piece of an edge joins, shape ``(k, 2)``."""
    around = cell_crossings(crossings, shape)
    centre = np.full(shape, -1, dtype=np.int64)
    centre[tuple(corners.cells.T)] = len(crossings.axis) + np.arange(len(corners.cells))
    is_met = around >= 0
    two = (is_met.sum(axis=2) == 2) & (centre < 0)
    pairs = around[two][is_met[two]].reshape(-1, 2)
    # A corner of two cells is the crossing between them.
    lies_between = corners.crossing >= 0
    centre[tuple(corners.cells[lies_between].T)] = corners.crossing[lies_between]
    at, slot = np.nonzero(is_met[centre >= 0])
    spokes = np.stack([centre[centre >= 0][at], around[centre >= 0][at, slot]], axis=1)
    return np.concatenate([pairs, spokes[spokes[:, 0] != spokes[:, 1]]])
