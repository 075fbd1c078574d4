"""Where three or more sides of a grid meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.grid.crossings import Crossings, common_points
from crispline.grid.localfit import Support
from crispline.options import SharpenOptions
from crispline.surface.base import Array

Index = NDArray[np.int64]
_MOVE = 2.0
"""Farthest that a corner may lie from the crossings around its cell, spacings."""
_SAME = 0.5
"""Corners of neighbouring cells nearer than this are one, spacings."""


@dataclass(frozen=True)
class Corners:
    """Corners, each in a cell of the grid.

    Attributes
    ----------
    cells : shape ``(k, 2)``.
    points : located, spacings, ``(k, 3)``.
    is_corner : whether three or more sides meet in the cell, ``(k,)``; else it holds
        a located point of an edge.
    crossing : where two cells next to each other hold the same corner, the crossing
        between them, which then is the corner; else -1, ``(k,)``.
    """

    cells: Index
    points: Array
    is_corner: NDArray[np.bool_]
    crossing: Index


def locate_corners(
    crossings: Crossings, side: Index, support: Support, options: SharpenOptions
) -> Corners:
    """Corners in the cells with three or more crossings.

    Where the sides have no common point near, the corner is the mean of the
    crossings around the cell.
    """
    shape = (side.shape[0] - 1, side.shape[1] - 1)
    at_cell = cell_crossings(crossings, shape)
    cells = np.argwhere((at_cell >= 0).sum(axis=2) >= 3)
    cells = cells[support.lattice.has_patch[tuple(cells.T)]]
    around = at_cell[tuple(cells.T)]
    weight = (around >= 0)[:, :, None]
    points = (crossings.points[around] * weight).sum(axis=1) / weight.sum(axis=1)
    names = _names(side, cells)
    for n_sides in (3, 4):
        rows = np.flatnonzero((names > 0).sum(axis=1) == n_sides)
        if not rows.size:
            continue
        wanted = names[rows, :n_sides].T
        shapes, _ = support.fit(np.tile(cells[rows], (n_sides, 1)), wanted.ravel())
        parts = [shapes[np.arange(k * len(rows), (k + 1) * len(rows))] for k in range(n_sides)]
        lattice = support.lattice
        middle = [0.5 * (line[:-1] + line[1:]) for line in (lattice.u, lattice.v)]
        uv = np.stack([middle[0][cells[rows, 0]], middle[1][cells[rows, 1]]], axis=1)
        found, _, gap = common_points(parts, uv, points[rows])
        moved = np.linalg.norm(found - points[rows], axis=1)
        good = np.isfinite(found).all(axis=1) & (moved < _MOVE)
        # Four planes meet in a point only without noise: their mean is the corner then.
        good &= (gap < options.max_gap) | (n_sides > 3)
        points[rows[good]] = found[good]
    return _joined(cells, points, around)


def _joined(cells: Index, points: Array, around: Index) -> Corners:
    """One corner for two cells that share a crossing and have the same corner."""
    k = len(cells)
    shared, owner = around.ravel(), np.repeat(np.arange(k), 4)
    owner, shared = owner[shared >= 0], shared[shared >= 0]
    order = np.argsort(shared, kind="stable")
    owner, shared = owner[order], shared[order]
    twice = np.flatnonzero(shared[1:] == shared[:-1])
    a, b = owner[twice], owner[twice + 1]
    is_one = np.linalg.norm(points[a] - points[b], axis=1) < _SAME
    crossing = np.full(k, -1, dtype=np.int64)
    points, is_corner = points.copy(), np.ones(k, dtype=bool)
    for first, second, middle in zip(a[is_one], b[is_one], shared[twice[is_one]], strict=True):
        if crossing[first] < 0 and crossing[second] < 0:
            crossing[[first, second]] = middle
            points[[first, second]] = 0.5 * (points[first] + points[second])
            is_corner[second] = False
    return Corners(cells, points, is_corner, crossing)


def cell_crossings(crossings: Crossings, shape: tuple[int, int]) -> Index:
    """The crossing on each side of every cell, -1 without one, shape ``(m, n, 4)``.

    Sides in the order ``(i, j)`` to ``(i + 1, j)``, on to ``(i + 1, j + 1)``, to
    ``(i, j + 1)`` and back.
    """
    m, n = shape
    down = np.full((m, n + 1), -1, dtype=np.int64)
    right = np.full((m + 1, n), -1, dtype=np.int64)
    number = np.arange(len(crossings.axis))
    first = crossings.axis == 0
    down[tuple(crossings.start[first].T)] = number[first]
    right[tuple(crossings.start[~first].T)] = number[~first]
    return np.stack([down[:, :-1], right[1:], down[:, 1:], right[:-1]], axis=2)


def _names(side: Index, cells: Index) -> Index:
    """The different sides at the corners of cells, largest first, padded with 0, ``(k, 4)``."""
    i, j = cells.T
    names = np.stack([side[i, j], side[i + 1, j], side[i + 1, j + 1], side[i, j + 1]], axis=1)
    names = np.sort(names, axis=1)
    names[:, 1:][names[:, 1:] == names[:, :-1]] = 0
    return np.asarray(-np.sort(-names, axis=1))
