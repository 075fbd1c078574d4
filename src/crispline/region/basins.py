"""Basins between sharp bands: a watershed of the distance to the nearest crease."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from crispline.options import RegionOptions
from crispline.surface.base import Array

Labels = NDArray[np.int64]


def basins(
    centres: Array,
    normals: Array,
    pairs: NDArray[np.int64],
    is_sharp: NDArray[np.bool_],
    edge_length: float,
    options: RegionOptions,
) -> Labels:
    """Label the smooth basins of a net, shape ``(m,)``, labels 0, 1, ...

    The distance of every patch to the nearest sharp patch (or to a side across
    which the normals turn by more than ``options.cut_deg``) has a peak inside
    each face. Patches flow uphill to a peak; two peaks join unless the pass
    between them lies clearly below the lower one. A gap in a band is a low
    pass, so it does not leak.

    Parameters
    ----------
    centres, normals : of the patches, shape ``(m, 3)``.
    pairs : patches that share a side, shape ``(e, 2)``.
    is_sharp : shape ``(m,)``.
    edge_length : side of the patches.
    """
    m = len(centres)
    a, b = pairs.T
    turn = np.einsum("ij,ij->i", normals[a], normals[b])
    cut = turn < np.cos(np.radians(options.cut_deg))
    length = np.linalg.norm(centres[a] - centres[b], axis=1)
    height = _crease_distance(pairs, length, is_sharp, cut, m) / edge_length
    label = _flow_uphill(height, pairs[~cut], m)
    label = _join_over_high_passes(label, height, pairs[~cut], options)
    label = np.where(is_sharp, -1, label)
    size = np.bincount(label[label >= 0], minlength=m)
    label[(label >= 0) & (size[np.maximum(label, 0)] < options.min_patches)] = -1
    label = grow_into_gaps(label, pairs[~cut], centres, normals)
    label = grow_into_gaps(label, pairs, centres, normals)
    # A piece without a single smooth basin, such as a narrow strip, is one region.
    bare = label < 0
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(m, m))
    label[bare] = m + connected_components(links, directed=False)[1][bare]
    return consecutive(label)


def consecutive(label: Labels) -> Labels:
    """Renumber labels to 0, 1, ... in order of their value."""
    return np.unique(label, return_inverse=True)[1].reshape(label.shape)


def grow_into_gaps(
    label: Labels, pairs: NDArray[np.int64], centres: Array, normals: Array
) -> Labels:
    """Give unlabelled patches (-1) the label of the neighbour nearest in place and direction."""
    label = label.copy()
    tail, head = np.concatenate([pairs, pairs[:, ::-1]]).T
    turn = 1.0 - np.einsum("ij,ij->i", normals[tail], normals[head])
    cost = np.linalg.norm(centres[tail] - centres[head], axis=1) * (1.0 + 3.0 * turn)
    while True:
        front = np.flatnonzero((label[tail] < 0) & (label[head] >= 0))
        if len(front) == 0:
            return label
        order = front[np.lexsort((cost[front], tail[front]))]
        _, first = np.unique(tail[order], return_index=True)
        chosen = order[first]
        label[tail[chosen]] = label[head[chosen]]


def _crease_distance(
    pairs: NDArray[np.int64],
    length: Array,
    is_sharp: NDArray[np.bool_],
    cut: NDArray[np.bool_],
    m: int,
) -> Array:
    """Graph distance to the nearest sharp patch or cut side."""
    at_cut = np.zeros(m, dtype=bool)
    at_cut[pairs[cut].ravel()] = True
    source = np.flatnonzero(is_sharp | at_cut)
    if len(source) == 0:
        return np.full(m, np.inf)
    graph = csr_array((length, (pairs[:, 0], pairs[:, 1])), shape=(m, m))
    distance = np.asarray(dijkstra(graph, directed=False, indices=source, min_only=True))
    # Beside a cut, but not sharp itself: half a patch away from the crease.
    distance[at_cut & ~is_sharp] = 0.5 * float(np.median(length))
    return distance


def _flow_uphill(height: Array, pairs: NDArray[np.int64], m: int) -> Labels:
    """Each patch's peak by steepest ascent over sides; plateaus flow to the lowest index."""
    rank = np.empty(m, dtype=np.int64)
    rank[np.lexsort((-np.arange(m), height))] = np.arange(m)
    tail, head = np.concatenate([pairs, pairs[:, ::-1]]).T
    top = np.arange(m)
    best = rank.copy()
    np.maximum.at(best, tail, rank[head])
    by_rank = np.empty(m, dtype=np.int64)
    by_rank[rank] = np.arange(m)
    top = by_rank[best]
    while True:
        higher = top[top]
        if np.array_equal(higher, top):
            return top
        top = higher


def _join_over_high_passes(
    label: Labels, height: Array, pairs: NDArray[np.int64], options: RegionOptions
) -> Labels:
    """Join basins in order of falling passes while the lower peak rises little above the pass."""
    a, b = label[pairs[:, 0]], label[pairs[:, 1]]
    between = a != b
    low, high = np.minimum(a, b)[between], np.maximum(a, b)[between]
    crossing = np.minimum(height[pairs[between, 0]], height[pairs[between, 1]])
    order = np.lexsort((high, low, -crossing))
    parent = {int(peak): int(peak) for peak in np.unique(label)}

    def root(peak: int) -> int:
        while parent[peak] != peak:
            parent[peak] = parent[parent[peak]]
            peak = parent[peak]
        return peak

    seen: set[tuple[int, int]] = set()
    for i in order:
        if (low[i], high[i]) in seen:  # only the highest pass of a pair counts
            continue
        seen.add((low[i], high[i]))
        one, other = root(int(low[i])), root(int(high[i]))
        if one == other:
            continue
        lower, upper = sorted((one, other), key=lambda peak: (height[peak], -peak))
        limit = max(options.peak_floor, options.peak_share * height[lower])
        if not np.isfinite(crossing[i]) or height[lower] - crossing[i] < limit:
            parent[lower] = upper
    peaks = np.array([root(int(peak)) for peak in np.unique(label)])
    return peaks[np.searchsorted(np.unique(label), label)]
