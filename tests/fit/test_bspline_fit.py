import numpy as np
import pytest

from crispline.fit import bspline
from crispline.fit.bspline import PassThrough, fit_bspline_surface, is_height_field
from crispline.fit.spline_system import (
    bending_energy,
    smoothing_weight,
    solve_control_points,
    tensor_rows,
)
from crispline.options import FitOptions
from crispline.surface import BSplineSurface
from crispline.surface.basis import uniform_knots

OPTIONS = FitOptions()


def wave(x, y):
    return 2.0 * np.sin(x / 8.0) * np.cos(y / 10.0)


def wave_normals(x, y):
    slope_x = 0.25 * np.cos(x / 8.0) * np.cos(y / 10.0)
    slope_y = -0.2 * np.sin(x / 8.0) * np.sin(y / 10.0)
    normals = np.column_stack([-slope_x, -slope_y, np.ones_like(x)])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def patch(n, sigma, seed=0):
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-np.sqrt(n) / 2, np.sqrt(n) / 2, (2, n))
    normals = wave_normals(x, y)
    truth = np.column_stack([x, y, wave(x, y)])
    return truth + sigma * rng.normal(size=(n, 1)) * normals, normals, truth


def test_the_error_falls_with_the_fourth_power_of_the_span():
    axis = np.linspace(0.0, 40.0, 161)
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    targets = np.column_stack([x, y, wave(x, y)])
    errors = []
    for n_spans in (8, 16, 32):
        knots = (uniform_knots(0.0, 40.0, n_spans),) * 2
        rows = tensor_rows(knots, x, y)
        weight = smoothing_weight(knots, len(x) / 1600.0)
        surface = solve_control_points(
            knots, rows, targets, np.ones(len(x)), weight * bending_energy(*knots)
        )
        inside = (np.abs(x - 20) < 12) & (np.abs(y - 20) < 12)
        off = surface.evaluate(x[inside], y[inside])[:, 2] - wave(x[inside], y[inside])
        errors.append(np.sqrt(np.mean(off**2)))
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(orders > 3.7)
    assert errors[-1] < 1e-5


def test_the_bending_energy_is_exact():
    """S = (u, v, u^3 v) on [0, 2] x [0, 3]: the energy is 648, by hand."""
    knots = (uniform_knots(0.0, 2.0, 4), uniform_knots(0.0, 3.0, 3))
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 2, 20), np.linspace(0, 3, 20)))
    rows = tensor_rows(knots, u, v).toarray()
    control = np.linalg.lstsq(rows, u**3 * v, rcond=None)[0]
    energy = control @ (bending_energy(*knots) @ control)
    # integral (6 u v)^2 + 2 (3 u^2)^2 = 36 * 8/3 * 9 + 18 * 32/5 * 3
    assert energy == pytest.approx(36 * (8 / 3) * 9 + 18 * (32 / 5) * 3, rel=1e-10)


def test_planes_have_no_bending_energy():
    knots = (uniform_knots(-1.0, 2.0, 3), uniform_knots(0.0, 5.0, 6))
    greville = [np.array([k[i + 1 : i + 4].mean() for i in range(len(k) - 4)]) for k in knots]
    control = (2.0 + 3.0 * greville[0][:, None] - greville[1]).ravel()
    assert np.max(np.abs(bending_energy(*knots) @ control)) < 1e-10


@pytest.mark.parametrize("sigma", [0.0, 0.05, 0.2])
def test_noise_averages_out(sigma):
    points, normals, truth = patch(2500, sigma)
    surface = fit_bspline_surface(points, normals, max(sigma, 0.05), OPTIONS)
    inner = np.all(np.abs(truth[:, :2]) < 22, axis=1)
    error = surface.signed_distance(truth)
    assert np.sqrt(np.mean(error[inner] ** 2)) < 0.02 + 0.25 * sigma
    assert np.max(np.abs(error)) < 0.15 + 2.0 * sigma


def test_the_normal_is_on_the_side_of_the_given_normals():
    points, normals, _ = patch(900, 0.05)
    for side in (1.0, -1.0):
        surface = fit_bspline_surface(points, side * normals, 0.05, OPTIONS)
        _, fitted = surface.project(points)
        assert np.min(np.einsum("ij,ij->i", fitted, side * normals)) > 0.9


