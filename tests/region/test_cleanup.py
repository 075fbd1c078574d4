"""Labellings made fit for a solid: connected, large enough, never pinched."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crispline.net.halfedge import half_edges
from crispline.region.cleanup import one_piece_per_label, pieces, tidy


def net_of(nets, name):
    quads = nets.box(6)[1] if name == "sphere" else nets.grid(16, 12, is_closed=True)
    return half_edges(quads, int(quads.max()) + 1)


def flood(label, net):
    """Connected pieces by walking."""
    piece, neighbours = np.full(len(label), -1), net.neighbours()
    for start in range(len(label)):
        if piece[start] >= 0:
            continue
        front, name = [start], piece.max() + 1
        while front:
            quad = front.pop()
            if piece[quad] < 0:
                piece[quad] = name
                front += [n for n in neighbours[quad] if n >= 0 and label[n] == label[quad]]
    return piece


def n_pinches(label, net):
    """Vertices where a region occurs in two or more separate runs."""
    count = 0
    for vertex in range(net.n_vertices):
        start = int(np.flatnonzero(net.origin == vertex)[0])
        around, half_edge = [], start
        while True:
            around.append(int(label[half_edge // 4]))
            half_edge = int(net.next[net.twin[half_edge]])
            if half_edge == start:
                break
        runs = [a for a, b in zip(around, around[1:] + around[:1], strict=True) if a != b]
        count += len(runs) > len(set(runs))
    return count


def blobs(net, n_labels, seed, share_of_noise):
    """Random regions with random wrong patches."""
    rng = np.random.default_rng(seed)
    seeds = rng.choice(net.n_quads, n_labels, replace=False)
    label = np.full(net.n_quads, -1)
    label[seeds] = np.arange(n_labels)
    neighbours = net.neighbours()
    while (label < 0).any():
        grown = label.copy()
        for quad in np.flatnonzero(label < 0):
            beside = label[neighbours[quad]]
            beside = beside[beside >= 0]
            if len(beside):
                grown[quad] = rng.choice(beside)
        label = grown
    wrong = rng.random(net.n_quads) < share_of_noise
    label[wrong] = rng.integers(0, n_labels, int(wrong.sum()))
    return label


CASES = {
    "name": st.sampled_from(["sphere", "torus"]),
    "n_labels": st.integers(1, 8),
    "seed": st.integers(0, 10_000),
    "share": st.sampled_from([0.0, 0.1, 0.4]),
}


@given(**CASES)
@settings(max_examples=50)
def test_pieces_are_those_of_a_walk(nets, name, n_labels, seed, share):
    net = net_of(nets, name)
    label = blobs(net, n_labels, seed, share)
    ours, walked = pieces(label, net), flood(label, net)
    assert len(np.unique(ours)) == len(np.unique(np.stack([ours, walked]), axis=1)[0])
    single = one_piece_per_label(label, net)
    assert len(np.unique(single)) == walked.max() + 1
    for region in np.unique(label):  # the largest piece keeps the number
        sizes = np.bincount(walked[label == region])
        assert np.sum(single == region) == sizes.max()


@given(**CASES, min_patches=st.sampled_from([3, 8]))
@settings(max_examples=50)
def test_tidy_regions_are_connected_large_and_not_pinched(
    nets, name, n_labels, seed, share, min_patches
):
    net = net_of(nets, name)
    label = tidy(blobs(net, n_labels, seed, share), net, min_patches)
    sizes = np.bincount(flood(label, net))
    assert len(sizes) == len(np.unique(label))
    assert len(sizes) == 1 or sizes.min() >= min_patches
    assert n_pinches(label, net) == 0


def test_a_region_that_touches_itself_across_a_vertex_is_mended(nets):
    """A ring of patches whose hole and outside meet in one vertex."""
    net = net_of(nets, "torus")
    ring = np.zeros((16, 12), dtype=np.int64)
    ring[2:9, 2:9] = 1
    ring[4:7, 4:7] = 2
    ring[7:9, 7:9] = 0
    label = ring.ravel()
    assert n_pinches(label, net) == 1
    mended = tidy(label, net, 3)
    assert n_pinches(mended, net) == 0
    assert np.sum(mended != label) <= 2
    assert len(np.unique(mended)) == 3


@pytest.mark.parametrize("min_patches", [1, 12])
def test_a_sound_labelling_stays_as_it_is(nets, min_patches):
    vertices, quads, side = nets.box(6)
    net = half_edges(quads, len(vertices))
    np.testing.assert_array_equal(tidy(side, net, min_patches), side)
