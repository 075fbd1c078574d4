"""Move region borders to where the fitted surfaces put them: alpha expansion.

Boykov, Veksler and Zabih 2001: every label in turn may take any patch near a
border if that lowers the sum of the misfit of the patches' points and the
length of the borders; each such move is a minimum cut.
"""

from __future__ import annotations

from collections.abc import Mapping

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
    for region in np.unique(label[band]).tolist():
        within = claims[region].reach(label == region) & band
        costs[region] = claims[region].patch_costs(within)
        weights[region] = claims[region].border_costs(within)
    for _ in range(_SWEEPS):
        before = label.copy()
        for region in costs:
            label = _expansion(region, label, costs, graph.pairs, weights)
        if np.array_equal(label, before):
            break
    return label


def _expansion(
    region: int,
    label: Labels,
    costs: Mapping[int, Array],
    pairs: NDArray[np.int64],
    weights: Mapping[int, Array],
) -> Labels:
    """The best labelling in which patches either keep their label or take ``region``.

    A side between labels ``a`` and ``b`` costs ``weights[a] + weights[b]`` there,
    which is a metric on the labels, as expansion moves need.
    """
    own = costs[region]
    active = np.flatnonzero(own < OUT_OF_REACH)
    if len(active) == 0:
        return label
    index = np.full(len(label), -1)
    index[active] = np.arange(len(active))
    current = np.zeros(len(active))
    for other in np.unique(label[active]).tolist():
        held = label[active] == other
        current[held] = costs[other][active[held]]
    gain = own[active] - current  # cost of taking the region, relative to keeping the label

    near = np.flatnonzero((index[pairs] >= 0).any(axis=1))
    p, q = pairs[near].T
    weight_p, weight_q = np.zeros(len(near)), np.zeros(len(near))
    for other in np.unique(label[pairs[near]]).tolist():
        for ends, weight in ((p, weight_p), (q, weight_q)):
            held = label[ends] == other
            weight[held] = weights[other][near[held]]
    own_weight = weights[region][near]
    cost_keep = (weight_p + weight_q) * (label[p] != label[q])
    cost_p_keeps = (weight_p + own_weight) * (label[p] != region)  # and q takes the region
    cost_q_keeps = (weight_q + own_weight) * (label[q] != region)
    p_in, q_in = index[p] >= 0, index[q] >= 0
    only_p, only_q, both = p_in & ~q_in, q_in & ~p_in, p_in & q_in
    np.add.at(gain, index[p[only_p]], (cost_q_keeps - cost_keep)[only_p])
    np.add.at(gain, index[q[only_q]], (cost_p_keeps - cost_keep)[only_q])
    # Kolmogorov and Zabih 2004: a regular pair term is two unary terms and one arc.
    np.add.at(gain, index[p[both]], (cost_q_keeps - cost_keep)[both])
    np.add.at(gain, index[q[both]], -cost_q_keeps[both])
    arc = (cost_p_keeps + cost_q_keeps - cost_keep)[both]
    gain[label[active] == region] = -OUT_OF_REACH  # keeping and taking are the same

    n = len(active)
    source, sink = n, n + 1
    keeps, takes = np.flatnonzero(gain > 0.0), np.flatnonzero(gain <= 0.0)
    tail = np.concatenate([np.full(len(keeps), source), takes, index[p[both]]])
    head = np.concatenate([keeps, np.full(len(takes), sink), index[q[both]]])
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
