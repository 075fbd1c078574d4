"""The choice among orientations: the spread tells right from wrong."""

import numpy as np
import pytest

from crispline.cloud.working import working_cloud
from crispline.net.orientation import indicator_spread, oriented_normals
from crispline.net.poisson import point_areas
from crispline.options import CloudOptions, NetOptions


@pytest.fixture(scope="module")
def ball():
    points = np.random.default_rng(0).normal(size=(1500, 3))
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    return working_cloud(points, CloudOptions())


def outward(cloud):
    middle = cloud.to_user.inverse().points(np.zeros(3))
    spoke = cloud.points - middle
    return spoke / np.linalg.norm(spoke, axis=1, keepdims=True)


def test_spread_grows_with_the_share_of_wrong_normals(ball):
    areas = point_areas(ball.distances)
    spreads = []
    for share in (0.0, 0.05, 0.1, 0.2, 0.3):
        normals = outward(ball)
        low = np.argsort(ball.points[:, 2])[: round(share * len(normals))]
        normals[low] *= -1.0
        spreads.append(indicator_spread(ball.points, normals, areas))
    assert spreads[0] < 0.01
    assert (np.diff(spreads) > 0.015).all()


def test_spread_does_not_tell_inside_from_outside(ball):
    areas = point_areas(ball.distances)
    spreads = [indicator_spread(ball.points, s * outward(ball), areas) for s in (1.0, -1.0)]
    assert spreads[0] == pytest.approx(spreads[1], rel=1e-3)


def test_the_choice_is_outward_and_good(ball):
    normals, spread = oriented_normals(ball, NetOptions())
    assert spread < NetOptions().good_spread
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert (np.einsum("ij,ij->i", normals, outward(ball)) > 0.8).all()


def test_without_settings_there_is_nothing_to_choose(ball):
    with pytest.raises(ValueError, match="must not be empty"):
        oriented_normals(ball, NetOptions(normal_neighbours=()))