def test_the_domain_reaches_beyond_the_points():
    points, normals, _ = patch(900, 0.05)
    surface = fit_bspline_surface(points, normals, 0.05, OPTIONS)
    low, high = surface.domain
    u, v = surface.parameters_of(points)
    margin = 0.1 * np.array([np.ptp(u), np.ptp(v)])
    assert np.all([u.min(), v.min()] - low > margin)
    assert np.all(high - [u.max(), v.max()] > margin)


def test_parameters_stay_within_given_limits():
    points, normals, _ = patch(2500, 0.05)
    free = fit_bspline_surface(points, normals, 0.05, OPTIONS)
    n = free.n_parameters
    for within in ((0, n), (n / 2, n)):
        same = fit_bspline_surface(points, normals, 0.05, OPTIONS, within=within)
        assert same.n_parameters == n
        assert np.max(np.abs(same.signed_distance(free.project(points)[0]))) < 0.02
    coarser = fit_bspline_surface(points, normals, 0.05, OPTIONS, within=(0, n - 1))
    assert coarser.n_parameters < n
    finer = fit_bspline_surface(points, normals, 0.05, OPTIONS, within=(n + 1, np.inf))
    assert finer.n_parameters > n


def test_parameters_are_corrected_to_the_end_where_that_is_promising_only(monkeypatch):
    points, normals, _ = patch(900, 0.05)
    asked = []

    def says(answer):
        return lambda surface: asked.append(surface) or answer

    known = fit_bspline_surface(points, normals, 0.05, OPTIONS)
    same = fit_bspline_surface(points, normals, 0.05, OPTIONS, is_promising=says(True))
    np.testing.assert_array_equal(same.control_points, known.control_points)
    monkeypatch.setattr(bspline, "_POLISH_CORRECTIONS", None)  # nobody gets that far
    assert fit_bspline_surface(points, normals, 0.05, OPTIONS, is_promising=says(False)) is None
    assert len(asked) == 2


def test_a_rim_of_foreign_points_is_left_out():
    points, normals, truth = patch(2500, 0.1)
    border = 25.0 - np.max(np.abs(truth[:, :2]), axis=1)
    is_foreign = (border < 1.5) & (truth[:, 0] > 0)
    points = points + np.where(is_foreign, 1.0, 0.0)[:, None] * normals
    own = ~is_foreign
    grown = fit_bspline_surface(points, normals, 0.1, OPTIONS, border_distance=border)
    plain = fit_bspline_surface(points, normals, 0.1, OPTIONS)
    errors = [np.max(np.abs(s.signed_distance(truth[own]))) for s in (grown, plain)]
    assert errors[0] < 0.2
    assert errors[0] < errors[1]


def test_constraints_are_met():
    points, normals, _ = patch(900, 0.1)
    y = np.linspace(-15, 15, 40)
    edge = np.column_stack([np.full(40, 16.0), y, wave(np.full(40, 16.0), y) + 0.3])
    beside = edge + np.array([0.5, 0.0, 0.0])
    surface = fit_bspline_surface(points, normals, 0.1, OPTIONS, PassThrough(edge, beside))
    assert np.sqrt(np.mean(surface.signed_distance(edge) ** 2)) < 0.005
    assert np.sqrt(np.mean(surface.signed_distance(beside) ** 2)) < 0.005


def test_more_than_a_hemisphere_is_refused(patches):
    rng = np.random.default_rng(0)
    _, points, normals = patches.cylinder(500, rng, 5.0, 300.0)
    assert not is_height_field(normals)
    assert fit_bspline_surface(points, normals, 0.05, OPTIONS) is None


def test_a_narrow_strip_is_fitted_with_spans_along_it():
    rng = np.random.default_rng(1)
    x, y = rng.uniform(-60, 60, 720), rng.uniform(-3, 3, 720)
    points = np.column_stack([x, y, wave(x, y)])
    surface = fit_bspline_surface(points, wave_normals(x, y), 0.05, OPTIONS)
    assert isinstance(surface, BSplineSurface)
    assert surface.control_points.shape[0] > 2 * surface.control_points.shape[1]
    assert np.sqrt(np.mean(surface.signed_distance(points) ** 2)) < 0.03
