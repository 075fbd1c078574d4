import numpy as np
import pytest

from crispline.fit.choose import KINDS, PRIMITIVE_FITS, choose_surface, refit
from crispline.fit.verdict import explains
from crispline.options import FitOptions
from crispline.surface import Cylinder

OPTIONS = FitOptions()


@pytest.mark.parametrize("kind", list(PRIMITIVE_FITS))
@pytest.mark.parametrize("n", [400, 4000])
@pytest.mark.parametrize("sigma", [0.0, 0.05, 0.15, 0.3])
def test_the_right_kind_is_chosen(kind, n, sigma, patches):
    rng = np.random.default_rng(int(1000 * sigma) + n)
    _, points, normals = patches.scanned(patches.PATCHES[kind](n, rng), sigma, rng)
    fit = choose_surface(points, normals, sigma, OPTIONS)
    assert fit.surface.kind == kind
    assert fit.is_accepted
    assert fit.n_points == n
    assert fit.rms == pytest.approx(sigma, rel=0.15, abs=1e-9)


def test_a_thin_ring_of_a_bore_is_a_cylinder_and_not_a_sphere(patches):
    rng = np.random.default_rng(0)
    _, points, normals = patches.scanned(patches.cylinder(300, rng, 20.0, 360.0), 0.1, rng)
    assert choose_surface(points, normals, 0.1, OPTIONS).surface.kind == "cylinder"


def test_a_ring_without_width_is_not_accepted_as_the_plane_it_lies_in(patches):
    rng = np.random.default_rng(0)
    _, points, normals = patches.cylinder(60, rng, 20.0, 360.0)
    fit = choose_surface(points, normals, 0.1, OPTIONS, kinds=("plane",))
    assert fit.rms < 0.3
    assert not fit.is_accepted


@pytest.mark.parametrize("sigma", [0.05, 0.2])
def test_a_free_form_patch_is_a_bspline(sigma):
    points, normals, _ = free_form(3000, sigma, np.random.default_rng(1))
    fit = choose_surface(points, normals, sigma, OPTIONS)
    assert fit.surface.kind == "bspline"
    assert fit.is_accepted


def test_two_planes_at_an_angle_are_not_accepted_as_a_primitive():
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-15, 15, (2, 900))
    points = np.column_stack([x, y, np.abs(x) * 0.5])
    normals = np.column_stack([-0.5 * np.sign(x), np.zeros(900), np.ones(900)]) / np.sqrt(1.25)
    fit = choose_surface(points, normals, 0.05, OPTIONS, kinds=KINDS[:5])
    assert not fit.is_accepted


def test_few_points_end_in_the_best_primitive(patches):
    rng = np.random.default_rng(3)
    points, normals = rng.normal(size=(12, 3)), np.tile([0.0, 0.0, 1.0], (12, 1))
    fit = choose_surface(points, normals, 0.05, OPTIONS)
    assert not fit.is_accepted
    assert fit.surface.kind != "bspline"


def test_nothing_to_fit_is_an_error():
    points = np.outer(np.arange(4.0), [1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="4 points"):
        choose_surface(points, np.tile([0.0, 0.0, 1.0], (4, 1)), 0.05, OPTIONS, kinds=("cone",))


def test_only_the_wanted_kinds_are_tried(patches):
    rng = np.random.default_rng(3)
    _, points, normals = patches.cylinder(400, rng)
    fit = choose_surface(points, normals, 0.05, OPTIONS, kinds=("plane", "cone"))
    assert fit.surface.kind == "plane"
    assert not fit.is_accepted


def test_explains_tells_the_surface_from_a_near_one(patches):
    rng = np.random.default_rng(4)
    truth, points, normals = patches.scanned(patches.cylinder(600, rng), 0.1, rng)
    assert explains(truth, points, normals, 0.1, OPTIONS)
    near = Cylinder(truth.origin, truth.axis, truth.radius + 0.2)
    assert not explains(near, points, normals, 0.1, OPTIONS)


def test_explains_rejects_points_that_face_elsewhere(patches):
    rng = np.random.default_rng(4)
    truth, points, normals = patches.plane(300, rng)
    assert not explains(truth, points, normals[:, [2, 0, 1]], 0.1, OPTIONS)


def free_form(n, sigma, rng):
    """A wavy patch: noisy points, normals, true points."""
    side = np.sqrt(n)
    x, y = rng.uniform(-side / 2, side / 2, (2, n))
    z = 2.0 * np.sin(x / 8.0) * np.cos(y / 10.0)
    slope_x = 2.0 / 8.0 * np.cos(x / 8.0) * np.cos(y / 10.0)
    slope_y = -2.0 / 10.0 * np.sin(x / 8.0) * np.sin(y / 10.0)
    normals = np.column_stack([-slope_x, -slope_y, np.ones(n)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    truth = np.column_stack([x, y, z])
    return truth + sigma * rng.normal(size=(n, 1)) * normals, normals, truth


@pytest.mark.parametrize("n", [1, 2, 5])
def test_too_few_points_get_their_tangent_plane_unaccepted(n):
    points = np.linspace(0.0, 1.0, n)[:, None] * np.array([[1.0, 0.0, 0.0]])
    normals = np.tile([0.0, 0.0, 1.0], (n, 1))
    fit = choose_surface(points, normals, 0.1, OPTIONS)
    assert fit.surface.kind == "plane"
    assert not fit.is_accepted
    np.testing.assert_allclose(fit.surface.signed_distance(points), 0.0, atol=1e-12)


def test_what_strips_of_a_neighbour_have_bent_becomes_a_plane_again():
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.uniform(0.0, 9.0, (80, 2)), 0.2 * rng.normal(size=80)])
    up = np.tile([0.0, 0.0, 1.0], (80, 1))
    bent = Cylinder(np.array([4.5, 0.0, -120.0]), np.array([0.0, 1.0, 0.0]), 120.0)
    assert refit(bent, flat, up, 0.2, FitOptions()) is None


def test_a_round_that_is_fitted_again_stays_a_round():
    rng = np.random.default_rng(0)
    angle = rng.uniform(-0.5, 0.5, 80)
    normals = np.column_stack([np.sin(angle), 0.0 * angle, np.cos(angle)])
    points = 6.0 * normals + rng.uniform(0.0, 9.0, (80, 1)) * [0.0, 1.0, 0.0]
    points += 0.2 * rng.normal(size=(80, 1)) * normals
    known = Cylinder(np.zeros(3), np.array([0.0, 1.0, 0.0]), 6.0)
    found = refit(known, points, normals, 0.2, FitOptions())
    assert found is not None
    assert found.surface.kind == "cylinder"
