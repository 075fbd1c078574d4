"""The revolved surface against its definition; its profile against the curve it is a piece of."""

import numpy as np
import pytest

from crispline.surface import Profile, RevolvedSurface, Similarity, unit
from crispline.surface.basis import uniform_knots

RNG = np.random.default_rng(0)
AXIS = unit(np.array([2.0, -1.0, 2.0]))
ORIGIN = np.array([1.0, 2.0, 3.0])
KNOTS = uniform_knots(-3.0, 5.0, 4)
CONTROLS = np.column_stack([[6.0, 7, 5, 4, 6, 8, 7], np.linspace(-6.0, 10.0, 7)])
PROFILE = Profile(KNOTS, CONTROLS)
SURFACE = RevolvedSurface(ORIGIN, AXIS, PROFILE)


def _turn():
    turn = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    return turn * np.sign(np.linalg.det(turn))


def _around(n=300, reach=2.0):
    """Feet, normals and points off them along the normals, all ``(n, 3)``; and how far."""
    t, angle = RNG.uniform(-2.5, 4.5, n), RNG.uniform(-np.pi, np.pi, n)
    at, along, _ = PROFILE.derivatives(t)
    x = unit(np.cross(AXIS, [0.0, 0.0, 1.0]))
    spoke = np.outer(np.cos(angle), x) + np.outer(np.sin(angle), np.cross(AXIS, x))
    feet = ORIGIN + at[:, :1] * spoke + at[:, 1:] * AXIS
    normals = unit(along[:, 1:] * spoke - along[:, :1] * AXIS)
    far = RNG.uniform(-reach, reach, n)
    return feet, normals, feet + far[:, None] * normals, far


def test_points_beside_it_have_their_feet_on_it():
    feet, normals, points, far = _around()
    found, facing = SURFACE.project(points)
    np.testing.assert_allclose(found, feet, atol=1e-9)
    np.testing.assert_allclose(facing, normals, atol=1e-9)
    np.testing.assert_allclose(SURFACE.signed_distance(points), far, atol=1e-9)


def test_no_sample_of_the_profile_is_nearer_than_the_foot():
    flat = RNG.uniform([0.0, -10.0], [15.0, 15.0], (400, 2))
    t = PROFILE.feet(flat)
    found = np.linalg.norm(flat - PROFILE.derivatives(t)[0], axis=1)
    dense = PROFILE.derivatives(np.linspace(-3.0, 5.0, 4001))[0]
    nearest = np.linalg.norm(flat[:, None] - dense, axis=2).min(axis=1)
    assert (found <= nearest + 1e-9).all()


def test_the_normal_is_the_gradient_of_the_distance():
    _, normals, points, _ = _around(100)
    h = 1e-5
    gradient = [
        (SURFACE.signed_distance(points + h * e) - SURFACE.signed_distance(points - h * e))
        / (2 * h)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(np.stack(gradient, axis=1), normals, atol=1e-5)


def test_a_similarity_moves_feet_along():
    _, _, points, far = _around()
    similarity = Similarity(2.5, _turn(), np.array([1.0, 2.0, 3.0]))
    moved = SURFACE.transformed(similarity)
    np.testing.assert_allclose(
        moved.signed_distance(similarity.points(points)), 2.5 * far, atol=1e-8
    )


def test_points_on_the_axis_get_one_of_their_feet():
    points = ORIGIN + np.outer([-2.0, 0.0, 4.0], AXIS)
    feet, normals = SURFACE.project(points)
    assert np.isfinite(feet).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    np.testing.assert_allclose(
        SURFACE.flattened(feet), PROFILE.derivatives(PROFILE.feet(SURFACE.flattened(points)))[0]
    )


def test_its_numbers_tell_the_whole_of_it():
    told = SURFACE.parameters()
    profile = Profile(np.array(told["knots"]), np.column_stack([told["radii"], told["heights"]]))
    again = RevolvedSurface(np.array(told["origin"]), np.array(told["axis"]), profile)
    points = _around()[2]
    np.testing.assert_allclose(again.signed_distance(points), SURFACE.signed_distance(points))
    assert SURFACE.n_parameters == 7 + 4


def test_a_profile_run_backwards_faces_the_other_way():
    _, normals, points, far = _around()
    other = RevolvedSurface(ORIGIN, AXIS, PROFILE.reversed())
    np.testing.assert_allclose(other.signed_distance(points), -far, atol=1e-9)
    np.testing.assert_allclose(other.project(points)[1], -normals, atol=1e-9)


@pytest.mark.parametrize("ends", [(-3.0, 5.0), (-1.0, 5.0), (-3.0, 2.3), (-2.2, 1.7), (0.1, 0.4)])
def test_a_piece_of_a_profile_is_the_profile_there(ends):
    piece = PROFILE.between(*ends)
    assert piece.interval == ends
    assert len(piece.knots) == len(piece.control_points) + 4
    t = np.linspace(*ends, 40)
    np.testing.assert_allclose(piece.derivatives(t), PROFILE.derivatives(t), atol=1e-9)


def test_what_is_too_near_the_axis_is_cut_away():
    assert PROFILE.clear_of(1.0, 0.0) is PROFILE
    bent = Profile(KNOTS, np.column_stack([[6.0, 7, 5, 4, 2, -2, -3], CONTROLS[:, 1]]))
    clear = bent.clear_of(1.0, -1.0)
    radii = clear.derivatives(np.linspace(*clear.interval, 200), 0)[0][:, 0]
    assert clear.interval[0] == -3.0
    assert 1.0 < radii.min() < 2.0
