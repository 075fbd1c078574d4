"""Make a labelling fit for a solid: one piece per label, no crumbs, no pinches."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from crispline.net.halfedge import HalfEdges

Labels = NDArray[np.int64]

_MAX_ROUNDS = 60


def tidy(label: Labels, quads: HalfEdges, min_patches: int, held: Collection[int] = ()) -> Labels:
    """Labels whose regions are connected, not tiny, and never meet themselves across a vertex.

    A label keeps its number on its largest piece; other pieces get new numbers. Those ``held``
    may be as small as they are.
    """
    label = _absorb_small(one_piece_per_label(label, quads), quads, min_patches, held)
    label = _unpinch(label, quads)
    return one_piece_per_label(_absorb_small(label, quads, min_patches, held), quads)


def pieces(label: Labels, quads: HalfEdges) -> Labels:
    """Connected pieces of equal label, numbered 0, 1, ..., shape ``(m,)``."""
    # One of each pair of half-edges will do; they stand row by row.
    once = np.flatnonzero(quads.twin > np.arange(len(quads.twin)))
    a, b = once // 4, quads.twin[once] // 4
    same = label[a] == label[b]
    m = len(label)
    starts = np.concatenate([[0], np.cumsum(np.bincount(a[same], minlength=m))])
    graph = csr_array((np.ones(int(same.sum())), b[same], starts), shape=(m, m))
    return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)


def one_piece_per_label(label: Labels, quads: HalfEdges) -> Labels:
    """Renumber all but the largest piece of every label."""
    piece = pieces(label, quads)
    size = np.bincount(piece)
    label_of = np.empty(len(size), dtype=np.int64)
    label_of[piece] = label
    order = np.lexsort((np.arange(len(size)), -size, label_of))
    repeats = np.zeros(len(size), dtype=bool)
    repeats[order[1:]] = label_of[order[1:]] == label_of[order[:-1]]
    label_of[repeats] = label.max() + 1 + np.arange(int(repeats.sum()))
    return label_of[piece]


def _absorb_small(
    label: Labels, quads: HalfEdges, min_patches: int, held: Collection[int]
) -> Labels:
    """Give every piece of fewer than ``min_patches`` to the neighbour with the longest border."""
    label = label.copy()
    neighbours = quads.neighbours()
    for _ in range(_MAX_ROUNDS):
        piece = pieces(label, quads)
        size = np.bincount(piece)
        is_held = np.zeros(len(size), dtype=bool)
        is_held[piece[np.isin(label, list(held))]] = True
        small = np.flatnonzero((size < min_patches) & ~is_held)
        if len(small) == 0 or len(size) == len(small) == 1:
            break
        members = np.flatnonzero(np.isin(piece, small))
        groups = np.split(
            members[np.argsort(piece[members], kind="stable")], np.cumsum(size[small])[:-1]
        )
        # Smallest first; a group whose surroundings changed this round waits for the next.
        changed = np.zeros(len(label), dtype=bool)
        for index in np.argsort(size[small], kind="stable"):
            group = groups[index]
            beyond = neighbours[group].ravel()
            beyond = beyond[beyond >= 0]
            beyond = beyond[piece[beyond] != piece[group[0]]]
            if len(beyond) == 0 or changed[beyond].any():
                continue
            candidates, votes = np.unique(label[beyond], return_counts=True)
            label[group] = candidates[np.argmax(votes)]
            changed[group] = True
        if not changed.any():
            break
    return label


def _unpinch(label: Labels, quads: HalfEdges) -> Labels:
    """Relabel a patch or two wherever one region meets itself across a vertex."""
    label = label.copy()
    corner_of = np.argsort(quads.origin, kind="stable")
    first = np.searchsorted(quads.origin[corner_of], np.arange(quads.n_vertices + 1))
    following = quads.next
    for attempt in range(_MAX_ROUNDS):
        left = label[quads.quad]
        right = np.where(quads.twin >= 0, left[np.maximum(quads.twin, 0)], -1)
        crossing = np.bincount(quads.origin[left != right], minlength=quads.n_vertices)
        changed = False
        for vertex in np.flatnonzero(crossing >= 4):
            ring = _ring(int(corner_of[first[vertex]]), quads, following)
            if ring is None:
                continue
            changed |= _mend(label, ring, prefer_previous=attempt % 2 == 0)
        if not changed:
            break
    return label


def _ring(start: int, quads: HalfEdges, following: NDArray[np.int64]) -> list[int] | None:
    """Quads about the origin of a half-edge, in order; None on an open border."""
    ring, half_edge = [], start
    while True:
        ring.append(half_edge // 4)
        twin = int(quads.twin[half_edge])
        if twin < 0:
            return None
        half_edge = int(following[twin])
        if half_edge == start:
            return ring


def _mend(label: Labels, ring: list[int], prefer_previous: bool) -> bool:
    """Relabel the shortest run of a label that occurs twice round the vertex."""
    n = len(ring)
    breaks = [i for i in range(n) if label[ring[i]] != label[ring[i - 1]]]
    if len(breaks) < 4:
        return False
    runs = [
        [ring[j % n] for j in range(begin, end if end > begin else end + n)]
        for begin, end in zip(breaks, breaks[1:] + breaks[:1], strict=True)
    ]
    names = [int(label[run[0]]) for run in runs]
    repeated = [i for i, name in enumerate(names) if names.count(name) > 1]
    if not repeated:
        return False
    shortest = min(repeated, key=lambda i: len(runs[i]))
    beside = shortest - 1 if prefer_previous else (shortest + 1) % len(runs)
    label[runs[shortest]] = names[beside]
    return True
