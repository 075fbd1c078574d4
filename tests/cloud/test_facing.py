"""Sides that a file tells: against exact normals of thin walls, and in files that are wrong."""

import numpy as np
import pytest

from crispline.cloud.facing import Hint, facing, hints, separated
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.working import working_cloud
from crispline.options import CloudOptions

NOISE = 0.05


def plate(thickness, seed=0):
    """The two large sides of a plate, a point per unit of area, and its outward normals."""
    rng = np.random.default_rng(seed)
    sides = np.repeat([-1.0, 1.0], 1200)
    points = np.column_stack([rng.uniform(0.0, [40.0, 30.0], (2400, 2)), sides * thickness / 2.0])
    normals = sides[:, None] * [0.0, 0.0, 1.0]
    return points + NOISE * rng.normal(size=points.shape), normals


def given(points, normals=None, viewpoints=None):
    cloud = PointCloud.from_arrays(points, normals, viewpoints)
    working = working_cloud(cloud.points, CloudOptions())
    return cloud, working


def share_outward(found, normals):
    """Of the points, how many look as the truth does."""
    truth = found.cloud.to_user.inverse().directions(normals[found.cloud.kept])
    return np.mean(np.einsum("ni,ni->n", found.normals, truth) > 0.9)


@pytest.mark.parametrize("thickness", [1.0, 1.5, 2.0, 2.5])
def test_both_sides_of_a_thin_plate(thickness):
    points, normals = plate(thickness)
    cloud, working = given(points, normals)
    (hint,) = hints(cloud, working)
    found = facing(working, hint, 18)
    assert share_outward(found, normals) > 0.995
    assert found.contradiction < 0.005


def test_neighbours_are_the_nearest_on_the_own_side():
    points, normals = plate(1.5)
    cloud, working = given(points, normals)
    (hint,) = hints(cloud, working)
    found = separated(working, hint.directions)
    side = np.sign(normals[working.kept, 2])
    for i in range(0, len(side), 31):
        own = np.flatnonzero(side == side[i])
        distance = np.linalg.norm(working.points[own] - working.points[i], axis=1)
        nearest = own[np.argsort(distance)]
        is_own = side[found.neighbours[i]] == side[i]
        assert is_own.all()
        # Of the 48 nearest on both sides at least 16 are on the own one.
        np.testing.assert_array_equal(found.neighbours[i, :16], nearest[:16])
        np.testing.assert_allclose(found.distances[i, :16], np.sort(distance)[:16])
    assert found.sigma * working.spacing == pytest.approx(NOISE, rel=0.1)


def test_a_cloud_without_a_second_side_stays_as_it_is():
    points = np.random.default_rng(0).normal(size=(1500, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    cloud, working = given(points, points)
    (hint,) = hints(cloud, working)
    found = separated(working, hint.directions)
    np.testing.assert_array_equal(found.neighbours, working.neighbours)
    np.testing.assert_array_equal(found.distances, working.distances)
    assert found.sigma == working.sigma


def test_the_majority_decides_and_the_rest_is_counted():
    points, normals = plate(8.0)
    wrong = np.random.default_rng(1).random(len(points)) < 0.1
    told = np.where(wrong[:, None], -normals, normals)
    cloud, working = given(points, told)
    (hint,) = hints(cloud, working)
    found = facing(working, hint, 18)
    assert found.contradiction == pytest.approx(wrong.mean(), abs=0.01)
    assert share_outward(found, normals) > 0.99


def test_points_without_a_normal_follow_their_neighbours():
    points, normals = plate(8.0)
    cloud, working = given(points, np.where(np.arange(len(points))[:, None] % 4, normals, np.nan))
    (hint,) = hints(cloud, working)
    assert hint.missing == pytest.approx(0.25)
    found = facing(working, hint, 18)
    assert share_outward(found, normals) > 0.99
    assert found.contradiction < 0.005


def test_scanner_positions_tell_the_side_that_was_seen():
    """One station above, one below, so that each saw one side, and both obliquely."""
    points, normals = plate(1.5)
    stations = np.where(normals[:, 2:] > 0.0, [-10.0, 15.0, 25.0], [45.0, 10.0, -25.0])
    cloud, working = given(points, viewpoints=stations)
    (hint,) = hints(cloud, working)
    assert hint.source == "scanner positions"
    assert share_outward(facing(working, hint, 18), normals) > 0.99


def test_the_rows_of_the_file_survive_duplicates_and_outliers():
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(1500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    points = 10.0 * directions
    strays = rng.uniform(20.0, 40.0, (30, 3))
    rows = np.concatenate([points[:50], strays, points])
    looks = np.concatenate([directions[:50], -np.ones((30, 3)), directions])
    cloud, working = given(rows, looks)
    assert working.n_duplicates == 50
    assert working.n_outliers >= 25
    np.testing.assert_allclose(
        working.to_user.points(working.points), rows[working.kept], atol=1e-5
    )
    (hint,) = hints(cloud, working)
    outward = working.to_user.directions(hint.directions)
    is_sphere = np.linalg.norm(rows[working.kept], axis=1) < 11.0
    np.testing.assert_allclose(outward[is_sphere], rows[working.kept][is_sphere] / 10.0, atol=1e-9)


def test_nothing_known_of_a_point_that_stood_in_the_scanner():
    points, _ = plate(8.0)
    cloud, working = given(points, viewpoints=points)
    (hint,) = hints(cloud, working)
    assert hint.missing > 0.99
    assert Hint("normals", np.eye(3), True).missing == 0.0
