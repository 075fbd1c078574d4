import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crispline.fit import cone, cylinder, plane, sphere, torus
from crispline.fit.choose import PRIMITIVE_FITS
from crispline.surface import Cone, Cylinder, Plane, Sphere, Torus, unit

KINDS = list(PRIMITIVE_FITS)
MODELS = {
    "plane": (plane.MODEL, Plane(np.array([1.0, 2.0, 3.0]), unit(np.array([1.0, -2.0, 0.5])))),
    "cylinder": (
        cylinder.MODEL,
        Cylinder(np.array([1.0, 2.0, 3.0]), unit(np.array([1.0, -2.0, 0.5])), 7.0),
    ),
    "sphere": (sphere.MODEL, Sphere(np.array([1.0, 2.0, 3.0]), 7.0)),
    "cone": (
        cone.MODEL,
        cone.Frustum(np.array([1.0, 2.0, 3.0]), unit(np.array([1.0, -2.0, 0.5])), 0.4, 7.0),
    ),
    "torus": (
        torus.MODEL,
        Torus(np.array([1.0, 2.0, 3.0]), unit(np.array([1.0, -2.0, 0.5])), 9.0, 4.0),
    ),
}


def defining_lengths(surface):
    """The parameters that no choice of origin or sign changes."""
    match surface:
        case Plane():
            return []
        case Cylinder() | Sphere():
            return [surface.radius]
        case Cone():
            return [surface.half_angle]
        case Torus():
            return [surface.major_radius, surface.minor_radius]


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_agree_with_finite_differences(kind):
    model, shape = MODELS[kind]
    points = np.random.default_rng(0).uniform(-20, 20, (200, 3))
    distances, jacobian = model.linearise(shape, points)
    h = 1e-6
    for column, direction in enumerate(np.eye(jacobian.shape[1])):
        ahead, _ = model.linearise(model.move(shape, h * direction), points)
        behind, _ = model.linearise(model.move(shape, -h * direction), points)
        np.testing.assert_allclose(jacobian[:, column], (ahead - behind) / (2 * h), atol=1e-6)
    if kind != "cone":
        np.testing.assert_allclose(distances, shape.signed_distance(points), atol=1e-12)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [60, 500, 3000])
