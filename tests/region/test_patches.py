"""Rings and sides of patches against the adjacency matrix."""

import numpy as np

from crispline.net.halfedge import half_edges
from crispline.region.patches import PatchGraph


def open_graph(nets, n_u=8, n_v=6):
    """An open sheet: patches with two, three and four neighbours."""
    quads = half_edges(nets.grid(n_u, n_v), n_u * n_v)
    nowhere = np.zeros((quads.n_quads, 3))
    return PatchGraph(nowhere, nowhere, quads.pairs(), 1.0)


def test_rings_are_powers_of_the_adjacency(nets):
    graph = open_graph(nets)
    members = np.random.default_rng(0).random(len(graph)) < 0.1
    expected = members.copy()
    for n in range(5):
        np.testing.assert_array_equal(graph.rings(members, n), expected)
        expected = expected | (graph.adjacency @ expected.astype(float) > 0.0)


def test_sides_of_patches_are_all_pairs_that_name_them(nets):
    graph = open_graph(nets)
    patches = np.array([3, 4, 17])
    expected = np.flatnonzero(np.isin(graph.pairs, patches).any(axis=1))
    np.testing.assert_array_equal(graph.sides_of(patches), expected)


def test_patches_without_sides_have_rings_of_their_own():
    nowhere = np.zeros((3, 3))
    graph = PatchGraph(nowhere, nowhere, np.zeros((0, 2), dtype=np.int64), 1.0)
    members = np.array([True, False, False])
    np.testing.assert_array_equal(graph.rings(members, 4), members)
    assert graph.sides_of(np.array([0, 2])).size == 0
