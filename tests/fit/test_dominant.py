"""Planes under strips of their neighbours."""

import numpy as np
import pytest

from crispline.fit.choose import choose_surface, refit
from crispline.fit.dominant import dominant_plane, dominates, plane_of_most
from crispline.options import FitOptions
from crispline.surface import Cylinder

SIGMA = 0.3


def strip(seed, n=600, lean_deg=60.0, foreign=0.18):
    """A strip 8 wide; beyond ``|y| = 4 (1 - foreign)`` it leans down as another face does."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-15.0, 15.0, n), rng.uniform(-4.0, 4.0, n)
    edge = 4.0 * (1.0 - foreign)
    beyond = np.maximum(np.abs(y) - edge, 0.0)
    lean = np.radians(lean_deg)
    z = -beyond * np.tan(lean)
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    out = beyond > 0.0
    normals[out] = np.column_stack(
        [0.0 * y[out], np.sign(y[out]) * np.sin(lean), np.full(out.sum(), np.cos(lean))]
    )
    points = np.column_stack([x, y, z]) + SIGMA * rng.normal(size=(n, 1)) * normals
    return points, normals, 4.0 - np.abs(y)


@pytest.mark.parametrize("seed", range(4))
def test_the_plane_below_strips_of_two_neighbours_is_found(seed):
    plane = dominant_plane(*strip(seed), SIGMA)
    assert plane is not None
    assert np.degrees(np.arccos(plane.normal[2])) < 2.0
    assert abs(plane.signed_distance(np.zeros((1, 3)))[0]) < 0.15


@pytest.mark.parametrize("seed", range(4))
def test_a_region_of_such_points_is_that_plane(seed):
    points, normals, clearance = strip(seed)
    fit = choose_surface(points, normals, SIGMA, FitOptions(), border_distance=clearance)
    assert fit.surface.kind == "plane"
    assert fit.is_accepted
    assert np.degrees(np.arccos(fit.surface.normal[2])) < 2.0


def test_a_cylinder_is_no_plane_with_strips():
    rng = np.random.default_rng(0)
    for radius in (6.0, 10.0, 20.0, 40.0):
        angle = rng.uniform(-5.0, 5.0, 400) / radius
        normals = np.column_stack([0.0 * angle, np.sin(angle), np.cos(angle)])
        points = (radius + SIGMA * rng.normal(size=(400, 1))) * normals
        points[:, 0] = rng.uniform(-15.0, 15.0, 400)
        clearance = 5.0 - np.abs(radius * angle)
        assert dominant_plane(points, normals, clearance, SIGMA) is None


def test_two_planes_at_a_small_angle_are_not_one_with_a_strip():
    assert dominant_plane(*strip(0, lean_deg=12.0, foreign=0.5), SIGMA) is None


def test_foreign_points_in_the_middle_speak_against_it():
    points, normals, clearance = strip(1)
    plane = dominant_plane(points, normals, clearance, SIGMA)
    assert plane is not None
    assert dominates(plane, points, normals, clearance, SIGMA)
    assert not dominates(plane, points, normals, 4.0 - clearance, SIGMA)


def test_too_few_points_or_points_on_a_line_have_none():
    points, normals, clearance = strip(2, n=15)
    assert dominant_plane(points, normals, clearance, SIGMA) is None
    line = np.column_stack([np.arange(40.0), np.zeros(40), np.zeros(40)])
    assert dominant_plane(line, np.tile([0.0, 0, 1], (40, 1)), np.ones(40), SIGMA) is None


def running_on(seed, share, radius=10.0, n=400, sigma=0.1):
    """A strip 5 wide and 60 long, flat but for a ``share`` at its end that bends down."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(0.0, 60.0, n), rng.uniform(-2.5, 2.5, n)
    angle = np.maximum(x - 60.0 * (1.0 - share), 0.0) / radius
    across = np.sin(np.pi / 4) * y  # a chamfer, which bends as a cone does
    bend = radius + across
    normals = np.column_stack([np.sin(angle), 0.0 * x, np.ones(n)])
    normals[:, 2] = np.cos(angle)
    flat = np.minimum(x, 60.0 * (1.0 - share))
    places = np.column_stack([flat + bend * np.sin(angle), y, bend * (np.cos(angle) - 1.0)])
    return places + sigma * rng.normal(size=(n, 1)) * normals, normals


@pytest.mark.parametrize("seed", range(4))
def test_a_plane_that_runs_on_into_a_round_is_a_plane(seed):
    points, normals = running_on(seed, 0.08)
    fit = choose_surface(points, normals, 0.1, FitOptions())
    assert fit.surface.kind == "plane"
    assert fit.is_accepted
    assert np.degrees(np.arccos(fit.surface.normal[2])) < 1.0


@pytest.mark.parametrize("seed", range(4))
def test_a_shallow_face_is_curved_all_over(seed):
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-10.0, 10.0, 400) / 60.0  # 0.8 high, 8 sigmas
    normals = np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    points = (60.0 + 0.1 * rng.normal(size=(400, 1))) * normals
    points[:, 1] = rng.uniform(-10.0, 10.0, 400)
    curved = Cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), 60.0)
    assert plane_of_most(points, normals, curved, 0.1) is None
    assert choose_surface(points, normals, 0.1, FitOptions()).surface.kind == "cylinder"


def test_a_cylinder_that_has_become_flat_is_chosen_anew():
    points, normals = running_on(0, 0.0)
    wide = Cylinder(np.array([30.0, 0.0, -3000.0]), np.array([1.0, 0.0, 0.0]), 3000.0)
    assert refit(wide, points, normals, 0.1, FitOptions()) is None


def test_a_few_points_of_another_face_make_no_free_form():
    """A plane of 10 x 8 spacings, with seven points of what lies below it in its middle."""
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(10.0), np.arange(8.0))
    points = np.column_stack([x.ravel(), y.ravel(), 0.16 * rng.normal(size=80)])
    middle = np.argsort(np.hypot(points[:, 0] - 6.3, points[:, 1] - 3.7))[:7]
    points[middle, 2] -= 0.75
    normals = np.tile([0.0, 0.0, 1.0], (80, 1))
    clearance = np.full(80, 1.5)
    fit = choose_surface(points, normals, 0.16, FitOptions(), border_distance=clearance)
    assert fit.surface.kind == "plane"
    assert abs(fit.surface.normal[2]) > 0.999
    assert fit.is_accepted


def test_a_gentle_wave_stays_a_free_form():
    rng = np.random.default_rng(7)
    x, y = np.meshgrid(np.arange(20.0), np.arange(20.0))
    bump = 1.5 * np.exp(-((x - 9.5) ** 2 + (y - 9.5) ** 2) / 12.0)
    points = np.column_stack([x.ravel(), y.ravel(), bump.ravel() + 0.1 * rng.normal(size=400)])
    normals = np.tile([0.0, 0.0, 1.0], (400, 1))
    clearance = np.full(400, 1.5)
    fit = choose_surface(points, normals, 0.1, FitOptions(), border_distance=clearance)
    assert fit.surface.kind != "plane"
