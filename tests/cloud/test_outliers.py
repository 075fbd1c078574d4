"""Outliers go, thinly scanned surface stays, whatever the unit."""

import numpy as np
import pytest

from crispline.cloud.outliers import inliers
from crispline.options import CloudOptions


def box(n, seed=0, noise=0.0):
    """Random points on a box of 20 x 15 x 10."""
    rng = np.random.default_rng(seed)
    sides = np.array([20.0, 15.0, 10.0])
    areas = np.repeat([sides[1] * sides[2], sides[2] * sides[0], sides[0] * sides[1]], 2)
    side = rng.choice(6, n, p=areas / areas.sum())
    points = rng.uniform(0.0, 1.0, (n, 3)) * sides
    points[np.arange(n), side // 2] = sides[side // 2] * (side % 2)
    return points + rng.normal(size=(n, 3)) * noise


@pytest.mark.parametrize("scale", [1.0, 1e-3])
def test_a_clean_scan_keeps_its_points(scale):
    points = scale * box(6000, noise=0.05)
    assert len(inliers(points, CloudOptions())) >= 0.998 * len(points)


def test_density_falling_ten_to_one_is_no_outlier():
    points = box(16000, noise=0.02)
    rng = np.random.default_rng(1)
    points = points[rng.uniform(size=len(points)) < 10.0 ** (-points[:, 0] / 20.0)]
    kept = inliers(points, CloudOptions())
    assert len(kept) >= 0.995 * len(points)
    assert points[kept][:, 0].max() > 19.5


def test_far_outliers_go_at_thirty_percent():
    surface = box(8000)
    noise = np.random.default_rng(2).uniform([-2.0] * 3, [22.0, 17.0, 12.0], (2400, 3))
    inside = np.minimum(noise, np.array([20.0, 15.0, 10.0]) - noise).min(axis=1)
    outside = np.linalg.norm(noise - np.clip(noise, 0.0, [20.0, 15.0, 10.0]), axis=1)
    distance = np.where(inside > 0.0, inside, outside)
    spacing = np.sqrt(1300.0 / 8000)
    kept = inliers(np.concatenate([surface, noise]), CloudOptions())
    assert np.sum(kept < 8000) >= 0.995 * 8000
    left = distance[kept[kept >= 8000] - 8000] / spacing
    assert np.mean(distance / spacing > 3.0) > 0.4  # of all that were there
    assert (left > 3.0).sum() <= 5


def test_few_points_are_left_alone():
    points = np.random.default_rng(3).normal(size=(20, 3))
    np.testing.assert_array_equal(inliers(points, CloudOptions()), np.arange(20))


def test_a_sudden_change_of_density_on_a_surface_is_no_outlier():
    rng = np.random.default_rng(4)
    dense = rng.uniform(0.0, 10.0, (4000, 3)) * [1, 1, 0]
    thin = rng.uniform(0.0, 10.0, (400, 3)) * [1, 1, 0] + [10, 0, 0]
    points = np.concatenate([dense, thin]) + 0.01 * rng.normal(size=(4400, 3))
    hanging = points[:60] + np.array([0, 0, 1.0])
    kept = inliers(np.concatenate([points, hanging]), CloudOptions())
    assert np.sum(kept < 4400) >= 4398
    assert np.sum(kept >= 4400) == 0
