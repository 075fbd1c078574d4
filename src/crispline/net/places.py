"""Small places that a spanning tree has turned the wrong way round.

Half the wall of a narrow bore is a thousandth of a cloud: the indicator scatters no more for it.
But where neighbours face opposite ways it falls less across the surface than anywhere else. There,
other trees propose other signs, and those stay by which it falls the most. The share of a place in
its own fall is a sum of dipoles, smoothed as on the grid; the rest is that of all other points.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.special import erf

from crispline.cloud.nearest import nearest
from crispline.cloud.normals import orient_by_spanning_tree, principal_normals
from crispline.cloud.scale import N_NEIGHBOURS
from crispline.cloud.working import WorkingCloud
from crispline.net.poisson import point_areas, poisson_indicator
from crispline.net.sheets import FINE_CELL
from crispline.surface.base import Array

Index = NDArray[np.int64]

_WEAK = 0.5  # of the median fall
_N_NEAR = 8
_MIN_WEAK = 3  # of so many neighbours: fewer are single bad normals, beside sharp edges
_REACH = 3.0  # a place goes on so far from what is weak, spacings
_LINK = 2.0
_SIZES = (20, 1500)  # of a place; thin walls all over a part are a larger one, and hopeless
_MARGIN = 4.0  # of known signs round a place, spacings
_BENDING = (2.0, 1.0)
_OFFSET = (0.25, 1.0)
_BETTER = 1.08  # single normals beside an edge bring up to 1.05, half a bore 1.13 and more
# Laying points onto the grid and reading it off widen its Gaussian, each by the variance of a hat.
_WIDENING = np.sqrt(1.0 + 2.0 / 6.0)


def with_places_turned(
    cloud: WorkingCloud, normals: Array, sizes: tuple[int, ...], threads: int = -1
) -> Array:
    """The normals with other signs where they explain the points better, shape ``(n, 3)``.

    Parameters
    ----------
    cloud : ``n`` points.
    normals : outward unit normals, nearly all of the right sign, shape ``(n, 3)``.
    sizes : neighbourhoods of the normals whose spanning trees propose signs.
    threads : threads for queries and transforms; the result does not depend on it.
    """
    areas = point_areas(cloud.distances)
    indicator = poisson_indicator(cloud.points, normals, areas, FINE_CELL, threads=threads)
    step = indicator.cell * normals
    fall = indicator.at(cloud.points - step) - indicator.at(cloud.points + step)
    turned = normals.copy()
    for place in _places(cloud, fall):
        gain = _gain(cloud.points, normals, areas, fall, place, indicator.cell)
        best, most = np.ones(len(place)), _BETTER * gain(np.ones(len(place)))
        for signs in _proposals(cloud, normals, place, sizes):
            if (found := gain(signs)) > most:
                best, most = signs, found
        turned[place] *= best[:, None]
    return turned


def _places(cloud: WorkingCloud, fall: Array) -> list[Index]:
    """Points of each place where the indicator falls little, with those round it."""
    is_weak = fall < _WEAK * np.median(fall)
    is_weak &= is_weak[cloud.neighbours[:, 1 : _N_NEAR + 1]].sum(axis=1) >= _MIN_WEAK
    if not is_weak.any():
        return []
    distance, _ = cKDTree(cloud.points[is_weak]).query(cloud.points, distance_upper_bound=_REACH)
    near = np.flatnonzero(np.isfinite(distance))
    pairs = cKDTree(cloud.points[near]).query_pairs(_LINK, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(near), len(near)))
    n_places, place = connected_components(links, directed=False)
    found = [near[place == index] for index in range(n_places)]
    return [place for place in found if _SIZES[0] <= len(place) <= _SIZES[1]]


def _proposals(
    cloud: WorkingCloud, normals: Array, place: Index, sizes: tuple[int, ...]
) -> Iterator[Array]:
    """Signs for the normals of a place by trees over it that agree with what is round it."""
    reach, _ = cKDTree(cloud.points[place]).query(cloud.points, distance_upper_bound=_MARGIN)
    near = np.flatnonzero(np.isfinite(reach))
    is_inner = np.isin(near, place)
    points = cloud.points[near]
    _, around = nearest(cKDTree(points), points, min(N_NEIGHBOURS, len(near)), 1)
    for size in sizes:
        found = principal_normals(points, around, size)
        for bending, offset_weight in itertools.product(_BENDING, _OFFSET):
            oriented = orient_by_spanning_tree(points, found, around, bending, offset_weight)
            cosine = np.einsum("ni,ni->n", oriented, normals[near])
            side = -1.0 if cosine[~is_inner].sum() < 0.0 else 1.0
            yield np.where(side * cosine[is_inner] < 0.0, -1.0, 1.0)


def _gain(
    points: Array, normals: Array, areas: Array, fall: Array, place: Index, cell: float
) -> Callable[[Array], float]:
    """The fall of the indicator over a place, by the signs of its normals."""
    points, facing, area = points[place], normals[place], areas[place]
    step = cell * facing
    width = _WIDENING * cell
    among = _dipoles(points - step, points, facing, width)
    among = (among - _dipoles(points + step, points, facing, width)) * area * area[:, None]
    beyond = area * fall[place] - among.sum(axis=1)
    return lambda signs: float(signs @ among @ signs + 2.0 * beyond @ signs)


def _dipoles(places: Array, points: Array, normals: Array, width: float) -> Array:
    """The indicator at places by points of unit area, shape ``(m, n)``.

    The potential of a dipole, ``x . n / 4 pi |x|^3``, smoothed by a Gaussian.
    """
    away = points - places[:, None]
    distance = np.linalg.norm(away, axis=2)
    u = np.maximum(distance / width, 1e-2)
    share = erf(u / np.sqrt(2.0)) - np.sqrt(2.0 / np.pi) * u * np.exp(-0.5 * u**2)
    along = np.einsum("mni,ni->mn", away, normals)
    return np.asarray(along * share / (4.0 * np.pi * (width * u) ** 3))
