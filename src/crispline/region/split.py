"""Split smooth regions into patches of one surface each.

In a filleted part most of the area is one tangent-continuous region: what ends
one face and begins the next is not a crease but another surface.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from crispline.fit.choose import PRIMITIVE_FITS, choose_surface
from crispline.fit.robust import thinned
from crispline.net.graph import components
from crispline.options import FitOptions, RegionOptions
from crispline.region.basins import grow_into_gaps
from crispline.region.patches import Labels, PatchGraph
from crispline.surface import Surface
from crispline.surface.base import Array

_N_FIT = 250
_GROWN_KINDS = ("plane", "cylinder", "cone", "sphere")  # tori come out of what is left
_GROWTH_STEPS = 6
_INNER_SHARE = 0.4
_REACH = 3.0  # patches as many sigmas from a primitive are its own
_CLEARLY_MORE = 1.05
_SHARED = 0.3  # planes that share more patches are one


def split_into_surfaces(
    label: Labels,
    graph: PatchGraph,
    is_sharp: NDArray[np.bool_],
    noise: Array,
    options: RegionOptions,
    fit_options: FitOptions,
    only: Collection[int] | None = None,
) -> Labels:
    """Labels after splitting every region that no primitive explains, shape ``(m,)``.

    A region is kept whole if one primitive passes on it. Otherwise primitives
    are grown from seeds, largest clearance first; what is left over in pieces
    of ``options.min_free_patches`` or more stays together as free form, the
    rest goes to its neighbours.

    Parameters
    ----------
    noise : of the patch centres (smaller than that of the points), shape ``(m,)``, spacings.
    only : regions to look at; the others stay whole.
    """
    near_crease = graph.rings(is_sharp, 1)
    new = label.copy()
    fresh = int(label.max()) + 1
    for region in np.unique(label).tolist() if only is None else sorted(only):
        members = np.flatnonzero(label == region)
        sigma = float(np.median(noise[members]))
        inner = _inner(members, near_crease, is_sharp, options.min_patches)
        if len(inner) < options.min_patches or _is_one_primitive(inner, graph, sigma, fit_options):
            continue
        parts = _grown_primitives(members, inner, graph, sigma, options)
        rest = np.zeros(len(label), dtype=bool)
        rest[members] = True
        for part in parts:
            rest[part] = False
        new[rest] = -1
        piece = components(graph.adjacency, rest)
        names, sizes = np.unique(piece[rest], return_counts=True)
        parts += [
            np.flatnonzero(rest & (piece == name))
            for name, size in zip(names, sizes, strict=True)
            if size >= options.min_free_patches or (not parts and size == sizes.max())
        ]
        for part in parts:
            new[part] = fresh
            fresh += 1
    within = label[graph.pairs[:, 0]] == label[graph.pairs[:, 1]]
    new = grow_into_gaps(new, graph.pairs[within], graph.points, graph.normals)
    return grow_into_gaps(new, graph.pairs, graph.points, graph.normals)


def _inner(
    members: NDArray[np.int64],
    near_crease: NDArray[np.bool_],
    is_sharp: NDArray[np.bool_],
    enough: int,
) -> NDArray[np.int64]:
    """The members farthest from creases that are enough to judge a region by.

    They are at least ``_INNER_SHARE`` of it: among narrow faces, what lies clear of
    every crease may be one face of several.
    """
    for excluded in (near_crease, is_sharp):
        inner = members[~excluded[members]]
        if len(inner) >= max(enough, _INNER_SHARE * len(members)):
            return inner
    return members


def _is_one_primitive(
    inner: NDArray[np.int64], graph: PatchGraph, sigma: float, options: FitOptions
) -> bool:
    sample = inner[thinned(len(inner), 2 * _N_FIT)]
    fit = choose_surface(
        graph.points[sample], graph.normals[sample], sigma, options, tuple(PRIMITIVE_FITS)
    )
    return fit.is_accepted


def _grown_primitives(
    members: NDArray[np.int64],
    inner: NDArray[np.int64],
    graph: PatchGraph,
    sigma: float,
    options: RegionOptions,
) -> list[NDArray[np.int64]]:
    """Patches of the primitives found by growing seeds within ``members``, largest seeds first."""
    local = csr_array(graph.adjacency[members][:, members])
    points, normals = graph.points[members], graph.normals[members]
    free = np.ones(len(members), dtype=bool)
    may_seed = np.isin(members, inner)
    parts: list[NDArray[np.int64]] = []
    while True:
        seed = _clearest(local, free, may_seed & free)
        if seed is None:
            return [members[part] for part in parts]
        start = _ball(local, free, seed, options.seed_patches)
        best: NDArray[np.int64] | None = None
        most, is_bent = 0.0, False
        if len(start) >= options.min_patches:
            for kind in _GROWN_KINDS:
                found = _grow(kind, start, points, normals, local, free, sigma, options)
                if found is not None and found[1] > _CLEARLY_MORE * most:
                    best, most = found
                    is_bent = kind != "plane"
        if best is not None and is_bent:
            # The middle of two planes is their edge: what is seeded there spans both.
            flat, worth = _two_planes(best, points, normals, local, free, sigma, options)
            best = flat if worth > _CLEARLY_MORE * most else best
        if best is None or len(best) < options.min_free_patches:
            may_seed[start] = False
            may_seed[seed] = False
            continue
        parts.append(best)
        free[best] = False


def _clearest(local: csr_array, free: NDArray[np.bool_], may_seed: NDArray[np.bool_]) -> int | None:
    """The seed patch farthest from everything taken; None if no patch may seed."""
    if not may_seed.any():
        return None
    degree = np.asarray(local @ free.astype(np.float64))
    border = np.flatnonzero(~free | (free & (degree < 4)))
    if len(border) == 0:
        return int(np.flatnonzero(may_seed)[0])
    clearance = np.asarray(dijkstra(local, indices=border, min_only=True, unweighted=True))
    return int(np.argmax(np.where(may_seed, clearance, -1.0)))


def _two_planes(
    bent: NDArray[np.int64],
    points: Array,
    normals: Array,
    local: csr_array,
    free: NDArray[np.bool_],
    sigma: float,
    options: RegionOptions,
) -> tuple[NDArray[np.int64] | None, float]:
    """The better of two planes seeded aside of the middle of a curved surface, and their worth."""
    planes = []
    for aside in _quarters(points, bent):
        start = _ball(local, free, aside, options.seed_patches)
        found = _grow("plane", start, points, normals, local, free, sigma, options)
        if found is not None:
            planes.append(found)
    planes.sort(key=lambda found: -found[1])
    for patches, worth in planes[1:]:
        shared = np.isin(patches, planes[0][0]).mean()
        if shared < _SHARED:
            return planes[0][0], planes[0][1] + (1.0 - float(shared)) * worth
    return planes[0] if planes else (None, 0.0)


def _quarters(points: Array, members: NDArray[np.int64]) -> list[int]:
    """The member in the middle of each quarter of a region, cut across its principal axes."""
    centred = points[members] - points[members].mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    side = (centred @ axes[:2].T > 0.0) @ [1, 2]
    middles = [centred[side == k].mean(axis=0) for k in np.unique(side)]
    return [int(members[np.argmin(np.linalg.norm(centred - m, axis=1))]) for m in middles]


def _ball(local: csr_array, free: NDArray[np.bool_], seed: int, size: int) -> NDArray[np.int64]:
    """The ``size`` free patches that are nearest to the seed over sides."""
    ids = np.flatnonzero(free)
    order = breadth_first_order(
        local[ids][:, ids], int(np.searchsorted(ids, seed)), return_predecessors=False
    )
    return np.asarray(ids[order[:size]], dtype=np.int64)


def _grow(
    kind: str,
    start: NDArray[np.int64],
    points: Array,
    normals: Array,
    local: csr_array,
    free: NDArray[np.bool_],
    sigma: float,
    options: RegionOptions,
) -> tuple[NDArray[np.int64], float] | None:
    """Patches connected to the seed near a primitive, refitted as it grows, and their worth.

    A patch counts the less the farther it lies from the primitive: a wide cylinder spans
    two planes that meet at a few degrees, and has more patches than either, but not on it
    (MSAC: Torr and Zisserman 2000).
    """
    current = start
    surface: Surface | None = None
    worth = 0.0
    for _ in range(_GROWTH_STEPS):
        sample = current[thinned(len(current), _N_FIT)]
        surface = PRIMITIVE_FITS[kind](points[sample], normals[sample], sigma, None, True)
        if surface is None:
            return None
        feet, directions = surface.project(points)
        residual = np.einsum("ij,ij->i", points - feet, directions) / (_REACH * sigma)
        turn = np.einsum("ij,ij->i", normals, directions)
        turn *= np.sign(turn[start].sum()) or 1.0
        close = free & (np.abs(residual) < 1.0)
        close &= turn > np.cos(np.radians(options.grow_deg))
        if close[start].mean() < 0.8:
            return None
        piece = components(local, close)
        names, votes = np.unique(piece[start[close[start]]], return_counts=True)
        grown = np.flatnonzero(close & (piece == names[np.argmax(votes)]))
        worth = float(np.sum(1.0 - np.square(residual[grown])))
        if len(grown) <= 1.02 * len(current):
            return grown, worth
        current = grown
    return current, worth
