"""Watershed between sharp bands: one basin a face, no leak through gaps."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.basins import basins, consecutive, grow_into_gaps

OPTIONS = RegionOptions()
N = 12


def box(nets):
    """Patch centres, normals and pairs of a box of side ``N``, its sides, and its edge band."""
    vertices, quads, side = nets.box(N, half=N / 2.0)
    centres = vertices[quads].mean(axis=1)
    normals = np.eye(3)[side // 2] * np.where(side % 2, 1.0, -1.0)[:, None]
    pairs = half_edges(quads, len(vertices)).pairs()
    in_band = np.sort(np.abs(centres), axis=1)[:, 1] > N / 2.0 - 1.0
    return centres, normals, pairs, side, in_band


def same_partition(one, other):
    pairs = {(int(a), int(b)) for a, b in zip(one, other, strict=True)}
    return len(pairs) == len({a for a, _ in pairs}) == len({b for _, b in pairs})


def flat(normals):
    return np.tile([0.0, 0.0, 1.0], (len(normals), 1))


@pytest.mark.parametrize("has_band", [True, False])
def test_a_box_has_six_basins(nets, has_band):
    """By the band of sharp patches, or by the turn of the normals alone."""
    centres, normals, pairs, side, in_band = box(nets)
    label = basins(centres, normals, pairs, in_band & has_band, 1.0, OPTIONS)
    assert same_partition(label, side)


@given(seed=st.integers(0, 1000), share=st.floats(0.0, 0.15))
@settings(max_examples=20)
def test_gaps_in_the_band_do_not_leak(nets, seed, share):
    """The normals give no help here: only the band separates."""
    centres, normals, pairs, side, in_band = box(nets)
    gaps = np.random.default_rng(seed).random(len(in_band)) < share
    label = basins(centres, flat(normals), pairs, in_band & ~gaps, 1.0, OPTIONS)
    owners = [np.bincount(label[side == k]).argmax() for k in range(6)]
    assert len(set(owners)) == 6
    assert np.mean((label == np.array(owners)[side])[~in_band]) > 0.98


def test_without_any_crease_all_is_one_basin(nets):
    centres, normals, pairs, _, in_band = box(nets)
    label = basins(centres, flat(normals), pairs, np.zeros_like(in_band), 1.0, OPTIONS)
    np.testing.assert_array_equal(label, 0)


def test_is_the_same_in_every_unit(nets):
    centres, normals, pairs, _, in_band = box(nets)
    one = basins(centres, normals, pairs, in_band, 1.0, OPTIONS)
    other = basins(1000.0 * centres, normals, pairs, in_band, 1000.0, OPTIONS)
    np.testing.assert_array_equal(one, other)


def test_small_basins_go_to_their_neighbours(nets):
    centres, normals, pairs, _, in_band = box(nets)
    options = RegionOptions(min_patches=N * N + 1)
    label = basins(centres, normals, pairs, in_band, 1.0, options)
    # None is large enough, so nobody can take anybody: all patches end in one region.
    np.testing.assert_array_equal(label, 0)


def test_gaps_are_given_to_the_nearest_in_place_and_direction(nets):
    centres, normals, pairs, side, in_band = box(nets)
    label = grow_into_gaps(np.where(in_band, -1, side), pairs, centres, normals)
    np.testing.assert_array_equal(label, side)


def test_numbers_become_consecutive():
    np.testing.assert_array_equal(consecutive(np.array([7, -1, 7, 3])), [2, 0, 2, 1])
