"""Half the wall of a narrow bore, turned round, is turned back; right signs stay."""

import numpy as np
import pytest

from crispline.cloud.working import working_cloud
from crispline.net import orientation, places
from crispline.net.places import with_places_turned
from crispline.net.poisson import poisson_indicator
from crispline.options import CloudOptions, NetOptions


@pytest.fixture(scope="module")
def bored():
    """A block of 26 x 26 x 12 spacings with a bore of radius 2.5, and its outward normals."""
    rng = np.random.default_rng(4)
    size, radius = np.array([26.0, 26.0, 12.0]), 2.5
    points, normals = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            n = int(np.prod(np.delete(size, axis)))
            face = rng.uniform(-0.5, 0.5, (n, 3)) * size
            face[:, axis] = 0.5 * side * size[axis]
            points.append(face[(axis < 2) | (np.hypot(face[:, 0], face[:, 1]) > radius)])
            normals.append(np.broadcast_to(side * np.eye(3)[axis], points[-1].shape))
    angle, level = rng.uniform(0.0, 2.0 * np.pi, 188), rng.uniform(-6.0, 6.0, 188)
    inward = np.stack([-np.cos(angle), -np.sin(angle), 0.0 * angle], axis=1)
    points.append(-radius * inward + level[:, None] * [0.0, 0.0, 1.0])
    normals.append(inward)
    cloud = working_cloud(np.concatenate(points), CloudOptions())
    assert len(cloud.points) == sum(map(len, points))
    return cloud, cloud.to_user.inverse().directions(np.concatenate(normals))


def turned(cloud, normals):
    return with_places_turned(cloud, normals, NetOptions().normal_neighbours)


def test_half_a_bore_the_wrong_way_round_is_turned_back(bored):
    cloud, outward = bored
    is_wrong = np.arange(len(outward)) >= len(outward) - 188
    across = cloud.to_user.points(cloud.points)[:, 0] > 0.3
    normals = np.where((is_wrong & across)[:, None], -outward, outward)
    assert (normals != outward).any(axis=1).sum() > 70
    left = (turned(cloud, normals) != outward).any(axis=1)
    assert left.sum() < 8


def test_right_signs_stay(bored):
    cloud, outward = bored
    np.testing.assert_array_equal(turned(cloud, outward), outward)


def test_the_field_of_dipoles_is_that_of_the_grid(bored):
    cloud, outward = bored
    rows = np.arange(len(outward) - 188, len(outward))
    normals = np.zeros_like(outward)
    normals[rows] = outward[rows]
    grid = poisson_indicator(cloud.points, normals, np.ones(len(outward)), 0.7)
    step = grid.cell * outward[rows]
    at = cloud.points[rows]
    width = places._WIDENING * grid.cell
    for side in (-1.0, 1.0):
        field = places._dipoles(at + side * step, at, outward[rows], width).sum(axis=1)
        assert np.std(field - grid.at(at + side * step)) < 0.03


@pytest.mark.parametrize("spread", [0.08, 0.15])
def test_every_orientation_is_looked_through(bored, monkeypatch, spread):
    cloud, outward = bored
    normals = outward.copy()
    bore = np.arange(len(outward) - 188, len(outward))
    normals[bore[cloud.to_user.points(cloud.points[bore])[:, 0] > 0.3]] *= -1.0
    tree = orientation.Orientation(cloud, normals, spread)
    monkeypatch.setattr(orientation, "best_tree", lambda *given: tree)
    found = orientation.oriented_normals(cloud, NetOptions())
    assert (np.einsum("ni,ni->n", found.normals, outward) < 0.0).sum() < 8


def test_a_face_the_wrong_way_round_is_turned_back_though_trees_look_good(bored, monkeypatch):
    cloud, outward = bored
    user = cloud.to_user.points(cloud.points)
    is_side = user[:, 0] > user[:, 0].max() - 0.5
    assert is_side.sum() > 200
    normals = np.where(is_side[:, None], -outward, outward)
    tree = orientation.Orientation(cloud, normals, 0.99 * NetOptions().good_spread * 0.65)
    monkeypatch.setattr(orientation, "best_tree", lambda *given: tree)
    found = orientation.oriented_normals(cloud, NetOptions())
    assert (np.einsum("ni,ni->n", found.normals, outward) < 0.0).sum() < 8
