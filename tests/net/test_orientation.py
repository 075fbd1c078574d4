"""The choice among orientations: the spread tells right from wrong."""

import re
from dataclasses import replace

import numpy as np
import pytest

from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.working import working_cloud
from crispline.errors import InputError
from crispline.net.halfedge import half_edges
from crispline.net.orientation import best_tree, indicator_spread, oriented_normals
from crispline.net.poisson import point_areas
from crispline.net.quads import quad_net
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
    found = oriented_normals(ball, NetOptions())
    normals = found.normals
    assert found.spread < NetOptions().good_spread
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    assert (np.einsum("ij,ij->i", normals, outward(ball)) > 0.8).all()


def test_without_settings_there_is_nothing_to_choose(ball):
    with pytest.raises(ValueError, match="must not be empty"):
        oriented_normals(ball, NetOptions(normal_neighbours=()))


# --- what the file tells ------------------------------------------------------------------


def shell(size, wall):
    """A box with a cavity, walls so thick all round: a point per unit of area, and its normal."""
    rng = np.random.default_rng(0)
    points, normals = [], []
    for low, side in ((0.0, 1.0), (wall, -1.0)):
        sides = np.array(size) - (2.0 * wall if side < 0.0 else 0.0)
        for axis in range(3):
            n = round(sides.prod() / sides[axis])
            for at in (0.0, 1.0):
                face = rng.random((n, 3))
                face[:, axis] = at
                points.append(low + face * sides)
                normals.append(np.tile(side * (2.0 * at - 1.0) * np.eye(3)[axis], (n, 1)))
    clean = np.concatenate(points)
    return clean + 0.05 * rng.normal(size=clean.shape), np.concatenate(normals)


@pytest.fixture(scope="module")
def thin():
    """A cloud with walls of 1.7, and its outward normals."""
    return shell((24.0, 21.0, 18.0), 1.7)


QUICK = NetOptions(normal_neighbours=(18,))


def oriented(points, normals=None, viewpoints=None, use="auto"):
    given = PointCloud.from_arrays(points, normals, viewpoints)
    cloud = working_cloud(given.points, CloudOptions())
    return oriented_normals(cloud, replace(QUICK, normals=use), given=given)


def share_right(found, truth):
    told = found.cloud.to_user.inverse().directions(truth[found.cloud.kept])
    return np.mean(np.einsum("ij,ij->i", found.normals, told) > 0.0)


def test_normals_of_the_file_tell_the_two_sides_of_a_thin_wall(thin):
    points, normals = thin
    found = oriented(points, normals)
    assert found.is_sided
    assert found.notes == ()
    assert share_right(found, normals) > 0.998
    assert share_right(oriented(points, normals, use="none"), normals) < 0.9


def test_the_net_over_a_thin_wall_is_closed_and_has_both_sides(thin):
    points, normals = thin
    found = oriented(points, normals)
    net = quad_net(found.cloud, found.normals, QUICK)
    sides = half_edges(net.quads, len(net.vertices))
    assert not net.is_open
    assert sides.is_closed
    # Two spheres: the outside and the cavity.
    assert len(net.vertices) - len(sides.pairs()) + len(net.quads) == 4
    a, b, c, d = (found.cloud.to_user.points(net.vertices[corner]) for corner in net.quads.T)
    volume = np.einsum("ij,ij->i", a + b + c + d, np.cross(c - a, d - b)).sum() / 24.0
    true = 24.0 * 21.0 * 18.0 - (24.0 - 3.4) * (21.0 - 3.4) * (18.0 - 3.4)
    assert volume == pytest.approx(true, rel=0.03)


def test_the_indicator_tells_the_two_sides_of_a_thin_wall():
    points, normals = shell((24.0, 21.0, 18.0), 2.0)
    cloud = working_cloud(points, CloudOptions())
    mixed = best_tree(cloud, NetOptions())
    assert share_right(mixed, normals) < 0.99
    found = oriented_normals(cloud, NetOptions())
    assert found.is_sided
    assert share_right(found, normals) > 0.998
    net = quad_net(found.cloud, found.normals, NetOptions())
    sides = half_edges(net.quads, len(net.vertices))
    assert sides.is_closed
    assert len(net.vertices) - len(sides.pairs()) + len(net.quads) == 4


def test_normals_that_all_look_inward_do_not_turn_the_part_inside_out(thin):
    points, normals = thin
    found = oriented(points, -normals)
    assert found.is_sided
    assert share_right(found, normals) > 0.998


def test_a_cavity_looks_into_itself():
    points, normals = shell((22.0, 20.0, 18.0), 6.0)
    assert share_right(oriented(points, normals), normals) > 0.99
    assert share_right(oriented(points), normals) < 0.9


def test_random_signs_are_not_believed(ball):
    points = ball.to_user.points(ball.points)
    wrong = np.random.default_rng(1).random(len(points)) < 0.1
    told = np.where(wrong[:, None], -points, points)
    found = oriented(points, told)
    assert not found.is_sided
    (note,) = found.notes
    assert re.fullmatch(r"normals of the file contradict each other at (9|10) % .*", note)
    np.testing.assert_array_equal(found.normals, oriented(points).normals)
    assert oriented(points, told, use="file").is_sided


def test_a_region_that_looks_the_wrong_way_is_not_believed(ball):
    points = ball.to_user.points(ball.points)
    told = np.where(points[:, 2:] < 0.4, points, -points)
    found = oriented(points, told)
    assert not found.is_sided
    assert found.notes == ("normals of the file fit the points badly: not used",)
    assert share_right(found, points) == 1.0


def test_normals_that_are_missing_at_many_points_are_not_used(ball):
    points = ball.to_user.points(ball.points)
    told = np.where(np.arange(len(points))[:, None] % 5, points, np.nan)
    found = oriented(points, told)
    assert found.notes == ("normals of the file are missing at 20 % of the points: not used",)
    assert share_right(found, points) == 1.0


def test_a_room_scanned_from_within_is_a_body_like_any_other(ball):
    points = ball.to_user.points(ball.points)
    found = oriented(points, viewpoints=np.tile([0.1, 0.2, -0.1], (len(points), 1)))
    assert found.is_sided
    assert share_right(found, points) == 1.0


def test_the_seen_side_of_an_open_scan_is_outside():
    """A bowl seen from above: without the scanner its outside would be the outside of a ball."""
    rng = np.random.default_rng(0)
    points = rng.normal(size=(3000, 3))
    points = 20.0 * points / np.linalg.norm(points, axis=1, keepdims=True)
    points = points[points[:, 2] < 0.0]
    found = oriented(points, viewpoints=np.tile([0.0, 0.0, 50.0], (len(points), 1)))
    assert found.is_sided
    assert share_right(found, -points) == 1.0


def test_normals_count_before_scanner_positions_and_these_where_normals_fail(ball):
    points = ball.to_user.points(ball.points)
    stations = 3.0 * points
    wrong = np.random.default_rng(1).random(len(points)) < 0.3
    found = oriented(points, np.where(wrong[:, None], -points, points), stations)
    assert found.is_sided
    assert found.notes == (
        "normals of the file contradict each other at 30 % of the points: not used",
    )


def test_a_cloud_without_normals_is_oriented_as_before(ball):
    points = ball.to_user.points(ball.points)
    np.testing.assert_array_equal(oriented(points).normals, oriented_normals(ball, QUICK).normals)


def test_normals_asked_for_must_be_there(ball):
    with pytest.raises(InputError, match="it has points only"):
        oriented(ball.to_user.points(ball.points), use="file")
