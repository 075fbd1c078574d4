"""Signs of normals, smooth piece by smooth piece, by how much of them an indicator explains.

Along sharp edges neighbouring normals say little about each other's sign, and a spanning tree
that crosses one edge wrongly turns a whole face. But the normals of a whole closed surface are
a gradient, that of its indicator, and with wrong signs they are not: the Poisson indicator,
which takes up only the part of a field that is a gradient, falls less along them. As it is
linear in the normals, the share of every smooth piece is worked out once, and the best signs
of all pieces are a matter of one small matrix.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crispline.net.poisson import poisson_indicator
from crispline.surface.base import Array

CELL = 1.5
"""Cells of the grid on which indicators are compared, in spacings."""

_N_NEAR = 10
_MAX_TURN = np.cos(np.radians(15.0))  # between a point in the middle of a piece and those near it
_MIN_SHARE = 0.003  # of the points; smaller pieces follow the others
_MAX_PIECES = 24
# The areas of a closed surface, as vectors, add up to nothing but for this share of its area; a
# box that lacks a side has a fifth left.
_CLOSED = 0.1
_REACH = 1.5  # cells, to either side of the surface
_ROUNDING = 1e-9  # of the mean cosine of equal normals; one of a million that differs is more


def with_best_signs(
    points: Array,
    normals: Array,
    neighbours: NDArray[np.int64],
    areas: Array,
    threads: int = -1,
    known: list[Couplings] | None = None,
) -> Array:
    """Outward normals after choosing the sign of every smooth piece, shape ``(n, 3)``.

    The signs maximise the fall of the indicator across the surface. Points between the
    pieces then face down the indicator of these.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals, shape ``(n, 3)``; within a smooth piece of the surface they face
        one side.
    neighbours : nearest points, itself first, shape ``(n, >= 11)``.
    areas : surface area that each point stands for, shape ``(n,)``.
    known : what was worked out before, for the same points and areas; added to.

    Returns
    -------
    The normals as they are where there is only one piece.
    """
    piece = _pieces(normals, neighbours)
    if piece.max() < 1:
        return normals
    known = [] if known is None else known
    falls = next((f for k in known if (f := k.turned(normals, piece)) is not None), None)
    if falls is None:
        falls = _couplings(points, normals, areas, piece, threads)
        known.append(Couplings(normals, piece, falls))
    signs = _best_signs(falls)
    sign = np.where(piece >= 0, signs[np.maximum(piece, 0)], 0.0)
    indicator = poisson_indicator(points, sign[:, None] * normals, areas, CELL, threads=threads)
    reach = _REACH * indicator.cell * normals
    fall = indicator.at(points - reach) - indicator.at(points + reach)
    oriented = np.where(piece >= 0, sign, np.where(fall < 0.0, -1.0, 1.0))[:, None] * normals
    return -oriented if _is_inward(points, normals, oriented, areas) else oriented


@dataclass(frozen=True)
class Couplings:
    """What the smooth pieces of a cloud say of each other's signs.

    Attributes
    ----------
    normals, piece : that they belong to, shapes ``(n, 3)`` and ``(n,)``.
    falls : of the indicator along the normals of a piece by that of another, shape ``(k, k)``.
    """

    normals: Array
    piece: NDArray[np.int64]
    falls: Array

    def turned(self, normals: Array, piece: NDArray[np.int64]) -> Array | None:
        """The falls where whole pieces have turned round; None if not only these have.

        One spanning tree after the other finds the same normals but for their signs.
        """
        if not np.array_equal(piece, self.piece):
            return None
        inner = piece >= 0
        cosine = np.einsum("ni,ni->n", normals[inner], self.normals[inner])
        side = np.bincount(piece[inner], cosine) / np.bincount(piece[inner])
        if np.abs(side).min() < 1.0 - _ROUNDING:
            return None
        return np.asarray(np.sign(side)[:, None] * self.falls * np.sign(side))


def is_inside_out(points: Array, normals: Array, areas: Array) -> bool | None:
    """Whether normals look into a closed surface; None if it is open, which has no inside.

    By the divergence theorem the flux of the position is three times the enclosed volume.
    """
    if np.linalg.norm(areas @ normals) > _CLOSED * areas.sum():
        return None
    centred = points - points.mean(axis=0)
    return bool(np.sum(areas * np.einsum("ni,ni->n", centred, normals)) < 0.0)


def _is_inward(points: Array, given: Array, oriented: Array, areas: Array) -> bool:
    """Whether a closed surface is inside out; an open one, whether most normals were turned."""
    is_wrong = is_inside_out(points, oriented, areas)
    if is_wrong is None:
        return bool(np.sum(areas * np.einsum("ni,ni->n", given, oriented)) < 0.0)
    return is_wrong


def _pieces(normals: Array, neighbours: NDArray[np.int64]) -> NDArray[np.int64]:
    """Smooth piece of every point, largest first; -1 near edges and in crumbs, shape ``(n,)``."""
    n = len(normals)
    near = neighbours[:, 1 : _N_NEAR + 1]
    agreement = np.abs(np.einsum("ni,nki->nk", normals, normals[near]))
    is_inner = agreement.min(axis=1) > _MAX_TURN
    tail, head = np.repeat(np.arange(n), near.shape[1]), near.ravel()
    linked = is_inner[tail] & is_inner[head]
    links = coo_array((np.ones(int(linked.sum())), (tail[linked], head[linked])), shape=(n, n))
    component = connected_components(links, directed=False)[1]
    size = np.bincount(component[is_inner], minlength=component.max() + 1)
    order = np.lexsort((np.arange(len(size)), -size))[:_MAX_PIECES]
    number = np.full(len(size), -1, dtype=np.int64)
    kept = order[size[order] >= max(_MIN_SHARE * n, 1.0)]
    number[kept] = np.arange(len(kept))
    return np.where(is_inner, number[component], -1)


def _couplings(
    points: Array, normals: Array, areas: Array, piece: NDArray[np.int64], threads: int
) -> Array:
    """Fall of the indicator along the normals of a piece by that of another, shape ``(k, k)``.

    Summed over the points; ``s @ couplings @ s`` is that of all pieces with signs ``s``.
    """
    k = int(piece.max()) + 1
    inner = piece >= 0
    at, side = points[inner], normals[inner]
    couplings = np.empty((k, k))
    for index in range(k):
        alone = (piece == index)[:, None] * normals
        indicator = poisson_indicator(points, alone, areas, CELL, threads=threads)
        reach = _REACH * indicator.cell * side
        fall = indicator.at(at - reach) - indicator.at(at + reach)
        couplings[:, index] = np.bincount(piece[inner], fall, minlength=k)
    return couplings


def _best_signs(couplings: Array) -> Array:
    """Signs of largest fall that no flip of one or two pieces raises, shape ``(k,)``."""
    k = len(couplings)
    chosen = [*itertools.combinations(range(k), 1), *itertools.combinations(range(k), 2)]
    flips = np.ones((len(chosen), k))
    for flip, members in zip(flips, chosen, strict=True):
        flip[list(members)] = -1.0
    best = np.ones(k)
    most = float(best @ couplings @ best)
    while True:
        trials = flips * best
        fall = np.einsum("mi,ij,mj->m", trials, couplings, trials)
        row = int(np.argmax(fall))
        if not fall[row] > most * (1.0 + 1e-9):
            return best
        best, most = trials[row], float(fall[row])
