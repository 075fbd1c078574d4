"""Connectivity of quad nets against dictionaries, and nets that are not sound."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.net.graph import components
from crispline.net.halfedge import half_edges


def shape(nets, name):
    return {
        "box": lambda: nets.box(3)[1],
        "torus": lambda: nets.grid(5, 4, is_closed=True),
        "open": lambda: nets.grid(4, 6),
    }[name]()


@given(name=st.sampled_from(["box", "torus", "open"]), seed=st.integers(0, 100))
def test_twins_are_the_sides_run_the_other_way(nets, name, seed):
    rng = np.random.default_rng(seed)
    quads = shape(nets, name)
    n = quads.max() + 1
    quads = rng.permutation(n)[quads][rng.permutation(len(quads))]  # any numbering
    net = half_edges(quads, n)
    place = {}
    for face, quad in enumerate(quads.tolist()):
        for k in range(4):
            place[quad[k], quad[(k + 1) % 4]] = 4 * face + k
    for half_edge in range(4 * len(quads)):
        side = int(net.origin[half_edge]), int(net.target[half_edge])
        assert place[side] == half_edge
        assert net.twin[half_edge] == place.get(side[::-1], -1)
        assert net.origin[net.next[half_edge]] == net.target[half_edge]
        assert net.quad[net.next[half_edge]] == net.quad[half_edge]
    assert net.is_closed == (name != "open")


@pytest.mark.parametrize(("name", "euler"), [("box", 2), ("torus", 0), ("open", 1)])
def test_pairs_adjacency_and_neighbours_agree(nets, name, euler):
    quads = shape(nets, name)
    n = quads.max() + 1
    net = half_edges(quads, n)
    dense = net.adjacency().toarray()
    np.testing.assert_array_equal(dense, dense.T)
    assert dense.max() == 1.0
    pairs = net.pairs()
    assert (pairs[:, 0] < pairs[:, 1]).all()
    assert len(pairs) == dense.sum() / 2
    np.testing.assert_array_equal(dense[pairs[:, 0], pairs[:, 1]], 1.0)
    neighbours = net.neighbours()
    assert [set(row[row >= 0]) for row in neighbours] == [set(np.flatnonzero(r)) for r in dense]
    n_sides = len(pairs) + int((net.twin < 0).sum())
    assert n - n_sides + len(quads) == euler


def test_a_closed_net_passes_and_an_open_one_is_refused_with_its_place(nets):
    vertices, quads, _ = nets.box(4, half=10.0)
    assert half_edges(quads, len(vertices)).opening(vertices) == ""
    corner = np.array([10.0, 10.0, 10.0])
    hole = np.argmin(np.linalg.norm(vertices[quads].mean(axis=1) - corner, axis=1))
    open_net = half_edges(np.delete(quads, hole, axis=0), len(vertices))
    sentence = open_net.opening(vertices)
    assert "open at 4 sides" in sentence
    place = sentence.split("(")[1].split(")")[0]
    middle = np.array([float(x) for x in place.split(",")])
    np.testing.assert_allclose(middle, vertices[quads[hole]].mean(axis=0), atol=3.0)


@pytest.mark.parametrize(
    "extra",
    [[0, 1, 6, 7], [1, 0, 6, 7]],
    ids=["a third quad on a side", "and one the other way round"],
)
def test_a_side_of_three_quads_counts_as_open(nets, extra):
    quads = np.concatenate([nets.grid(2, 3), [extra]])
    net = half_edges(quads, 8)
    assert not net.is_closed
    twins = net.twin[net.twin >= 0]
    np.testing.assert_array_equal(net.twin[twins], np.flatnonzero(net.twin >= 0))


def test_quads_of_opposite_orientation_are_not_neighbours(nets):
    quads = nets.grid(3, 2)
    quads[1] = quads[1, ::-1]
    assert (half_edges(quads, 6).twin < 0).all()


def test_components_within_a_set(nets):
    quads = nets.grid(5, 5)
    adjacency = half_edges(quads, 25).adjacency()
    members = np.ones(16, dtype=bool)
    members[4:8] = False  # one row of cells is left out
    piece = components(adjacency, members)
    assert len(set(piece[:4])) == 1
    assert len(set(piece[8:])) == 1
    assert len(set(piece)) == 2 + 4


def test_a_sieve_is_torn_and_a_sheet_with_a_few_holes_is_not():
    n, pitch = 30, 6
    row, column = (index.ravel() for index in np.mgrid[:n, :n])
    corner = row * (n + 1) + column
    quads = np.stack([corner, corner + 1, corner + n + 2, corner + n + 1], axis=1)
    hole = (row % pitch == 2) & (column % pitch == 2)
    sieve = half_edges(quads[~hole], (n + 1) ** 2)
    assert sieve.tears() == (n // pitch) ** 2 + 1
    few = half_edges(quads[~(hole & (row < 3 * pitch))], (n + 1) ** 2)
    assert few.tears() == 0
    places = np.stack((*np.divmod(np.arange((n + 1) ** 2), n + 1), np.zeros((n + 1) ** 2)), axis=1)
    assert sieve.rims(places).endswith("26 free borders, the longest 120 long")
