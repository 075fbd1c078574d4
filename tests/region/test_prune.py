"""Which small regions go to their neighbours: a block of patches in a plain sheet."""

from types import SimpleNamespace

import numpy as np
import pytest

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.patches import PatchGraph
from crispline.region.prune import prune_regions
from crispline.region.regionfit import RegionFit
from crispline.surface import Plane

N, SIGMA = 24, 0.1
OPTIONS = RegionOptions()


def pruned(nets, length, off):
    """Labels after pruning a block, ten patches wide, whose points lie off all surfaces."""
    quads = half_edges(nets.grid(N, N, is_closed=True), N * N)
    row, column = (a.ravel() for a in np.mgrid[:N, :N])
    is_block = (row >= 5) & (row < 15) & (column >= 4) & (column < 4 + length)
    points = np.column_stack([row, column, np.zeros(N * N)]).astype(float)
    up = np.tile([0.0, 0.0, 1.0], (N * N, 1))
    evidence = SimpleNamespace(
        graph=PatchGraph(points, up, quads.pairs(), 1.0),
        patch_noise=np.full(N * N, SIGMA),
        misfit=lambda fit, patches: np.where(is_block[patches, None], off, 0.0) * np.ones((1, 3)),
    )
    fit = RegionFit(Plane(np.zeros(3), up[0]), 1, np.empty((0, 3)), np.empty(0), is_accepted=False)
    label = is_block.astype(np.int64)
    return is_block, prune_regions(label, {0: fit, 1: fit}, evidence, OPTIONS)


@pytest.mark.parametrize("length", [4, 16])
def test_a_block_that_its_neighbour_explains_goes(nets, length):
    _, label = pruned(nets, length, SIGMA)
    assert not label.any()


def test_a_block_that_nothing_explains_stays_if_it_is_more_than_a_crumb(nets):
    is_block, label = pruned(nets, 16, 5.0 * SIGMA)
    assert is_block.sum() >= OPTIONS.crumb_patches
    np.testing.assert_array_equal(label, is_block)


def test_a_crumb_that_nothing_explains_goes(nets):
    is_block, label = pruned(nets, 14, 5.0 * SIGMA)
    assert is_block.sum() < OPTIONS.crumb_patches
    assert not label.any()
