from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.cloud.average import _packed, averaged, points_per_mean
from crispline.cloud.thin import thin_walls
from crispline.cloud.working import working_cloud
from crispline.options import CloudOptions

OPTIONS = CloudOptions()


def sphere(n, noise, seed=0):
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return directions * (10.0 + noise * rng.normal(size=(n, 1)))


def greedy(points, distance):
    """The definition of `_packed`, one point after the other."""
    rank = np.empty(len(points), dtype=int)
    rank[np.lexsort(points.T)] = np.random.default_rng(0).permutation(len(points))
    taken = []
    for index in np.argsort(rank):
        if all(np.linalg.norm(points[index] - points[other]) > distance for other in taken):
            taken.append(index)
    return np.sort(taken)


@pytest.mark.parametrize("distance", [0.02, 0.1, 0.5])
def test_points_are_picked_as_one_after_the_other(distance):
    points = np.random.default_rng(1).uniform(size=(400, 3))
    np.testing.assert_array_equal(_packed(points, distance), greedy(points, distance))


def test_a_clean_cloud_stays():
    cloud = working_cloud(sphere(4000, 0.03), OPTIONS)
    assert cloud.sigma < OPTIONS.max_noise
    assert averaged(cloud, OPTIONS) is cloud


@pytest.mark.parametrize("sigma", [0.5, 0.8, 1.2])
def test_noise_falls_to_what_is_asked(sigma):
    n = 20_000
    spacing = np.sqrt(4.0 * np.pi * 100.0 / n)
    cloud = working_cloud(sphere(n, sigma * spacing), OPTIONS)
    means = averaged(cloud, OPTIONS)
    # Noise over a spacing is estimated too low, so that the means keep more than asked.
    assert 0.75 < means.sigma / OPTIONS.average_noise < (1.25 if sigma < 1.0 else 1.6)
    assert len(means.scan) == len(cloud.points)
    # The noise of the scan, and the means on the sphere with no bias beyond that of its bend.
    assert means.scan_noise * means.sigma * means.spacing == pytest.approx(
        cloud.sigma * cloud.spacing, rel=1e-12
    )
    radius = np.linalg.norm(means.to_user.points(means.points), axis=1)
    assert abs(np.median(radius) - 10.0) < 0.1 * means.spacing
    assert np.std(radius) < 1.3 * means.sigma * means.spacing
    np.testing.assert_allclose(
        means.to_user.points(means.scan), cloud.to_user.points(cloud.points), atol=1e-9
    )


def test_means_are_told_and_named():
    cloud = averaged(working_cloud(sphere(8000, 0.4), OPTIONS), OPTIONS)
    assert any("averages of about" in text for text in cloud.warnings())


def test_means_do_not_depend_on_order_unit_or_place():
    points = sphere(2900, 0.7)  # few enough that the noise is estimated from all
    first = averaged(working_cloud(points, OPTIONS), OPTIONS)
    shuffled = np.random.default_rng(2).permutation(points) * 2.0**10
    second = averaged(working_cloud(shuffled, OPTIONS), OPTIONS)
    assert len(first.points) == len(second.points)
    distance, _ = cKDTree(first.points).query(second.points)
    assert distance.max() < 1e-6


def test_the_row_of_a_mean_is_the_point_it_lies_round():
    points = sphere(6000, 0.6)
    cloud = averaged(working_cloud(points, OPTIONS), OPTIONS)
    away = np.linalg.norm(points[cloud.kept] - cloud.to_user.points(cloud.points), axis=1)
    assert away.max() < 4.0 * (0.5 + cloud.spacing)


def test_the_sides_of_a_thin_wall_are_no_noise():
    rng = np.random.default_rng(3)
    points = rng.uniform(0.0, 50.0, (5000, 3))
    points[:, 2] = np.arange(5000) % 2 + 0.03 * rng.normal(size=5000)
    cloud = replace(working_cloud(points, OPTIONS), sigma=0.5)
    assert thin_walls(cloud).share > 0.1
    assert averaged(cloud, OPTIONS) is cloud


def test_a_very_large_cloud_is_averaged_to_a_moderate_one():
    points = sphere(12_000, 0.002)
    cloud = working_cloud(points, OPTIONS)
    means = averaged(cloud, replace(OPTIONS, max_points=3000))
    assert 2000 < len(means.points) <= 3000
    radius = np.linalg.norm(means.to_user.points(means.points), axis=1)
    assert np.abs(radius - 10.0).max() < 0.1 * means.spacing
    assert points_per_mean(12_000, cloud.sigma, OPTIONS) == 1.0
    assert points_per_mean(12_000, cloud.sigma, replace(OPTIONS, max_points=11_999)) == 1.5


def test_a_cloud_without_noise_has_none_after_averaging():
    rng = np.random.default_rng(4)
    points = rng.uniform(-1.0, 1.0, (4000, 3))
    points[np.arange(4000), np.arange(4000) % 3] = np.where(rng.random(4000) < 0.5, -1.0, 1.0)
    cloud = averaged(working_cloud(points, OPTIONS), replace(OPTIONS, max_points=1500))
    assert len(cloud.points) <= 1500
    assert 0.0 <= cloud.scan_noise * cloud.sigma < 1e-4
    assert any("averages of about" in text for text in cloud.warnings())


def test_noise_that_neighbours_share_counts_as_a_whole():
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-35.0, 35.0, (2, 4900))
    waves, phase = rng.normal(size=(40, 2)) * 0.5, rng.uniform(0.0, 2.0 * np.pi, 40)
    ripple = np.cos(np.column_stack([x, y]) @ waves.T + phase).sum(axis=1)
    z = 0.15 * rng.normal(size=len(x)) + 0.45 * ripple / ripple.std()
    cloud = working_cloud(np.column_stack([x, y, z]), OPTIONS)
    assert cloud.sigma < OPTIONS.max_noise
    assert len(averaged(cloud, OPTIONS).points) < 0.6 * len(cloud.points)
