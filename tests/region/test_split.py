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
    ).label


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


def waves(n=60, length=40.0, height=1.5):
    """The graph of a sheet with bumps, of which primitives explain small pieces."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(n) + 0.5, np.arange(n) + 0.5))
    k = 2.0 * np.pi / length
    points = np.stack([x, y, height * np.sin(k * x) * np.sin(k * y)], axis=1)
    slope = height * k
    normals = np.stack(
        [
            -slope * np.cos(k * x) * np.sin(k * y),
            -slope * np.sin(k * x) * np.cos(k * y),
            np.ones(n * n),
        ],
        axis=1,
    )
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    index = np.arange(n * n).reshape(n, n)
    pairs = np.concatenate(
        [
            np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
            np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
        ]
    )
    return PatchGraph(points, normals, pairs, 1.0)


def parted(graph, options):
    m = len(graph)
    noise, is_sharp = np.full(m, 0.03), np.zeros(m, dtype=bool)
    return split_into_surfaces(
        np.zeros(m, dtype=np.int64), graph, is_sharp, noise, options, FitOptions()
    )


def test_a_sculpture_is_left_whole():
    graph = waves()
    found = parted(graph, RegionOptions(many_crumbs=10))
    assert found.is_sculpture
    assert not found.label.any()


def test_few_crumbs_or_little_left_are_no_sculpture():
    graph = waves()
    few = parted(graph, RegionOptions(many_crumbs=200))
    assert not few.is_sculpture
    assert len(np.unique(few.label)) > 10
    assert not parted(graph, RegionOptions(many_crumbs=10, max_loose=0.9)).is_sculpture
