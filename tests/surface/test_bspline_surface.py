import numpy as np
import pytest
from scipy.interpolate import NdBSpline

from crispline.surface import BSplineSurface, Similarity, unit
from crispline.surface.basis import uniform_knots


def greville(knots):
    return np.array([knots[i + 1 : i + 4].mean() for i in range(len(knots) - 4)])


@pytest.fixture(scope="module")
def surface():
    knots_u, knots_v = uniform_knots(0.0, 20.0, 20), uniform_knots(-1.0, 9.0, 10)
    x, y = np.meshgrid(greville(knots_u), greville(knots_v), indexing="ij")
    control = np.stack([x, y + 0.1 * x, 1.5 * np.sin(x / 3.0) * np.cos(y / 2.0)], axis=-1)
    return BSplineSurface(knots_u, knots_v, control)


def inside(n, seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.0, 20.0, n), rng.uniform(-1.0, 9.0, n)


@pytest.mark.parametrize("orders", [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 3)])
def test_values_and_derivatives_agree_with_scipy(surface, orders):
    u, v = inside(300)
    u[:3], v[:3] = [0.0, 20.0, 20.0], [-1.0, 9.0, -1.0]
    reference = NdBSpline((surface.knots_u, surface.knots_v), surface.control_points, 3)
    expected = reference(np.column_stack([u, v]), nu=orders)
    np.testing.assert_allclose(surface.evaluate(u, v, *orders), expected, atol=1e-11)


def test_points_beside_the_surface_find_their_feet(surface):
    u, v = inside(2000, 1)
    feet = surface.evaluate(u, v)
    normals = unit(np.cross(surface.evaluate(u, v, 1, 0), surface.evaluate(u, v, 0, 1)))
    height = np.random.default_rng(2).uniform(-0.3, 0.3, 2000)
    points = feet + height[:, None] * normals
    found, found_normals = surface.project(points)
    np.testing.assert_allclose(found, feet, atol=1e-10)
    np.testing.assert_allclose(found_normals, normals, atol=1e-10)
    np.testing.assert_allclose(surface.signed_distance(points), height, atol=1e-11)


def test_points_on_the_surface_keep_their_parameters(surface):
    u, v = inside(2000, 3)
    found_u, found_v = surface.parameters_of(surface.evaluate(u, v))
    np.testing.assert_allclose(found_u, u, atol=1e-11)
    np.testing.assert_allclose(found_v, v, atol=1e-11)


def test_newton_converges_quadratically_away_from_the_surface(surface):
    u, v = inside(500, 6)
    normals = unit(np.cross(surface.evaluate(u, v, 1, 0), surface.evaluate(u, v, 0, 1)))
    points = surface.evaluate(u, v) + 0.6 * normals
    errors = []
    for n_steps in (1, 2, 3):
        found = surface.refined_parameters(points, u + 0.02, v - 0.02, n_steps)
        errors.append(np.median(np.hypot(found[0] - u, found[1] - v)))
    assert errors[1] < 20.0 * errors[0] ** 2
    assert errors[2] < 1e-10


def test_no_sampled_point_is_nearer_than_the_foot(surface):
    points = np.random.default_rng(4).uniform([-3, -3, -4], [23, 13, 4], (200, 3))
    feet, _ = surface.project(points)
    grid_u, grid_v = (
        a.ravel() for a in np.meshgrid(np.linspace(0, 20, 120), np.linspace(-1, 9, 60))
    )
    samples = surface.evaluate(grid_u, grid_v)
    nearest = np.min(np.linalg.norm(points[:, None] - samples, axis=2), axis=1)
    assert np.all(np.linalg.norm(points - feet, axis=1) <= nearest + 1e-9)


def test_feet_beyond_the_domain_stay_on_the_border(surface):
    outside = np.array([[-5.0, 3.0, 0.0], [30.0, 20.0, 1.0], [1e3, -1e3, 1e3]])
    u, v = surface.parameters_of(outside)
    assert u[0] == 0.0
    assert (u[1], v[1]) == (20.0, 9.0)
    low, high = surface.domain
    assert np.all((low[0] <= u) & (u <= high[0]) & (low[1] <= v) & (v <= high[1]))


def test_a_degenerate_surface_gives_no_nan():
    knots = uniform_knots(0.0, 1.0, 2)
    flat = BSplineSurface(knots, knots, np.zeros((5, 5, 3)))
    feet, normals = flat.project(np.ones((4, 3)))
    assert np.isfinite(feet).all()
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)


def test_the_image_under_a_similarity_has_the_images_of_the_points(surface):
    rotation, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    motion = Similarity(3.0, rotation, np.array([1.0, -20.0, 7.0]))
    u, v = inside(50)
    moved = surface.transformed(motion)
    np.testing.assert_allclose(
        moved.evaluate(u, v), motion.points(surface.evaluate(u, v)), atol=1e-12
    )
    feet, _ = moved.project(motion.points(surface.evaluate(u, v)))
    np.testing.assert_allclose(feet, moved.evaluate(u, v), atol=1e-10)
    assert surface.parameters() == moved.parameters()


def test_the_summary_counts_control_points(surface):
    assert surface.parameters() == {
        "degree": 3,
        "n_control_points_u": 23,
        "n_control_points_v": 13,
    }
    assert surface.n_parameters == 3 * 23 * 13


def test_points_and_normals_come_together(surface):
    u, v = inside(50, 7)
    points, normals = surface.evaluate_with_normals(u, v)
    across = np.cross(surface.evaluate(u, v, 1, 0), surface.evaluate(u, v, 0, 1))
    np.testing.assert_array_equal(points, surface.evaluate(u, v))
    np.testing.assert_allclose(normals, unit(across), atol=1e-14)
