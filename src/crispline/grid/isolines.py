"""Edges that run along rows or columns through the whole grid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.grid.crossings import Crossings, meet
from crispline.grid.localfit import Sides, Support
from crispline.options import SharpenOptions
from crispline.surface.base import Array

Index = NDArray[np.int64]

_WANDER = 0.35
"""An edge runs along a row or column if it stays within this of it, in cells."""
_JOG = 0.7
"""Crossings this near to such an edge, the other way, are part of it, in cells."""
_MIN_COVER = 0.8


@dataclass(frozen=True)
class IsoLine:
    """An edge across the whole grid at one parameter.

    Attributes
    ----------
    axis : 0 if it runs along a row (``u`` is constant), 1 along a column.
    at : the row or column, as a fraction.
    along : parameters of the located points on the line, increasing, shape ``(k,)``.
    points : located points, spacings, shape ``(k, 3)``.
    before, after : the sides below and above ``at``, a polynomial for each point.
    """

    axis: int
    at: float
    along: Array
    points: Array
    before: Sides
    after: Sides


def iso_lines(
    crossings: Crossings, support: Support, options: SharpenOptions
) -> tuple[IsoLine, ...] | None:
    """The edges as lines of constant parameter, if all of them are; else None.

    Each is located anew at every row or column that it crosses.
    """
    found = [_clusters(crossings, axis, support.side.shape[1 - axis]) for axis in (0, 1)]
    if not any(found):
        return None
    explained = np.zeros(len(crossings.axis), dtype=bool)
    for axis in (0, 1):
        for rows in found[axis]:
            level = float(np.median(crossings.at[rows, axis]))
            explained |= np.abs(crossings.at[:, axis] - level) < _JOG
    if not explained.all():
        return None
    lines = []
    for axis in (0, 1):
        for rows in found[axis]:
            line = _located(crossings[rows], axis, support, options)
            if line is None:
                return None
            lines.append(line)
    return tuple(lines)


def _clusters(crossings: Crossings, axis: int, n_lines: int) -> list[Index]:
    """Crossings of links along ``axis`` that lie at one level and cover the other axis."""
    mine = np.flatnonzero(crossings.axis == axis)
    if not mine.size:
        return []
    level = crossings.at[mine, axis]
    order = np.argsort(level, kind="stable")
    breaks = np.flatnonzero(np.diff(level[order]) > _WANDER) + 1
    clusters = []
    for group in np.split(order, breaks):
        rows = mine[group]
        middle = np.median(level[group])
        covered = np.unique(crossings.start[rows, 1 - axis]).size
        if np.abs(level[group] - middle).max() < _WANDER and covered >= _MIN_COVER * n_lines:
            clusters.append(np.sort(rows))
    return clusters


def _located(
    crossings: Crossings, axis: int, support: Support, options: SharpenOptions
) -> IsoLine | None:
    """Locate the edge at its one level, at every line of the grid that it crosses."""
    lattice = support.lattice
    at = _snapped(float(np.median(crossings.at[:, axis])))
    along = np.arange(support.side.shape[1 - axis])
    # Where a crossing is missing, the sides are those of the nearest one.
    known = crossings.start[:, 1 - axis]
    nearest = np.abs(along[:, None] - known[None, :]).argmin(axis=1)
    pair = crossings.sides[nearest]
    sites = np.empty((len(along), 2), dtype=np.int64)
    sites[:, axis], sites[:, 1 - axis] = round(at), along
    shape, course = support.fit(np.concatenate([sites, sites]), pair.T.ravel())
    k = len(along)
    first, other = np.arange(k), np.arange(k, 2 * k)
    before, after = shape[first], shape[other]
    lines = (lattice.u, lattice.v)
    uv = np.empty((k, 2))
    uv[:, axis] = np.interp(at, np.arange(len(lines[axis])), lines[axis])
    uv[:, 1 - axis] = lines[1 - axis]
    points, _, is_edge = meet((before, after), (course[first], course[other]), uv, options)
    if not is_edge.all():
        return None
    return IsoLine(axis, at, lines[1 - axis], points, before, after)


def _snapped(at: float, tolerance: float = 0.03) -> float:
    """A level close to a row or column is that one: no slivers."""
    return float(round(at)) if abs(at - round(at)) < tolerance else at
