"""Surfaces of extrusion recovered from noisy points; what is none is refused."""

import numpy as np
import pytest

from crispline.fit.bspline import PassThrough, fit_bspline_surface
from crispline.fit.choose import choose_surface
from crispline.fit.extrusion import fit_extrusion
from crispline.options import FitOptions
from crispline.surface import ExtrudedSurface, unit

SIGMA = 0.2
OPTIONS = FitOptions()
TURN = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]


def _ribbon(half_turn, n=1200, seed=0, waves=2.0, start=None):
    """Points and normals of a wavy arc swept over 20 spacings, both ``(n, 3)``."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-half_turn if start is None else start, half_turn, n)
    radius = 20.0 + 4.0 * np.sin(waves * angle)
    change = 4.0 * waves * np.cos(waves * angle)
    sine, cosine = np.sin(angle), np.cos(angle)
    along = np.column_stack([change * sine + radius * cosine, change * cosine - radius * sine])
    normals = np.column_stack([unit(np.column_stack([-along[:, 1], along[:, 0]])), np.zeros(n)])
    points = np.column_stack([radius * sine, radius * cosine, rng.uniform(0.0, 20.0, n)])
    noisy = points + SIGMA * rng.normal(size=(n, 1)) * normals
    seen = unit(normals + 0.05 * rng.normal(size=(n, 3)))
    return points @ TURN.T, noisy @ TURN.T, seen @ TURN.T


@pytest.mark.parametrize("half_turn", [0.8, 2.6])
def test_a_ribbon_is_recovered_also_where_it_turns_back(half_turn):
    points, noisy, normals = _ribbon(half_turn)
    found = fit_extrusion(noisy, normals, SIGMA, OPTIONS)
    assert abs(found.direction @ TURN[:, 2]) > np.cos(np.radians(0.2))
    assert np.sqrt(np.mean(found.signed_distance(points) ** 2)) < 0.3 * SIGMA
    assert np.mean(np.einsum("ij,ij->i", found.project(points)[1], normals)) > 0.99


def test_it_is_nearer_to_the_truth_than_a_free_spline():
    points, noisy, normals = _ribbon(0.8)
    swept = fit_extrusion(noisy, normals, SIGMA, OPTIONS)
    free = fit_bspline_surface(noisy, normals, SIGMA, OPTIONS)
    error = [np.sqrt(np.mean(s.signed_distance(points) ** 2)) for s in (swept, free)]
    assert error[0] < 0.8 * error[1]


def test_it_goes_on_straight_beyond_its_points():
    points, noisy, normals = _ribbon(0.8)
    height = (points - points.mean(axis=0)) @ TURN[:, 2]
    beyond = points + 5.0 * np.outer(np.sign(height), TURN[:, 2])
    found = fit_extrusion(noisy, normals, SIGMA, OPTIONS)
    assert np.abs(found.signed_distance(beyond)).max() < SIGMA


def test_it_passes_through_what_it_has_to_meet():
    points, noisy, normals = _ribbon(0.8)
    end = np.argsort(points @ TURN[:, 0])[:8]
    held = PassThrough(points[end], np.empty((0, 3)))
    found = fit_extrusion(noisy, normals, SIGMA, OPTIONS, held)
    assert np.abs(found.signed_distance(points[end])).max() < 0.02


def test_a_closed_profile_is_refused():
    _, noisy, normals = _ribbon(np.pi)
    assert fit_extrusion(noisy, normals, SIGMA, OPTIONS) is None


def test_a_plane_and_a_sphere_have_no_rulings():
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.uniform(0.0, 20.0, (400, 2)), SIGMA * rng.normal(size=400)])
    up = np.tile([0.0, 0.0, 1.0], (400, 1))
    assert fit_extrusion(flat, unit(up + 0.05 * rng.normal(size=(400, 3))), SIGMA, OPTIONS) is None
    ball = unit(rng.normal(size=(400, 3)) * [0.5, 0.5, 0.1] + [0.0, 0.0, 1.0])
    assert fit_extrusion(30.0 * ball, ball, SIGMA, OPTIONS) is None


def test_a_ribbon_is_chosen_before_a_free_form_and_an_arc_stays_a_cylinder():
    _, noisy, normals = _ribbon(0.8)
    assert isinstance(choose_surface(noisy, normals, SIGMA, OPTIONS).surface, ExtrudedSurface)
    _, noisy, normals = _ribbon(0.8, waves=0.0)
    assert choose_surface(noisy, normals, SIGMA, OPTIONS).surface.kind == "cylinder"
