"""Which side of a feature every point of the band is on, from where the sides meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from crispline.grid.localfit import Sides, Support
from crispline.surface.base import Array

Index = NDArray[np.int64]

N_CANDIDATES = 4
"""Sides that may meet near one point."""


@dataclass(frozen=True)
class Candidates:
    """The sides near some points, and the polynomials of each around the point.

    Attributes
    ----------
    sites : rows and columns of the points, shape ``(k, 2)``.
    names : up to four sides near each, nearest first, 0 for none, ``(k, 4)``.
    row : the row of ``shape`` and ``course`` that holds each, -1 for none, ``(k, 4)``.
    shape, course : see :meth:`crispline.grid.localfit.Support.fit`.
    middle : mean row and column of the supporting points, one for each fit.
    """

    sites: Index
    names: Index
    row: Index
    shape: Sides
    course: Sides


def candidates(support: Support, sites: Index, side: Index, reach: int) -> Candidates:
    """Fit, around every site, the sides that lie within ``reach`` points of it.

    Parameters
    ----------
    side : which side a point counts as for being near, shape ``(m, n)``.
    """
    names = _nearby(sites, side, reach)
    at, slot = np.nonzero(names)
    row = np.full(names.shape, -1, dtype=np.int64)
    row[at, slot] = np.arange(len(at))
    shape, course = support.fit(sites[at], names[at, slot])
    is_bad = ~np.isfinite(shape.coefficients).all(axis=(1, 2))
    names[at[is_bad], slot[is_bad]] = 0
    row[at[is_bad], slot[is_bad]] = -1
    return Candidates(sites, names, row, shape, course)


def _nearby(sites: Index, side: Index, reach: int) -> Index:
    """Up to four sides within ``reach`` points of each site, nearest first, ``(k, 4)``."""
    distance = np.full((len(sites), N_CANDIDATES), np.inf)
    names = np.zeros((len(sites), N_CANDIDATES), dtype=np.int64)
    for name, box in enumerate(ndimage.find_objects(side), start=1):
        if not box:  # no point has this number
            continue
        low = np.array([max(part.start - reach, 0) for part in box])
        high = np.array([part.stop + reach for part in box])
        near = np.flatnonzero(((sites >= low) & (sites < high)).all(axis=1))
        if not near.size:
            continue
        window = side[low[0] : high[0], low[1] : high[1]] == name
        away = ndimage.distance_transform_edt(~window)
        local = sites[near] - low
        is_inside = (local < window.shape).all(axis=1)
        near, local = near[is_inside], local[is_inside]
        d = away[local[:, 0], local[:, 1]]
        close = d <= reach
        near, d = near[close], d[close]
        for slot in range(N_CANDIDATES):
            # Insertion into the sorted list of each site.
            is_nearer = d < distance[near, slot]
            rows = near[is_nearer]
            names[rows, slot + 1 :] = names[rows, slot:-1]
            distance[rows, slot + 1 :] = distance[rows, slot:-1]
            names[rows, slot], distance[rows, slot] = name, d[is_nearer]
            near, d = near[~is_nearer], d[~is_nearer]
    return names


def depth(shape: tuple[Sides, Sides], course: tuple[Sides, Sides], uv: Array) -> Array:
    """How far inside the first of two sides each site lies, in cells, shape ``(k,)``.

    Positive on the first side. Both sides go on beyond the feature in the
    parameters of the grid; where the one reaches the surface of the other, it
    ends. The mean of the two answers has the noise of neither point there.

    Parameters
    ----------
    shape, course : the fits of the first and of the second side, one row a site.
    uv : parameters of the sites, shape ``(k, 2)``.
    """
    a, b = course
    pa, pa_u, pa_v = a.at(uv)
    pb, pb_u, pb_v = b.at(uv)
    na, nb = shape[0].normals(uv), shape[1].normals(uv)
    # Where the side truly lies, at the parameters of its course.
    pa = pa + _dot(shape[0].at(uv)[0] - pa, na)[:, None] * na
    pb = pb + _dot(shape[1].at(uv)[0] - pb, nb)[:, None] * nb
    apart = pa - pb
    towards = a.centre - b.centre

    def reach(normal: Array, du: Array, dv: Array) -> Array:
        height = _dot(apart, normal)
        slope = np.stack([_dot(du, normal), _dot(dv, normal)], axis=1)
        steep = np.linalg.norm(slope, axis=1)
        sign = np.sign(_dot(slope, towards))
        return np.asarray(sign * height / np.where(steep > 0.0, steep, np.inf))

    # What lies within the support of a side is surer than what lies beyond it.
    wa, wb = (np.maximum(np.abs(side.scaled(uv)).max(axis=1), 1.0) ** -6 for side in (a, b))
    total = wa * reach(nb, pa_u, pa_v) + wb * reach(na, -pb_u, -pb_v)
    return np.asarray(total / (wa + wb))


def assign(found: Candidates, support: Support) -> Index:
    """The side of every site, shape ``(k,)``; 0 where none is near.

    The one that wins all comparisons with the others near; else the nearest.
    """
    lattice = support.lattice
    i, j = found.sites.T
    uv = np.stack([lattice.u[i], lattice.v[j]], axis=1)
    worst = np.where(found.names > 0, np.inf, -np.inf)
    for one in range(N_CANDIDATES):
        for two in range(one + 1, N_CANDIDATES):
            both = np.flatnonzero((found.row[:, one] >= 0) & (found.row[:, two] >= 0))
            rows = found.row[both, one], found.row[both, two]
            d = depth(
                (found.shape[rows[0]], found.shape[rows[1]]),
                (found.course[rows[0]], found.course[rows[1]]),
                uv[both],
            )
            d = np.where(np.isfinite(d), d, 0.0)
            worst[both, one] = np.minimum(worst[both, one], d)
            worst[both, two] = np.minimum(worst[both, two], -d)
    # A side that takes more than half of the ground round a corner can lose a comparison
    # beyond the common edge; its points then have no winner, and are nearest to it.
    best = np.where(worst.max(axis=1) > 0.0, np.argmax(worst, axis=1), 0)
    return np.asarray(found.names[np.arange(len(best)), best])


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.einsum("ki,ki->k", a, b))
