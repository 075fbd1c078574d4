"""Quads of a net gathered into rectangles, as few as a greedy search finds."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from crispline.spline.creased import Index
from crispline.spline.sectors import next_corner

RIGHT, UP, LEFT, DOWN = range(4)


def rectangles(twin: Index, may_merge: NDArray[np.bool_]) -> list[Index]:
    """Partition of the quads into rectangular blocks of neighbours.

    A quad that is turned so that its corner ``i`` is the lower left one, and the
    half-edge that leaves it the lower side, is named by that corner, ``4 f + i``.

    Parameters
    ----------
    twin : opposite half-edge of each half-edge, -1 on an open border, shape ``(4 m,)``.
    may_merge : half-edges that a rectangle may have inside, shape ``(4 m,)``; two such
        sides of one quad that share a vertex meet four at that vertex.

    Returns
    -------
    For each rectangle its turned quads, shape ``(a, b)``: the first axis goes right,
    the second up. Every quad is in one rectangle, and no rectangle meets itself
    along a side. Large ones come first.
    """
    beside = _steps(twin)
    step = _steps(np.where(may_merge, twin, -1))
    is_free = np.ones(len(twin) // 4, dtype=bool)
    found: list[Index] = []
    for seed in _seeds(step):
        if is_free[seed]:
            found.append(_grown(np.array([[4 * seed]]), step, is_free))
    pieces = [piece for block in found for piece in _without_contact(block, beside)]
    return sorted(pieces, key=lambda block: (-block.size, int(block[0, 0])))


def _steps(twin: Index) -> Index:
    """Neighbours of every turned quad, turned alike, for each direction; -1 for none."""
    corner = np.arange(len(twin))
    table = np.empty((4, len(twin)), dtype=np.int64)
    for direction in (RIGHT, UP, LEFT, DOWN):
        side = corner
        for _ in range((direction + 1) % 4):
            side = next_corner(side)
        across = turned = twin[side]
        for _ in range((1 - direction) % 4):
            turned = next_corner(turned)
        table[direction] = np.where(across >= 0, turned, -1)
    return table


def _seeds(step: Index) -> Index:
    """All quads, those farthest from a side that is not to be merged first."""
    beside = step[:, ::4]
    depth = np.where((beside < 0).any(axis=0), 0, len(beside[0]))
    while True:
        nearest = np.where(beside >= 0, depth[beside // 4], 0).min(axis=0)
        deeper = np.minimum(depth, nearest + 1)
        if np.array_equal(deeper, depth):
            return np.argsort(-depth, kind="stable")
        depth = deeper


def _grown(block: Index, step: Index, is_free: NDArray[np.bool_]) -> Index:
    """Add whole rows and columns of free quads on all four sides in turn, and take them."""
    is_free[block // 4] = False
    n_blocked, direction = 0, RIGHT
    while n_blocked < 4:
        row = step[direction, _border(block, direction)]
        quads = row // 4
        holds = (row >= 0).all() and is_free[quads].all()
        holds = holds and np.array_equal(step[UP - direction % 2, row[:-1]], row[1:])
        if holds and len(set(quads.tolist())) == len(quads):
            is_free[quads] = False
            block, n_blocked = _extended(block, row, direction), 0
        else:
            n_blocked += 1
        direction = (direction + 1) % 4
    return block


def _border(block: Index, direction: int) -> Index:
    return (block[-1], block[:, -1], block[0], block[:, 0])[direction]


def _extended(block: Index, row: Index, direction: int) -> Index:
    axis = direction % 2
    line = np.expand_dims(row, axis)
    parts = (block, line) if direction in (RIGHT, UP) else (line, block)
    return np.concatenate(parts, axis=axis)


def _without_contact(block: Index, beside: Index) -> Iterator[Index]:
    """The block, halved until no piece has a side in common with itself."""
    axis = _contact_axis(block, beside) if block.size > 1 else None
    if axis is None:
        yield block
        return
    for half in np.array_split(block, 2, axis=axis):
        yield from _without_contact(half, beside)


def _contact_axis(block: Index, beside: Index) -> int | None:
    """The axis to cut across, or None if the block does not meet itself."""
    for direction in (RIGHT, UP, LEFT, DOWN):
        across = beside[direction][_border(block, direction)]
        if np.isin(across[across >= 0] // 4, block // 4).any():
            return direction % 2 if block.shape[direction % 2] > 1 else 1 - direction % 2
    return None
