"""Split smooth regions into patches of one surface each.

In a filleted part most of the area is one tangent-continuous region: what ends
one face and begins the next is not a crease but another surface.
"""

from __future__ import annotations

from collections.abc import Collection
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, dijkstra

from crispline.fit.choose import PRIMITIVE_FITS, choose_surface
from crispline.fit.dominant import plane_of_most
from crispline.fit.residual import rms_limit
from crispline.fit.robust import thinned
from crispline.net.graph import components
from crispline.options import FitOptions, RegionOptions
from crispline.region.basins import grow_into_gaps
from crispline.region.grow import N_FIT, Ground, Growth
from crispline.region.patches import Labels, PatchGraph
from crispline.surface.base import Array

_GROWN_KINDS = ("plane", "cylinder", "cone", "sphere")  # tori come out of what is left
_GROWTH_STEPS = 6
_KEPT = 0.8  # share of its seeds that a primitive must explain
_INNER_SHARE = 0.4
_CLEARLY_MORE = 1.05
_SHARED = 0.3  # planes that share more patches are one


class Split(NamedTuple):
    """What became of the regions.

    Attributes
    ----------
    label : region of every patch, shape ``(m,)``.
    is_sculpture : whether the smooth regions are free forms, which were left as they are.
    """

    label: Labels
    is_sculpture: bool


def split_into_surfaces(
    label: Labels,
    graph: PatchGraph,
    is_sharp: NDArray[np.bool_],
    noise: Array,
    options: RegionOptions,
    fit_options: FitOptions,
    only: Collection[int] | None = None,
) -> Split:
    """Split every region that no primitive explains.

    A region is kept whole if one primitive passes on it. Otherwise primitives
    are grown from seeds, largest clearance first; what is left over in pieces
    of ``options.min_free_patches`` or more stays together as free form, the
    rest goes to its neighbours. Where the largest regions fall into crumbs, none is split:
    a sculpture is made of free forms.

    Parameters
    ----------
    noise : of the patch centres (smaller than that of the points), shape ``(m,)``, spacings.
    only : regions to look at; the others stay whole.
    """
    near_crease = graph.rings(is_sharp, 1)
    regions = np.unique(label) if only is None else np.array(sorted(only), dtype=np.int64)
    size = np.bincount(label)[regions]
    found: dict[int, list[NDArray[np.int64]]] = {}
    n_seen = n_in_faces = n_crumbs = 0
    for region in regions[np.argsort(-size, kind="stable")].tolist():
        members = np.flatnonzero(label == region)
        sigma = float(np.median(noise[members]))
        inner = _inner(members, near_crease, is_sharp, options.min_patches)
        n_seen += len(members)
        if len(inner) < options.min_patches or _is_one_primitive(inner, graph, sigma, fit_options):
            n_in_faces += len(members)
            continue
        found[region] = _grown_primitives(members, inner, graph, sigma, options)
        faces = [len(part) for part in found[region] if len(part) >= options.crumb_patches]
        n_in_faces += sum(faces)
        n_crumbs += len(found[region]) - len(faces)
        is_loose = n_seen - n_in_faces > options.max_loose * n_seen
        if only is None and n_crumbs >= options.many_crumbs and is_loose:
            return Split(label, is_sculpture=True)
    new = label.copy()
    fresh = int(label.max()) + 1
    for region, parts in sorted(found.items()):
        rest = label == region
        for part in parts:
            rest[part] = False
        new[rest] = -1
        piece = components(graph.adjacency, rest)
        names, sizes = np.unique(piece[rest], return_counts=True)
        pieces = [
            np.flatnonzero(rest & (piece == name))
            for name, n in zip(names, sizes, strict=True)
            if n >= options.min_free_patches or (not parts and n == sizes.max())
        ]
        for part in (*parts, *pieces):
            new[part] = fresh
            fresh += 1
    within = label[graph.pairs[:, 0]] == label[graph.pairs[:, 1]]
    new = grow_into_gaps(new, graph.pairs[within], graph.points, graph.normals)
    new = grow_into_gaps(new, graph.pairs, graph.points, graph.normals)
    return Split(new, is_sculpture=False)


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
    sample = inner[thinned(len(inner), 2 * N_FIT)]
    fit = choose_surface(
        graph.points[sample], graph.normals[sample], sigma, options, tuple(PRIMITIVE_FITS)
    )
    # A plane that most of it lies on leaves the rest to be found.
    return fit.is_accepted and fit.rms < rms_limit(sigma, options)