def test_exact_points_give_the_exact_shape(kind, n, patches):
    rng = np.random.default_rng(n)
    truth, points, normals = patches.scanned(patches.PATCHES[kind](n, rng), 0.0, rng)
    fitted = PRIMITIVE_FITS[kind](points, normals, 0.05)
    assert np.max(np.abs(fitted.signed_distance(points))) < 1e-10
    np.testing.assert_allclose(defining_lengths(fitted), defining_lengths(truth), rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_few_foreign_points_do_not_count(kind, patches):
    rng = np.random.default_rng(5)
    truth, points, normals = patches.scanned(patches.PATCHES[kind](1500, rng), 0.1, rng)
    n_foreign = 75
    points = points.copy()
    # On one side and in one corner, as the points of a neighbouring face would be.
    corner = np.argsort(points @ rng.normal(size=3))[:n_foreign]
    _, outward = truth.project(points[corner])
    points[corner] += outward * rng.uniform(1.0, 4.0, (n_foreign, 1))
    own = np.setdiff1d(np.arange(len(points)), corner)
    fitted = PRIMITIVE_FITS[kind](points, normals, 0.1)
    undisturbed = PRIMITIVE_FITS[kind](points[own], normals[own], 0.1)
    difference = fitted.signed_distance(points[own]) - undisturbed.signed_distance(points[own])
    assert np.sqrt(np.mean(difference**2)) < 0.003


@pytest.mark.parametrize("kind", KINDS)
@given(seed=st.integers(0, 2**31), scale=st.sampled_from([1e-3, 0.1, 1.0, 25.0, 1e3]))
@settings(max_examples=8)
def test_a_similarity_of_the_points_is_a_similarity_of_the_fit(kind, seed, scale, patches):
    rng = np.random.default_rng(seed)
    sigma = 0.1
    _, points, normals = patches.scanned(patches.PATCHES[kind](400, rng), sigma, rng)
    motion = patches.random_motion(rng, scale)
    fitted = PRIMITIVE_FITS[kind](points, normals, sigma)
    moved = PRIMITIVE_FITS[kind](motion.points(points), motion.directions(normals), sigma * scale)
    expected = fitted.transformed(motion).project(motion.points(points))[0]
    feet = moved.project(motion.points(points))[0]
    np.testing.assert_allclose(feet / scale, expected / scale, rtol=0, atol=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_the_points_does_not_matter(kind, patches):
    rng = np.random.default_rng(3)
    _, points, normals = patches.scanned(patches.PATCHES[kind](400, rng), 0.1, rng)
    order = rng.permutation(len(points))
    one = PRIMITIVE_FITS[kind](points, normals, 0.1)
    other = PRIMITIVE_FITS[kind](points[order], normals[order], 0.1)
    np.testing.assert_allclose(one.project(points)[0], other.project(points)[0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("kind", ["plane", "cylinder", "sphere", "cone"])
def test_errors_reach_the_cramer_rao_bound(kind, patches):
    """The rms error of the fitted surface at its points is sigma sqrt(k / n)."""
    rng = np.random.default_rng(1)
    sigma, n, squared = 0.1, 300, []
    truth, points, normals = patches.PATCHES[kind](n, rng)
    for _ in range(150):
        noisy = points + sigma * rng.normal(size=(n, 1)) * normals
        fitted = PRIMITIVE_FITS[kind](noisy, normals, sigma)
        squared.append(np.mean(fitted.signed_distance(points) ** 2))
    bound = sigma * np.sqrt(truth.n_parameters / n)
    assert np.sqrt(np.mean(squared)) < 1.1 * bound


def test_radius_error_reaches_the_cramer_rao_bound_on_a_short_arc(patches):
    """40 degrees, 300 points, noise 0.2: the covariance is sigma^2 (J'J)^-1."""
    rng = np.random.default_rng(2)
    sigma, n = 0.2, 300
    truth, points, normals = patches.cylinder(n, rng, radius=20.0, arc_deg=40.0)
    _, jacobian = cylinder.MODEL.linearise(truth, points)
    bound = sigma * np.sqrt(np.linalg.inv(jacobian.T @ jacobian)[4, 4])
    errors = []
    for _ in range(200):
        noisy = points + sigma * rng.normal(size=(n, 1)) * normals
        blurred = unit(normals + np.radians(10) * rng.normal(size=normals.shape))
        errors.append(cylinder.fit_cylinder(noisy, blurred, sigma).radius - truth.radius)
    # The curvature of the problem adds a little; 200 trials measure to 5 %.
    assert np.std(errors) < 1.2 * bound
    assert abs(np.mean(errors)) < 0.35 * bound


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("n", [1, 2, 3, 6, 9])
def test_too_few_or_coincident_points_give_none_or_a_finite_shape(kind, n):
    rng = np.random.default_rng(n)
    normals = unit(rng.normal(size=(n, 3)))
    for points in (rng.normal(size=(n, 3)), np.ones((n, 3)), np.outer(np.arange(n), np.ones(3))):
        fitted = PRIMITIVE_FITS[kind](points, normals, 0.05)
        assert fitted is None or np.isfinite(fitted.signed_distance(points)).all()


@pytest.mark.parametrize("kind", ["cylinder", "sphere", "cone", "torus"])
def test_a_plane_is_no_curved_shape(kind, patches):
    rng = np.random.default_rng(8)
    _, points, normals = patches.plane(500, rng)
    assert PRIMITIVE_FITS[kind](points, normals, 0.05) is None


def test_a_cylinder_is_no_cone(patches):
    rng = np.random.default_rng(8)
    _, points, normals = patches.cylinder(500, rng)
    assert cone.fit_cone(points, normals, 0.05) is None


def test_a_nearly_parallel_cone_is_found(patches):
    rng = np.random.default_rng(9)
    truth, points, normals = patches.scanned(
        patches.cone(2000, rng, half_angle_deg=3.0, arc_deg=180.0, start=200.0), 0.05, rng
    )
    fitted = cone.fit_cone(points, normals, 0.05)
    assert fitted.half_angle == pytest.approx(truth.half_angle, abs=0.002)
    assert fitted.axis @ truth.axis > 0.9999


def test_the_plane_faces_as_the_normals_do(patches):
    rng = np.random.default_rng(9)
    _, points, normals = patches.plane(50, rng)
    assert plane.fit_plane(points, normals, 0.05).normal[2] == pytest.approx(1.0)
    assert plane.fit_plane(points, -normals, 0.05).normal[2] == pytest.approx(-1.0)


def test_a_start_value_is_refined(patches):
    rng = np.random.default_rng(4)
    truth, points, normals = patches.cylinder(300, rng)
    start = Cylinder(truth.origin + 0.5, unit(truth.axis + 0.02), truth.radius + 1.0)
    fitted = cylinder.fit_cylinder(points, normals, 0.05, start)
    assert fitted.radius == pytest.approx(truth.radius, rel=1e-10)
