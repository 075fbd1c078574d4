import numpy as np
import pytest
from tangent_cylinder import fit_cylinder_tangent_to_planes

from crispline.fit.cylinder import fit_cylinder
from crispline.surface import Cylinder, Plane, unit

SIGMA = 0.1


def fillet(rng, angle_deg=90.0, radius=4.0, n=400):
    """A fillet between two planes: exact cylinder and planes, noisy points, start value."""
    angle = np.radians(angle_deg)
    first, second = np.array([0.0, 0.0, 1.0]), np.array([np.sin(angle), 0.0, np.cos(angle)])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    swing = rng.uniform(0.0, angle, n)
    normals = np.column_stack([np.sin(swing), np.zeros(n), np.cos(swing)])
    points = radius * normals + rng.uniform(-30, 30, n)[:, None] * [0.0, 1.0, 0.0]
    truth = Cylinder(np.zeros(3), turn @ [0.0, 1.0, 0.0], radius)
    planes = [Plane(turn @ (radius * n), turn @ n) for n in (first, second)]
    noisy = (points + SIGMA * rng.normal(size=(n, 1)) * normals) @ turn.T
    start = fit_cylinder(noisy, normals @ turn.T, SIGMA)
    return truth, planes, noisy, start


@pytest.mark.parametrize("angle_deg", [40.0, 90.0, 150.0])
@pytest.mark.parametrize("n_planes", [1, 2])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_tangency_is_exact_and_the_radius_improves(angle_deg, n_planes, side):
    free_errors, errors = [], []
    for seed in range(12):
        truth, planes, points, start = fillet(np.random.default_rng(seed), angle_deg)
        planes = [Plane(p.origin, side * p.normal) for p in planes[:n_planes]]
        cylinder = fit_cylinder_tangent_to_planes(points, SIGMA, planes, start)
        for plane in planes:
            assert abs(cylinder.axis @ plane.normal) < 1e-13
            height = (cylinder.origin - plane.origin) @ plane.normal
            assert abs(height) == pytest.approx(cylinder.radius, abs=1e-11)
        free_errors.append(start.radius - truth.radius)
        errors.append(cylinder.radius - truth.radius)
    assert np.linalg.norm(errors) < np.linalg.norm(free_errors)
    if n_planes == 2:
        assert np.max(np.abs(errors)) < 0.3


def test_clean_points_give_the_exact_fillet():
    truth, planes, points, start = fillet(np.random.default_rng(3))
    _, outward = truth.project(points)
    exact = points - truth.signed_distance(points)[:, None] * outward
    for used in (planes[:1], planes):
        cylinder = fit_cylinder_tangent_to_planes(exact, SIGMA, used, start)
        assert cylinder.radius == pytest.approx(truth.radius, abs=1e-9)


def test_parallel_planes_and_a_crossing_axis_are_refused():
    _, planes, points, start = fillet(np.random.default_rng(4))
    opposite = Plane(planes[0].origin - 8.0 * planes[0].normal, -planes[0].normal)
    assert fit_cylinder_tangent_to_planes(points, SIGMA, [planes[0], opposite], start) is None
    tilted = Cylinder(start.origin, unit(start.axis + planes[0].normal), start.radius)
    assert fit_cylinder_tangent_to_planes(points, SIGMA, planes[:1], tilted) is None


def test_three_planes_are_an_error():
    _, planes, points, start = fillet(np.random.default_rng(4))
    with pytest.raises(ValueError, match="got 3"):
        fit_cylinder_tangent_to_planes(points, SIGMA, [*planes, planes[0]], start)
