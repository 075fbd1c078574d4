"""Pieces of one narrow face, with gaps where the faces on its two sides touch.

Where a face is two patches wide, noise cuts it: the pieces no longer share a border, so nothing
asks whether they are one. But they stand between the same two faces, and one plane explains
them. Others touch, each with what a few points tell, until all borders have come to rest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from crispline.fit.jointly import fit_jointly
from crispline.net.graph import components
from crispline.options import FitOptions, RegionOptions
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Plane, Surface
from crispline.surface.base import Array

_SAME_WAY = np.cos(np.radians(20.0))  # between the normals of pieces of one plane
_KINDS = ("plane", "cylinder", "cone")
_BESIDE = 0.5  # share of a piece's border that is with the two faces

Fits = Mapping[int, RegionFit]


def joined_strips(
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
    fit_options: FitOptions,
) -> Labels:
    """Labels after joining small pieces of one face, and closing the gaps between those of a plane.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    graph, label = evidence.graph, label.copy()
    for group in _touching(label, fits, evidence, options, fit_options):
        label[np.isin(label, group)] = group[0]
    for pair, pieces in _strips(label, fits, evidence, options):
        touching = (np.sort(label[graph.pairs], axis=1) == pair).all(axis=1)
        gap = np.zeros(len(label), dtype=bool)
        gap[graph.pairs[touching].ravel()] = True
        own = [np.abs(fits[face].surface.signed_distance(graph.points)) for face in pair]
        off = np.where(label == pair[0], *own)  # of patches from the face they were given to
        name = {piece: piece for piece in pieces}
        for first, second in combinations(pieces, 2):
            plane = _common_surface([fits[first], fits[second]], evidence, fit_options)
            if plane is None:
                continue
            miss = np.abs(plane.signed_distance(graph.points))
            near = gap & (miss < options.ring_gap)
            bridge = _bridge(near, off - miss, label, (name[first], name[second]), graph)
            if bridge is not None:
                kept, gone = name[first], name[second]
                label[bridge | (label == gone)] = kept
                name = {piece: kept if old == gone else old for piece, old in name.items()}
                gap &= ~bridge
    return label


def _bridge(
    near: NDArray[np.bool_],
    gain: Array,
    label: Labels,
    pieces: tuple[int, int],
    graph: PatchGraph,
) -> NDArray[np.bool_] | None:
    """Patches in the gaps between two pieces, none where these touch; None if nothing does.

    Along an edge of the two faces the patches lie on these: on the whole they must ``gain``.
    """
    first, second = (label == piece for piece in pieces)
    beside_first, beside_second = graph.rings(first, 1), graph.rings(second, 1)
    stretch = components(graph.adjacency, near)
    bridge = np.zeros(len(label), dtype=bool)
    for part in np.intersect1d(stretch[near & beside_first], stretch[near & beside_second]):
        own = near & (stretch == part)
        if gain[own].mean() > 0.0:
            bridge |= own
    return bridge if bridge.any() or (beside_first & second).any() else None


def _strips(
    label: Labels, fits: Fits, evidence: Evidence, options: RegionOptions
) -> Iterator[tuple[tuple[int, int], list[int]]]:
    """Small planes by the two faces that they stand between; only where there are several."""
    ends = np.sort(label[evidence.graph.pairs], axis=1)
    borders, lengths = np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0, return_counts=True)
    names, sizes = np.unique(label, return_counts=True)
    between: dict[tuple[int, int], list[int]] = {}
    for region in names[sizes <= options.max_pruned_patches].tolist():
        own = (borders == region).any(axis=1)
        if not isinstance(fits[region].surface, Plane) or np.count_nonzero(own) < 2:
            continue
        beside, sides = borders[own].sum(axis=1) - region, lengths[own]
        longest = np.argsort(-sides, kind="stable")[:2]
        if sides[longest].sum() > _BESIDE * sides.sum():
            low, high = sorted(beside[longest].tolist())
            between.setdefault((low, high), []).append(region)
    for pair, pieces in sorted(between.items()):
        if len(pieces) > 1:
            yield pair, pieces


def _touching(
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
    fit_options: FitOptions,
) -> Iterator[list[int]]:
    """Faces that go on into each other, however short their border, as one surface explains all.

    One of two at least is small: so are the pieces of the rim of a thin wall that turns corners.
    """
    ends = np.sort(label[evidence.graph.pairs], axis=1)
    size = np.bincount(label)
    groups: list[list[int]] = []
    for first, second in np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0).tolist():
        if min(size[first], size[second]) > options.max_pruned_patches:
            continue
        merging = [group for group in groups if first in group or second in group]
        names = sorted({first, second}.union(*merging))
        if _common_surface([fits[name] for name in names], evidence, fit_options) is not None:
            groups = [group for group in groups if group not in merging]
            groups.append(names)
    yield from groups


def _common_surface(
    pieces: Sequence[RegionFit], evidence: Evidence, options: FitOptions
) -> Surface | None:
    """What explains faces of one kind, on the same side of it; None if nothing does."""
    kind = pieces[0].surface.kind
    if kind not in _KINDS or any(piece.surface.kind != kind for piece in pieces):
        return None
    parts = []
    for piece in pieces:
        normals = piece.orientation * piece.surface.project(piece.points)[1]
        parts.append((piece.points, normals))
    if any(len(points) == 0 for points, _ in parts):
        return None
    headings = np.stack([normals[0] for _, normals in parts])
    if kind == "plane" and (headings @ headings[0] < _SAME_WAY).any():
        return None
    common = fit_jointly((kind,), parts, float(np.median(evidence.noise)), options)
    if common is None:
        return None
    sides = [np.einsum("ij,ij->", common.project(points)[1], normals) for points, normals in parts]
    return common if len(set(np.sign(sides))) == 1 else None
