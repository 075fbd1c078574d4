"""Chains and loops of random labellings: every side once, loops close, Euler's formula."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.net.halfedge import half_edges
from crispline.region.topology import border_topology


def connected(nets, name):
    quads = {
        "sphere": lambda: nets.box(4)[1],
        "torus": lambda: nets.grid(7, 6, is_closed=True),
        "open": lambda: nets.grid(6, 7),
    }[name]()
    return half_edges(quads, int(quads.max()) + 1)


def random_regions(net, n_labels, seed):
    """Connected regions grown from random seeds."""
    rng = np.random.default_rng(seed)
    label = np.full(net.n_quads, -1)
    label[rng.choice(net.n_quads, n_labels, replace=False)] = np.arange(n_labels)
    neighbours = net.neighbours()
    while (label < 0).any():
        quad = rng.choice(np.flatnonzero(label < 0))
        beside = [label[n] for n in neighbours[quad] if n >= 0 and label[n] >= 0]
        if beside:
            label[quad] = rng.choice(beside)
    return label


def uses(topology):
    return [use for loops in topology.loops.values() for loop in loops for use in loop]


@given(
    name=st.sampled_from(["sphere", "torus", "open"]),
    n_labels=st.integers(1, 9),
    seed=st.integers(0, 10_000),
    is_speckled=st.booleans(),
)
def test_every_border_side_once_and_every_loop_closed(nets, name, n_labels, seed, is_speckled):
    net = connected(nets, name)
    label = random_regions(net, n_labels, seed)
    if is_speckled:  # labels in many pieces, pinched vertices everywhere
        label = np.random.default_rng(seed).integers(0, n_labels, net.n_quads)
    topology = border_topology(net, label)

    side_labels = {}
    for half_edge in range(len(net.origin)):
        twin = net.twin[half_edge]
        beyond = -1 if twin < 0 else label[twin // 4]
        if label[half_edge // 4] != beyond:
            side = int(net.origin[half_edge]), int(net.target[half_edge])
            side_labels[side] = int(label[half_edge // 4]), int(beyond)

    walked = {}
    for index, chain in enumerate(topology.chains):
        for side in zip(chain.vertices[:-1].tolist(), chain.vertices[1:].tolist(), strict=True):
            assert side_labels[side] == (chain.left, chain.right)
            assert side not in walked
            assert side[::-1] not in walked
            walked[side] = index
    # A side towards another region has two half-edges, one towards the open border has one.
    n_sides = sum(0.5 if right >= 0 else 1.0 for _, right in side_labels.values())
    assert len(walked) == n_sides

    inner = np.concatenate([chain.vertices[1:-1] for chain in topology.chains] or [[]])
    ends = {int(v) for chain in topology.chains for v in chain.vertices[[0, -1]]}
    assert len(np.unique(inner)) == len(inner)
    assert not ends & set(inner.tolist())

    expected = {(i, 1) for i in range(len(topology.chains))}
    expected |= {(i, -1) for i, chain in enumerate(topology.chains) if chain.right >= 0}
    assert sorted(uses(topology)) == sorted(expected)
    assert set(topology.loops) == set(np.unique(label).tolist())
    for region, loops in topology.loops.items():
        for loop in loops:
            for (i, way), (k, next_way) in zip(loop, loop[1:] + loop[:1], strict=True):
                here, there = topology.chains[i], topology.chains[k]
                assert here.vertices[::way][-1] == there.vertices[::next_way][0]
                assert (here.left if way > 0 else here.right) == region


@given(n_labels=st.integers(1, 9), seed=st.integers(0, 10_000))
def test_on_a_sphere_loops_count_the_holes_of_a_region(nets, n_labels, seed):
    """An open piece of the sphere with ``b`` ends has V - E + F = 2 - b."""
    net = connected(nets, "sphere")
    label = random_regions(net, n_labels, seed)
    topology = border_topology(net, label)
    left = label[net.quad]
    right = left[net.twin]
    for region in range(n_labels):
        n_faces = np.sum(label == region)
        n_sides = np.sum((left == region) & (right == region)) / 2
        around = [set(left[net.origin == v]) for v in range(net.n_vertices)]
        n_vertices = sum(labels == {region} for labels in around)
        assert n_vertices - n_sides + n_faces == 2 - len(topology.loops[region])


def test_box_has_twelve_chains_eight_corners_six_loops(nets):
    vertices, quads, side = nets.box(5)
    topology = border_topology(half_edges(quads, len(vertices)), side)
    assert len(topology.chains) == 12
    assert {len(chain.vertices) for chain in topology.chains} == {6}
    assert not any(chain.is_closed for chain in topology.chains)
    corners = {int(v) for chain in topology.chains for v in chain.vertices[[0, -1]]}
    np.testing.assert_array_equal(np.abs(vertices[sorted(corners)]), 1.0)
    assert [[len(loop) for loop in loops] for loops in topology.loops.values()] == [[4]] * 6


def test_the_region_is_on_the_left_seen_from_outside(nets):
    vertices, quads, side = nets.box(5)
    topology = border_topology(half_edges(quads, len(vertices)), side)
    for region, (loop,) in topology.loops.items():
        points = np.concatenate(
            [vertices[topology.chains[i].vertices[::way]][:-1] for i, way in loop]
        )
        twice_area = np.cross(points, np.roll(points, -1, axis=0)).sum(axis=0)
        outward = np.eye(3)[region // 2] * (1.0 if region % 2 else -1.0)
        assert twice_area @ outward == pytest.approx(8.0)


def test_rims_without_a_corner_are_closed_chains(nets):
    quads = nets.grid(6, 8, is_closed=True)
    label = np.repeat([0, 0, 1, 1, 1, 2], 8)  # three rings round the tube
    topology = border_topology(half_edges(quads, 48), label)
    assert len(topology.chains) == 3
    assert all(chain.is_closed for chain in topology.chains)
    assert all(len(loops) == 2 for loops in topology.loops.values())


def test_one_region_has_no_border(nets):
    topology = border_topology(connected(nets, "sphere"), np.zeros(96, dtype=int))
    assert topology.chains == ()
    assert topology.loops == {0: ()}
