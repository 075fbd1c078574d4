"""Surfaces of revolution recovered from noisy points; what is none is refused."""

import numpy as np
import pytest

from crispline.fit.choose import choose_surface
from crispline.fit.revolution import fit_revolution
from crispline.fit.rigid import linearise, move
from crispline.options import FitOptions
from crispline.surface import RevolvedSurface, unit

SIGMA = 0.2
OPTIONS = FitOptions()
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
PLACE = np.array([5.0, -3.0, 8.0])


def _vase(turn=2.0 * np.pi, n=1500, seed=0, sigma=SIGMA, waves=1.0, length=45.0, least=12.0):
    """True points, noisy points and normals of a wavy spindle, all ``(n, 3)``."""
    rng = np.random.default_rng(seed)
    height = rng.uniform(0.0, length, n)
    angle = rng.uniform(-0.5 * turn, 0.5 * turn, n)
    radius = least + 5.0 * waves + 5.0 * waves * np.sin(height / 7.0)
    slope = 5.0 * waves / 7.0 * np.cos(height / 7.0)
    spoke = np.column_stack([np.cos(angle), np.sin(angle)])
    points = np.column_stack([radius[:, None] * spoke, height])
    normals = unit(np.column_stack([spoke, -slope]))
    noisy = points + sigma * rng.normal(size=(n, 1)) * normals
    seen = unit(normals + 0.05 * rng.normal(size=(n, 3)))
    return points @ TURN.T + PLACE, noisy @ TURN.T + PLACE, seen @ TURN.T


def _error(surface, points):
    return float(np.sqrt(np.mean(surface.signed_distance(points) ** 2)))


@pytest.mark.parametrize(("turn", "degrees"), [(2.0 * np.pi, 0.1), (3.1, 0.1), (2.2, 0.3)])
def test_a_spindle_is_recovered_also_from_a_part_of_it(turn, degrees):
    points, noisy, normals = _vase(turn)
    found = fit_revolution(noisy, normals, SIGMA, OPTIONS)
    axis = TURN[:, 2]
    assert abs(found.axis @ axis) > np.cos(np.radians(degrees))
    assert np.linalg.norm(np.cross(found.origin - PLACE, axis)) < 1.0
    assert _error(found, points) < 0.25 * SIGMA
    assert np.mean(np.einsum("ij,ij->i", found.project(points)[1], normals)) > 0.99


def test_the_error_falls_with_the_noise():
    errors = []
    for sigma in (0.4, 0.1):
        clouds = [_vase(seed=seed, sigma=sigma) for seed in range(3)]
        fits = [fit_revolution(noisy, normals, sigma, OPTIONS) for _, noisy, normals in clouds]
        errors.append(
            np.mean([_error(f, points) for f, (points, _, _) in zip(fits, clouds, strict=True)])
        )
    assert errors[1] < 0.5 * errors[0]


def test_a_bore_faces_inwards():
    _, noisy, normals = _vase()
    found = fit_revolution(noisy, -normals, SIGMA, OPTIONS)
    assert np.mean(np.einsum("ij,ij->i", found.project(noisy)[1], normals)) < -0.99


def test_strips_of_a_neighbour_at_its_ends_do_not_bend_it():
    points, noisy, normals = _vase()
    height = (points - PLACE) @ TURN[:, 2]
    strip = height > 43.5
    noisy[strip] += np.outer(height[strip] - 43.5, unit(TURN[:, 0]))
    found = fit_revolution(noisy, normals, SIGMA, OPTIONS, border_distance=45.0 - height)
    assert _error(found, points[height < 42.0]) < 0.3 * SIGMA


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_stepped_bore_is_no_turned_spline(seed):
    # One did go round both of its edges, with no more than noise left, and three faces were one.
    rng = np.random.default_rng(seed)
    turn, along = rng.uniform(0.0, 2.0 * np.pi, 300), rng.uniform(0.0, 15.0, 300)
    spoke = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(300)])
    radius = np.interp(along, [0.0, 6.0, 9.2, 15.0], [3.8, 3.8, 7.0, 7.0])
    height = np.interp(along, [0.0, 6.0, 9.2, 15.0], [-6.0, 0.0, 0.0, 6.0])
    up = np.array([0.0, 0.0, 1.0])
    normals = np.where(((along > 6.0) & (along < 9.2))[:, None], up, -spoke)
    noisy = radius[:, None] * spoke + height[:, None] * up
    noisy += 0.2 * rng.normal(size=(300, 1)) * normals
    clearance = np.minimum(along, 15.0 - along)
    assert fit_revolution(noisy, normals, 0.2, OPTIONS, border_distance=clearance) is None


def test_what_leaves_the_axis_open_or_has_none_is_refused():
    rng = np.random.default_rng(0)
    ball = unit(rng.normal(size=(800, 3)))
    assert fit_revolution(20.0 * ball, ball, SIGMA, OPTIONS) is None
    flat = np.column_stack([rng.uniform(0.0, 30.0, (800, 2)), SIGMA * rng.normal(size=800)])
    up = unit([0.0, 0.0, 1.0] + 0.05 * rng.normal(size=(800, 3)))
    assert fit_revolution(flat, up, SIGMA, OPTIONS) is None
    x, y = rng.uniform(-15.0, 15.0, (2, 1500))
    egg = np.column_stack([x, y, 3.0 * np.sin(x / 4.0) * np.cos(y / 5.0)])
    slope = np.column_stack(
        [
            -0.75 * np.cos(x / 4.0) * np.cos(y / 5.0),
            0.6 * np.sin(x / 4.0) * np.sin(y / 5.0),
            np.ones(1500),
        ]
    )
    assert fit_revolution(egg, unit(slope), 0.1, OPTIONS) is None


def test_a_piece_that_goes_round_too_little_is_left_to_free_forms():
    _, noisy, normals = _vase(1.5)
    assert fit_revolution(noisy, normals, SIGMA, OPTIONS) is None


def test_a_profile_that_comes_to_the_axis_is_refused():
    _, noisy, normals = _vase(least=0.3)
    assert fit_revolution(noisy, normals, SIGMA, OPTIONS) is None


def test_a_spindle_is_chosen_where_no_primitive_is_enough():
    _, noisy, normals = _vase()
    fit = choose_surface(noisy, normals, SIGMA, OPTIONS)
    assert isinstance(fit.surface, RevolvedSurface)
    assert fit.is_accepted
    _, noisy, normals = _vase(waves=0.0)
    assert choose_surface(noisy, normals, SIGMA, OPTIONS).surface.kind == "cylinder"
    _, noisy, normals = _vase(length=8.0)
    assert choose_surface(noisy, normals, SIGMA, OPTIONS).surface.kind != "revolution"


def test_derivatives_of_its_place_are_those_of_the_distances():
    points, noisy, normals = _vase(n=600)
    surface = fit_revolution(noisy, normals, SIGMA, OPTIONS)
    inner = np.abs((points - points.mean(axis=0)) @ TURN[:, 2]) < 18.0
    _, jacobian = linearise(surface, noisy[inner])
    h = 1e-5
    for column, step in enumerate(np.eye(5)):
        ahead, behind = (
            move(surface, sign * h * step).signed_distance(noisy[inner]) for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(jacobian[:, column], (ahead - behind) / (2 * h), atol=1e-5)
