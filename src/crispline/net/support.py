"""How well a cloud supports the surface over it: where it ends, and where it has gaps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree
from scipy.special import erf

from crispline.cloud.nearest import nearest
from crispline.surface.base import Array

MAX_GAP = 1.5
"""Farther than this from every point a place has no support, in local spacings."""

_N_NEIGHBOURS = 32
_WIDTH = 1.5  # of the Gaussian that looks for the end of the points, in local spacings
_SMOOTHING_ROUNDS = 6
_LIMIT = 3.0
_CHUNK = 50_000

# Points on a half plane, weighted with a Gaussian about a place at distance t (in
# standard deviations) inside its border, have their mean at phi(t) / Phi(t) inward
# of the place: a monotone function, inverted by this table.
_T = np.linspace(-8.0, 4.0, 1201)
_MEAN = np.exp(-0.5 * _T**2) / np.sqrt(2.0 * np.pi) / (0.5 * (1.0 + erf(_T / np.sqrt(2.0))))
_FAR = 16.0  # spacings; of places farther from every point ...
_CELL = 4.0  # ... one in every cell of this size is asked for its distance


@dataclass(frozen=True)
class Support:
    """What the cloud says of places on a surface, ``n`` of them.

    Attributes
    ----------
    inset : distance to the end of the points, positive inside, spacings, shape ``(n,)``;
        between -12 (nothing near) and 6 local spacings.
    inward : unit directions from the end of the points, shape ``(n, 3)``; zero if unknown.
    gap : distance to the nearest point, in local spacings, shape ``(n,)``.
    spacing : local spacing there, spacings, shape ``(n,)``.
    """

    inset: Array
    inward: Array
    gap: Array
    spacing: Array

    @property
    def value(self) -> Array:
        """Positive where the cloud supports the surface, in local spacings, shape ``(n,)``."""
        value = np.minimum(self.inset / self.spacing, MAX_GAP - self.gap)
        return np.asarray(np.clip(value, -_LIMIT, _LIMIT))


@dataclass(frozen=True)
class Coverage:
    """Where a surface should end.

    Attributes
    ----------
    value : positive where the surface stays, smooth over it, shape ``(n,)``.
    is_notch : places of bare stretches that end the surface, yet hang on it by a short
        border: a hole of that size is left where they are cut off, shape ``(n,)``.
    widths : of the gaps that are too wide to be filled, in local spacings, widest first.
    """

    value: Array
    is_notch: NDArray[np.bool_]
    widths: Array


def local_spacings(distances: Array) -> Array:
    """Spacing of the points round each, from its 8 to 16 nearest, shape ``(n,)``.

    Parameters
    ----------
    distances : sorted neighbour distances, the point itself first, shape ``(n, >= 17)``.
    """
    k = np.arange(8, 17)
    return np.asarray((distances[:, 8:17] * np.sqrt(np.pi / k)).mean(axis=1))


def support(
    places: Array, normals: Array, tree: cKDTree, local_spacing: Array, threads: int = -1
) -> Support:
    """Where the points end round places on the surface.

    Parameters
    ----------
    places, normals : on the surface, shape ``(n, 3)``, spacings.
    tree : search tree over the points.
    local_spacing : of the points; below 1 counts as 1, the resolution of the net.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    points = np.asarray(tree.data, dtype=np.float64)
    local_spacing = np.maximum(local_spacing, 1.0)
    k = min(_N_NEIGHBOURS, len(points))
    lift_off, closest = _closest(tree, places, threads)
    spacing = local_spacing[closest]
    gap = lift_off / spacing
    inset, inward = _T[0] * _WIDTH * spacing, np.zeros((len(places), 3))
    # Beyond that the gap alone decides, and many neighbours of far places take long to find.
    near = np.flatnonzero(gap < MAX_GAP + _LIMIT)
    for begin in range(0, len(near), _CHUNK):
        chunk = near[begin : begin + _CHUNK]
        distance, index = nearest(tree, places[chunk], k, threads)
        width = _WIDTH * spacing[chunk]
        weight = np.exp(-0.5 * (distance**2 - distance[:, :1] ** 2) / width[:, None] ** 2)
        offset = points[index] - places[chunk][:, None]
        lift = np.einsum("nki,ni->nk", offset, normals[chunk])
        offset = offset - lift[:, :, None] * normals[chunk][:, None]
        mean = np.einsum("nk,nki->ni", weight, offset) / weight.sum(axis=1)[:, None]
        length = np.linalg.norm(mean, axis=1)
        inward[chunk] = mean / np.where(length > 0.0, length, 1.0)[:, None]
        inset[chunk] = width * np.interp(length / width, _MEAN[::-1], _T[::-1])
    return Support(inset, inward, gap, spacing)


