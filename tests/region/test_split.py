"""Smooth regions of several surfaces, split where one ends and the next begins."""

import numpy as np
import pytest

from crispline.options import FitOptions, RegionOptions
from crispline.region.patches import PatchGraph
from crispline.region.split import split_into_surfaces

SIGMA = 0.08


def profile(turns_deg, width, length, seed=0):
    """Strips of planes, each turned by as many degrees against the one before.

    Patches of side 1 with some noise, their graph, and the strip of each.
    """
    along = np.arange(0.5, width * len(turns_deg))
    strip = (along // width).astype(np.int64)
    slope = np.radians(np.cumsum(turns_deg))[strip]
    step = np.stack([np.cos(slope), np.sin(slope)])
    x, z = np.cumsum(step, axis=1) - 0.5 * step
    across = np.arange(0.5, length)
    rng = np.random.default_rng(seed)
    normals = np.repeat(np.stack([-step[1], 0.0 * x, step[0]], axis=1), length, axis=0)
    points = np.stack(
        [np.repeat(x, length), np.tile(across, len(along)), np.repeat(z, length)], axis=1
    )
    points += 0.6 * SIGMA * rng.normal(size=(len(points), 1)) * normals
    index = np.arange(len(points)).reshape(len(along), length)
    pairs = np.concatenate(
        [
            np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
            np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
        ]
    )
    return PatchGraph(points, normals, pairs, 1.0), np.repeat(strip, length)


def split(graph, options=None):
    label = np.zeros(len(graph), dtype=np.int64)
    is_sharp = np.zeros(len(graph), dtype=bool)
    noise = np.full(len(graph), SIGMA)
    return split_into_surfaces(
        label, graph, is_sharp, noise, options or RegionOptions(), FitOptions()
    )


@pytest.mark.parametrize("turns", [(0.0, 11.0), (-25.0, 11.0, 13.0, 11.0)])
@pytest.mark.parametrize("width", [20, 24])
def test_planes_that_meet_at_few_degrees_stay_planes(turns, width):
    """A wide cylinder comes near to two of them, and has more patches than either."""
    graph, strip = profile(turns, width, 50)
    label = split(graph)
    for k in range(len(turns)):
        votes = np.bincount(label[strip == k])
        assert votes.max() > 0.93 * (strip == k).sum()
        assert (label[strip != k] == votes.argmax()).sum() < 0.07 * (strip == k).sum()


def test_one_plane_is_not_split():
    graph, _ = profile((0.0,), 40, 50)
    assert len(np.unique(split(graph))) == 1
