"""Thin walls: seen where there are any, and their sides told apart."""

import numpy as np

from crispline.cloud.working import working_cloud
from crispline.net.sheets import are_apart, has_near_sheets, told_apart
from crispline.options import CloudOptions

SIDE = 40.0


def slab(thickness, n=1600, noise=0.1):
    """Two squares that face away from each other, a point per unit of area, and its normal."""
    rng = np.random.default_rng(0)
    points = np.concatenate([rng.random((n, 3)), rng.random((n, 3))]) * [SIDE, SIDE, 0.0]
    normals = np.zeros_like(points)
    normals[:n, 2], normals[n:, 2] = 1.0, -1.0
    points[:n, 2] = thickness
    cloud = working_cloud(points + noise * rng.normal(size=points.shape), CloudOptions())
    return cloud, normals[cloud.kept]


def test_walls_of_two_spacings_are_near_and_of_eight_are_not():
    thin, normals = slab(2.0)
    assert has_near_sheets(thin, normals)
    assert not has_near_sheets(thin, np.abs(normals))
    thick, normals = slab(8.0)
    assert not has_near_sheets(thick, normals)


def test_normals_that_were_confused_here_and_there_are_put_right():
    cloud, normals = slab(2.0)
    truth = cloud.to_user.inverse().directions(normals)
    confused = (
        np.where(np.random.default_rng(1).random(len(truth)) < 0.1, -1.0, 1.0)[:, None] * truth
    )
    own, found = told_apart(cloud, confused)
    x, y, _ = cloud.to_user.points(cloud.points).T
    inner = (np.abs(x - SIDE / 2) < SIDE / 2 - 4) & (np.abs(y - SIDE / 2) < SIDE / 2 - 4)
    agree = np.einsum("ni,ni->n", found, truth)[inner]
    assert np.mean(agree > 0.9) > 0.99
    assert np.mean(agree > 0.0) > 0.998
    is_mixed = np.einsum("nki,ni->nk", truth[own.neighbours], truth)[inner] < 0.0
    assert is_mixed.mean() < 0.01
    assert (np.einsum("nki,ni->nk", truth[cloud.neighbours], truth)[inner] < 0.0).mean() > 0.2


def test_a_cloud_remembers_that_its_sheets_are_apart():
    cloud, normals = slab(2.0)
    assert not are_apart(cloud)
    assert are_apart(told_apart(cloud, cloud.to_user.inverse().directions(normals))[0])
