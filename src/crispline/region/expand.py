"""Move region borders to where the fitted surfaces put them: alpha expansion.

Boykov, Veksler and Zabih 2001: every label in turn may take any patch near a
border if that lowers the sum of the misfit of the patches' points and the
length of the borders; each such move is a minimum cut.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, maximum_flow

from crispline.options import RegionOptions
from crispline.region.claim import OUT_OF_REACH, Claim
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

_SCALE = 1000  # costs become integers for the maximum flow
_SWEEPS = 2
_SETTLED_SHARE = 5e-4  # borders have settled when fewer patches than this change


def expand_regions(
    label: Labels,
    fits: Mapping[int, RegionFit],
    evidence: Evidence,
    options: RegionOptions,
) -> Labels:
    """Labels of least cost near the borders, shape ``(m,)``; labels may end in several pieces.

    A region reaches a few rings from its border at a time; while borders still
    move, the reach moves with them.
    """
    claims = {region: Claim(fit, evidence, options) for region, fit in fits.items()}
    for _ in range(options.expansion_moves):
        before = label
        label = _expand_once(label, claims, evidence.graph, options)
        if int((label != before).sum()) < _SETTLED_SHARE * len(label):
            break
    return label


def _expand_once(
    label: Labels, claims: Mapping[int, Claim], graph: PatchGraph, options: RegionOptions
) -> Labels:
    label = label.copy()
    a, b = graph.pairs.T
    at_border = np.zeros(len(label), dtype=bool)
    at_border[graph.pairs[label[a] != label[b]].ravel()] = True
    band = graph.rings(at_border, options.expansion_rings)
    costs: dict[int, Array] = {}
    weights: dict[int, Array] = {}
    moves: dict[int, _Reach] = {}
    for region in np.unique(label[band]).tolist():
        within = claims[region].reach(label == region) & band
        reach = moves[region] = _Reach.of(within, graph)
        costs[region], weights[region] = claims[region].costs(reach.patches, reach.sides)
    settled: dict[int, Labels] = {}
    for _ in range(_SWEEPS):
        before = label.copy()
        for region, reach in moves.items():
            # A region gains nothing twice where nothing has changed since.
            if region in settled and np.array_equal(label[reach.ends], settled[region]):
                continue
            label = _expansion(region, label, costs, reach, weights)
            settled[region] = label[reach.ends]
        if np.array_equal(label, before):
            break
    return label


@dataclass(frozen=True)
class _Reach:
    """The patches that a region may take and the sides of these.

    Attributes
    ----------
    patches : shape ``(n,)``.
    sides : indices of the sides with at least one such patch, shape ``(k,)``.
    ends : the patches of these sides, shape ``(2, k)``.
    places : where these stand among ``patches``, or -1, shape ``(2, k)``.
    """

    patches: NDArray[np.int64]
    sides: NDArray[np.int64]
    ends: NDArray[np.int64]
    places: NDArray[np.int64]

    @classmethod
    def of(cls, within: NDArray[np.bool_], graph: PatchGraph) -> _Reach:
        patches = np.flatnonzero(within)
        sides = graph.sides_of(patches)
        ends = graph.pairs[sides].T
        place = np.full(len(within), -1)
        place[patches] = np.arange(len(patches))
        return cls(patches, sides, ends, place[ends])


def _expansion(
    region: int,
    label: Labels,
    costs: Mapping[int, Array],
    reach: _Reach,
    weights: Mapping[int, Array],
) -> Labels:
    """The best labelling in which patches either keep their label or take ``region``.

    A side between labels ``a`` and ``b`` costs ``weights[a] + weights[b]`` there,
    which is a metric on the labels, as expansion moves need.
    """
    active = reach.patches
    if len(active) == 0:
        return label
    held = label[active]
    current = np.zeros(len(active))
    for other in np.unique(held).tolist():
        current[held == other] = costs[other][active[held == other]]
    gain = costs[region][active] - current  # cost of taking the region, relative to keeping

    near = reach.sides
    label_p, label_q = label[reach.ends]
    weight_p, weight_q = np.zeros(len(near)), np.zeros(len(near))
    for other in np.unique(np.concatenate([label_p, label_q])).tolist():
        for labels, weight in ((label_p, weight_p), (label_q, weight_q)):
            weight[labels == other] = weights[other][near[labels == other]]
    own_weight = weights[region][near]
    cost_keep = (weight_p + weight_q) * (label_p != label_q)
    cost_p_keeps = (weight_p + own_weight) * (label_p != region)  # and q takes the region
    cost_q_keeps = (weight_q + own_weight) * (label_q != region)
    p, q = reach.places
    only_p, only_q, both = q < 0, p < 0, (p >= 0) & (q >= 0)
    np.add.at(gain, p[only_p], (cost_q_keeps - cost_keep)[only_p])
    np.add.at(gain, q[only_q], (cost_p_keeps - cost_keep)[only_q])
    # Kolmogorov and Zabih 2004: a regular pair term is two unary terms and one arc.
    np.add.at(gain, p[both], (cost_q_keeps - cost_keep)[both])
    np.add.at(gain, q[both], -cost_q_keeps[both])
    arc = (cost_p_keeps + cost_q_keeps - cost_keep)[both]
    gain[held == region] = -OUT_OF_REACH  # keeping and taking are the same

    n = len(active)
    source, sink = n, n + 1
    keeps, takes = np.flatnonzero(gain > 0.0), np.flatnonzero(gain <= 0.0)
    tail = np.concatenate([np.full(len(keeps), source), takes, p[both]])
    head = np.concatenate([keeps, np.full(len(takes), sink), q[both]])
    capacity = np.round(_SCALE * np.concatenate([gain[keeps], -gain[takes], arc]))
    graph = csr_array((capacity.astype(np.int32), (tail, head)), shape=(n + 2, n + 2))
    graph.sum_duplicates()
    graph.eliminate_zeros()
    residual = csr_array(graph - maximum_flow(graph, source, sink).flow)
    residual.data[residual.data < 0] = 0
    residual.eliminate_zeros()
    kept = breadth_first_order(residual, source, return_predecessors=False)
    taken = np.ones(n + 2, dtype=bool)
    taken[kept] = False
    label = label.copy()
    label[active[taken[:n]]] = region
    return label