def _closest(tree: cKDTree, places: Array, threads: int) -> tuple[Array, NDArray[np.int64]]:
    """Distance and index of the point nearest to each place, about so far from all of them.

    In the middle of a lid all points round it are about as near, and a search that has to
    tell the nearest goes through every one. So there only some places are asked, and the
    others take what the nearest of these was told: distances of neighbours differ by no more
    than what lies between them.
    """
    distance, index = nearest(tree, places, 1, threads, within=_FAR)
    far = np.flatnonzero(np.isinf(distance[:, 0]))
    if len(far):
        cells = np.floor(places[far] / _CELL)
        asked = far[np.unique(cells, axis=0, return_index=True)[1]]
        away, closest = nearest(tree, places[asked], 1, threads)
        teller = nearest(cKDTree(places[asked]), places[far], 1, threads)[1][:, 0]
        distance[far], index[far] = away[teller], closest[teller]
    return distance[:, 0], index[:, 0]


def coverage(
    vertices: Array,
    links: csr_array,
    on_border: NDArray[np.bool_],
    found: Support,
    fill_holes: float,
) -> Coverage:
    """Decide which bare stretches of a surface are holes to be filled.

    Parameters
    ----------
    vertices : of the surface, which may run on over the ends of the cloud, shape ``(n, 3)``.
    links : symmetric 0/1 matrix of vertices that share a side, shape ``(n, n)``.
    on_border : vertices on a border of the surface, shape ``(n,)``.
    found : what the cloud says of the vertices.
    fill_holes : widest hole to fill, in local spacings.
    """
    value = _smoothed(links, found.value)
    is_bare = value <= 0.0
    pairs = links.tocoo()
    inside = is_bare[pairs.row] & is_bare[pairs.col]
    graph = csr_array(
        (np.ones(int(inside.sum())), (pairs.row[inside], pairs.col[inside])), shape=links.shape
    )
    n_gaps, member = connected_components(graph, directed=False)
    depth = np.zeros(n_gaps)
    np.maximum.at(depth, member[is_bare], found.gap[is_bare])
    is_gap = np.zeros(n_gaps, dtype=bool)
    is_gap[member[is_bare]] = True
    ends = np.zeros(n_gaps, dtype=bool)
    ends[member[on_border]] = True
    is_filled = is_gap & ~ends & (2.0 * depth <= fill_holes)
    across = is_bare[pairs.row] & ~is_bare[pairs.col]
    rim, gap = pairs.col[across], np.asarray(member[pairs.row[across]], dtype=np.int64)
    width = _widths(vertices[rim] / found.spacing[rim][:, None], gap, n_gaps)
    is_notch = is_gap & ~is_filled & (width <= fill_holes)
    value[is_bare & is_filled[member]] = 1.0
    return Coverage(
        value,
        is_bare & is_notch[member],
        np.sort(2.0 * depth[is_gap & ~is_filled & ~is_notch])[::-1],
    )


def _smoothed(links: csr_array, values: Array) -> Array:
    """Values averaged with the mean of their neighbours, a few rounds."""
    valence = np.maximum(np.asarray(links.sum(axis=1)).ravel(), 1.0)
    for _ in range(_SMOOTHING_ROUNDS):
        values = 0.5 * (values + links @ values / valence)
    return values


def _widths(places: Array, group: NDArray[np.int64], n_groups: int) -> Array:
    """Twice the largest distance of places from the middle of their group, ``(n_groups,)``."""
    count = np.maximum(np.bincount(group, minlength=n_groups), 1)
    middle = [np.bincount(group, column, minlength=n_groups) / count for column in places.T]
    away = np.linalg.norm(places - np.stack(middle, axis=1)[group], axis=1)
    widest = np.zeros(n_groups)
    np.maximum.at(widest, group, 2.0 * away)
    return widest