def _grown_primitives(
    members: NDArray[np.int64],
    inner: NDArray[np.int64],
    graph: PatchGraph,
    sigma: float,
    options: RegionOptions,
) -> list[NDArray[np.int64]]:
    """Patches of the primitives found by growing seeds within ``members``, largest seeds first.

    As the widest places come first, faces are found early if there are any: where only
    crumbs were found on most of the region, it is left as it is.
    """
    ground = Ground(
        graph.points[members],
        graph.normals[members],
        csr_array(graph.adjacency[members][:, members]),
        np.ones(len(members), dtype=bool),
        sigma,
        float(np.cos(np.radians(options.grow_deg))),
        _KEPT,
        _GROWTH_STEPS,
    )
    may_seed = np.isin(members, inner)
    parts: list[NDArray[np.int64]] = []
    n_crumbs = 0
    while n_crumbs < options.many_crumbs or 2 * np.count_nonzero(ground.is_free) < len(members):
        seed = _clearest(ground, may_seed & ground.is_free)
        if seed is None:
            break
        start = _ball(ground, seed, options.seed_patches)
        best: NDArray[np.int64] | None = None
        most, is_bent = 0.0, False
        if len(start) >= options.min_patches:
            for kind in _GROWN_KINDS:
                found = ground.grown(PRIMITIVE_FITS[kind], start)
                if found is None or found.worth <= _CLEARLY_MORE * most:
                    continue
                if kind == "plane" or not _is_plane_at_heart(found, ground):
                    best, most = found.patches, found.worth
                    is_bent = kind != "plane"
        if best is not None and is_bent:
            # The middle of two planes is their edge: what is seeded there spans both.
            flat, worth = _two_planes(best, ground, options.seed_patches)
            if worth > _CLEARLY_MORE * most:
                best, is_bent = flat, False
        n_crumbs += best is None or (is_bent and len(best) < options.crumb_patches)
        if best is None or len(best) < options.min_free_patches:
            may_seed[start] = False
            may_seed[seed] = False
            continue
        parts.append(best)
        ground = ground.without(best)
    return [members[part] for part in parts]


def _is_plane_at_heart(grown: Growth, ground: Ground) -> bool:
    points, normals = ground.points[grown.patches], ground.normals[grown.patches]
    return plane_of_most(points, normals, grown.surface, ground.sigma) is not None


def _clearest(ground: Ground, may_seed: NDArray[np.bool_]) -> int | None:
    """The seed patch farthest from everything taken; None if no patch may seed."""
    local, free = ground.adjacency, ground.is_free
    if not may_seed.any():
        return None
    degree = np.asarray(local @ free.astype(np.float64))
    border = np.flatnonzero(~free | (free & (degree < 4)))
    if len(border) == 0:
        return int(np.flatnonzero(may_seed)[0])
    clearance = np.asarray(dijkstra(local, indices=border, min_only=True, unweighted=True))
    return int(np.argmax(np.where(may_seed, clearance, -1.0)))


def _two_planes(
    bent: NDArray[np.int64], ground: Ground, n_seeds: int
) -> tuple[NDArray[np.int64] | None, float]:
    """The better of two planes seeded aside of the middle of a curved surface, and their worth."""
    starts = [_ball(ground, aside, n_seeds) for aside in _quarters(ground.points, bent)]
    grown = [ground.grown(PRIMITIVE_FITS["plane"], start) for start in starts]
    planes = sorted((found for found in grown if found is not None), key=lambda found: -found.worth)
    for other in planes[1:]:
        shared = float(np.isin(other.patches, planes[0].patches).mean())
        if shared < _SHARED:
            return planes[0].patches, planes[0].worth + (1.0 - shared) * other.worth
    return (planes[0].patches, planes[0].worth) if planes else (None, 0.0)


def _quarters(points: Array, members: NDArray[np.int64]) -> list[int]:
    """The member in the middle of each quarter of a region, cut across its principal axes."""
    centred = points[members] - points[members].mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    side = (centred @ axes[:2].T > 0.0) @ [1, 2]
    middles = [centred[side == k].mean(axis=0) for k in np.unique(side)]
    return [int(members[np.argmin(np.linalg.norm(centred - m, axis=1))]) for m in middles]


def _ball(ground: Ground, seed: int, size: int) -> NDArray[np.int64]:
    """The ``size`` free patches that are nearest to the seed over sides."""
    ids = np.flatnonzero(ground.is_free)
    order = breadth_first_order(
        ground.adjacency[ids][:, ids], int(np.searchsorted(ids, seed)), return_predecessors=False
    )
    return np.asarray(ids[order[:size]], dtype=np.int64)
