"""Expansion moves against the energy written out and against every possible move."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from crispline.net.halfedge import half_edges
from crispline.region import expand
from crispline.region.claim import OUT_OF_REACH
from crispline.region.patches import PatchGraph


def energy(label, costs, pairs, border):
    data = sum(costs[int(name)][i] for i, name in enumerate(label))
    return data + border * sum(label[p] != label[q] for p, q in pairs)


def random_costs(rng, m, n_labels, share_out_of_reach):
    """Multiples of 1/1000, which the integer capacities represent exactly."""
    costs = {}
    for region in range(n_labels):
        cost = rng.integers(0, 5000, m) / 1000.0
        cost[rng.random(m) < share_out_of_reach] = OUT_OF_REACH
        costs[region] = cost
    return costs


def reach(costs, region, pairs):
    nowhere = np.zeros((len(costs[region]), 3))
    graph = PatchGraph(nowhere, nowhere, pairs, 1.0)
    return expand._Reach.of(costs[region] < OUT_OF_REACH, graph)


def even_weights(costs, pairs, border):
    """Every side costs ``border`` between any two labels."""
    return {region: np.full(len(pairs), border / 2) for region in costs}


@given(
    seed=st.integers(0, 100_000),
    n_labels=st.integers(2, 4),
    border=st.sampled_from([0.0, 0.5, 1.0, 3.0]),
    share_out_of_reach=st.sampled_from([0.0, 0.2]),
)
@settings(max_examples=60)
def test_a_move_is_the_best_of_all_moves(nets, seed, n_labels, border, share_out_of_reach):
    rng = np.random.default_rng(seed)
    pairs = half_edges(nets.grid(4, 4), 16).pairs()  # 9 patches
    costs = random_costs(rng, 9, n_labels, share_out_of_reach)
    label = rng.integers(0, n_labels, 9)
    for patch, region in enumerate(label):  # a patch is within reach of the label it holds
        costs[int(region)][patch] = min(costs[int(region)][patch], 7.0)
    for region in range(n_labels):
        moved = expand._expansion(
            region, label, costs, reach(costs, region, pairs), even_weights(costs, pairs, border)
        )
        best = min(
            energy(np.where(takes, region, label), costs, pairs, border)
            for takes in itertools.product([False, True], repeat=9)
        )
        assert abs(energy(moved, costs, pairs, border) - best) < 1e-9
        assert ((moved == label) | (moved == region)).all()
        label = moved


@given(seed=st.integers(0, 100_000), n_labels=st.integers(2, 6))
@settings(max_examples=20)
def test_energy_never_rises(nets, seed, n_labels):
    rng = np.random.default_rng(seed)
    pairs = half_edges(nets.grid(12, 10, is_closed=True), 120).pairs()
    costs = random_costs(rng, 120, n_labels, 0.1)
    label = rng.integers(0, n_labels, 120)
    before = energy(label, costs, pairs, 1.0)
    for _ in range(2):
        for region in range(n_labels):
            label = expand._expansion(
                region, label, costs, reach(costs, region, pairs), even_weights(costs, pairs, 1.0)
            )
            after = energy(label, costs, pairs, 1.0)
            assert after <= before + 1e-9
            before = after


def test_a_region_out_of_reach_of_everything_changes_nothing(nets):
    pairs = half_edges(nets.grid(4, 4), 16).pairs()
    costs = {0: np.ones(9), 1: np.full(9, OUT_OF_REACH)}
    label = np.zeros(9, dtype=int)
    np.testing.assert_array_equal(
        expand._expansion(1, label, costs, reach(costs, 1, pairs), even_weights(costs, pairs, 1.0)),
        label,
    )
