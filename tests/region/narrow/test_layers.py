"""Layers of patches are closed rings in order, however ragged the wish."""

import numpy as np
import pytest

from crispline.net.halfedge import half_edges
from crispline.region.narrow.layers import layered

N_AROUND = 24


def band(n_rows):
    """A ring of quads, ``n_rows`` along its axis; row by row."""
    row, turn = np.divmod(np.arange(n_rows * N_AROUND), N_AROUND)
    first, second = row * N_AROUND + turn, row * N_AROUND + (turn + 1) % N_AROUND
    quads = np.column_stack([first, second, second + N_AROUND, first + N_AROUND])
    return row, quads, half_edges(quads, (n_rows + 1) * N_AROUND)


def share_a_vertex(quads, layer):
    """Pairs of layers with a common vertex."""
    found = set()
    for vertex in np.unique(quads):
        around = np.unique(layer[(quads == vertex).any(axis=1)]).tolist()
        found |= {(a, b) for a in around for b in around if a < b}
    return found


@pytest.mark.parametrize("n_layers", [1, 2, 3])
@pytest.mark.parametrize("seed", range(4))
def test_layers_follow_each_other_all_round(n_layers, seed):
    row, quads, net = band(9)
    rng = np.random.default_rng(seed)
    last = n_layers + 1
    wish = np.clip(row - 3 + rng.integers(-1, 2, len(row)), 0, last)
    wish = np.where(row < 2, 0, np.where(row > 6, last, wish))
    layer = layered(wish, n_layers, net)
    assert share_a_vertex(quads, layer) == {(n, n + 1) for n in range(last)}
    for name in range(1, last):
        assert len(np.unique(np.arange(len(row))[layer == name] % N_AROUND)) == N_AROUND


def test_room_is_made_where_there_is_none():
    row, quads, net = band(8)
    layer = layered(np.where(row < 4, 0, 4), 3, net)
    assert layer is None or share_a_vertex(quads, layer) == {(0, 1), (1, 2), (2, 3), (3, 4)}
    touching = layered(np.where(row < 4, 0, 2), 1, net)
    assert share_a_vertex(quads, touching) == {(0, 1), (1, 2)}


def test_what_fits_already_is_left_and_what_is_elsewhere_has_no_number():
    row, _, net = band(9)
    wish = np.clip(row - 2, 0, 4)
    wish[row == 8] = -1
    np.testing.assert_array_equal(layered(wish, 3, net), wish)


def test_too_few_patches_have_no_layers():
    row, _, net = band(2)
    assert layered(np.where(row == 0, 0, 4), 3, net) is None
