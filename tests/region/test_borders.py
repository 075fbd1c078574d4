"""Borders between regions against every side looked at."""

import numpy as np

from crispline.net.halfedge import half_edges
from crispline.region.borders import Borders
from crispline.region.patches import PatchGraph


def torus_graph(nets, n_u=9, n_v=7):
    pairs = half_edges(nets.grid(n_u, n_v, is_closed=True), n_u * n_v).pairs()
    nowhere = np.zeros((n_u * n_v, 3))
    return PatchGraph(nowhere, nowhere, pairs, 1.0)


def test_every_side_between_two_regions_is_found_once(nets):
    graph = torus_graph(nets)
    label = np.random.default_rng(0).integers(0, 5, len(graph))
    borders = Borders.of(label, graph)
    ends = np.sort(label[graph.pairs], axis=1)
    for first in range(5):
        for second in range(first + 1, 5):
            expected = np.flatnonzero((ends == (first, second)).all(axis=1))
            np.testing.assert_array_equal(borders.sides(second, first), expected)
    np.testing.assert_array_equal(
        borders.regions, np.unique(ends[ends[:, 0] != ends[:, 1]], axis=0)
    )
    assert borders.lengths.sum() == np.count_nonzero(ends[:, 0] != ends[:, 1])


def test_regions_apart_have_no_side_in_common(nets):
    graph = torus_graph(nets)
    assert Borders.of(np.zeros(len(graph), dtype=np.int64), graph).sides(0, 1).size == 0
