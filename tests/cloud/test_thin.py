"""Thin walls are told, thick ones and clean parts are not."""

import numpy as np
import pytest

from crispline.cloud.thin import _split, thin_walls
from crispline.cloud.working import working_cloud
from crispline.options import CloudOptions


def slab(thickness, noise, seed=0):
    """Two square sheets of 50 spacings, a given number of spacings apart."""
    rng = np.random.default_rng(seed)
    points = rng.uniform(0.0, 50.0, (5000, 3))
    points[:, 2] = thickness * (np.arange(5000) % 2)
    return points + noise * rng.normal(size=points.shape)


@pytest.mark.parametrize("noise", [0.03, 0.2])
@pytest.mark.parametrize("thickness", [1.2, 1.5, 1.8])
def test_a_thin_wall_is_told(thickness, noise):
    cloud = working_cloud(0.1 * slab(thickness, noise), CloudOptions())
    found = thin_walls(cloud)
    assert found.share > 0.05
    assert found.distance == pytest.approx(thickness, abs=0.35)
    text = found.sentence(cloud)
    assert "walls and slots under 2 spacings" in text
    assert cloud.tree.query(found.place)[0] < 1e-9


def test_a_wall_under_one_spacing_is_told_through_noise_that_fills_it():
    """Its sheets have overlapping scatter: no gap is left between them."""
    cloud = working_cloud(slab(0.8, 0.16), CloudOptions())
    assert thin_walls(cloud).share > 0.05
    assert thin_walls(working_cloud(slab(0.0, 0.4), CloudOptions())).share < 0.005


def test_the_split_is_the_best_of_all():
    """Against the obvious twin: every cut in turn."""
    height = np.sort(np.random.default_rng(3).normal(size=(50, 24)), axis=1)
    height -= height.mean(axis=1, keepdims=True)
    n_below, within = _split(height)
    for row, n, scatter in zip(height, n_below, within, strict=True):
        cuts = range(4, 21)
        squares = [m * row[:m].var() + (24 - m) * row[m:].var() for m in cuts]
        assert n == cuts[int(np.argmin(squares))]
        assert scatter == pytest.approx(np.sqrt(min(squares) / 22))


def test_a_round_without_noise_is_no_wall():
    """The heights of a bent sheet are as two-sided as those of a wall, but a quadric is one."""
    angle, height = np.meshgrid(np.arange(16) * np.pi / 8.0, np.arange(90.0))
    points = np.stack([2.5 * np.cos(angle), 2.5 * np.sin(angle), height], axis=2)
    cloud = working_cloud(points.reshape(-1, 3), CloudOptions())
    assert thin_walls(cloud).sentence(cloud) == ""


@pytest.mark.parametrize("thickness", [3.0, 8.0])
def test_a_thick_wall_is_not(thickness):
    cloud = working_cloud(slab(thickness, 0.2), CloudOptions())
    assert thin_walls(cloud).sentence(cloud) == ""


def test_edges_and_noise_are_no_walls():
    rng = np.random.default_rng(1)
    points = rng.uniform(0.0, 40.0, (3200, 3))
    points[np.arange(3200), 2 * (np.arange(3200) % 2)] = 0.0
    cloud = working_cloud(points + 0.4 * rng.normal(size=points.shape), CloudOptions())
    assert thin_walls(cloud).sentence(cloud) == ""
