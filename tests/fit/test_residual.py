import numpy as np
import pytest

from crispline.fit.residual import clipped, drift, faces_alike, judge, residual_limit, rms
from crispline.options import FitOptions

OPTIONS = FitOptions()


def grid(n):
    axis = np.arange(n, dtype=float)
    x, y = np.meshgrid(axis, axis)
    return np.column_stack([x.ravel(), y.ravel(), np.zeros(n * n)])


def test_noise_is_accepted_and_averages_out():
    points = grid(30)
    residuals = 0.2 * np.random.default_rng(0).normal(size=len(points))
    result = judge(points, residuals, 0.2, OPTIONS)
    assert result.is_accepted
    assert result.rms == pytest.approx(0.2, rel=0.1)
    assert result.drift == pytest.approx(0.2 / np.sqrt(30), rel=0.3)


def test_a_wave_below_the_noise_is_seen_by_the_drift_alone():
    points = grid(30)
    noise = 0.2 * np.random.default_rng(0).normal(size=len(points))
    wave = 0.15 * np.sin(points[:, 0] / 5.0)
    result = judge(points, noise + wave, 0.2, OPTIONS)
    assert result.rms < OPTIONS.accept_rms * 0.2 + 2 * OPTIONS.tolerance
    assert not result.is_accepted


def test_drift_of_constant_residuals_is_the_constant():
    points = grid(40)
    assert drift(points, np.full(len(points), -0.3)) == pytest.approx(0.3)


def test_few_far_points_do_not_decide():
    points = grid(30)
    residuals = 0.1 * np.random.default_rng(1).normal(size=len(points))
    residuals[np.random.default_rng(2).choice(len(points), 18)] = 5.0
    assert judge(points, residuals, 0.1, OPTIONS).is_accepted
    assert np.max(clipped(residuals, 0.1, OPTIONS)) == residual_limit(0.1, OPTIONS)


def test_no_points_have_no_residual():
    assert rms(np.zeros(0)) == 0.0
    assert drift(np.zeros((0, 3)), np.zeros(0)) == 0.0


def test_either_side_of_a_surface_may_be_outside(patches):
    _, _, normals = patches.plane(10, np.random.default_rng(0))
    assert faces_alike(normals, normals)
    assert faces_alike(-normals, normals)
    half = np.where(np.arange(10) < 5, 1.0, -1.0)[:, None]
    assert not faces_alike(half * normals, normals)


def test_what_neighbours_share_of_the_noise_is_no_drift():
    points = grid(30)
    noise = 0.05 * np.random.default_rng(0).normal(size=len(points))
    wave = 0.2 * np.sin(points[:, 0] / 5.0)
    sigma = float(np.hypot(0.05, 0.2 / np.sqrt(2.0)))
    assert not judge(points, noise + wave, sigma, OPTIONS).is_accepted
    shared = FitOptions(noise_growth=sigma / 0.05)
    assert judge(points, noise + wave, sigma, shared).is_accepted
    assert not judge(points, noise + 2.0 * wave, sigma, shared).is_accepted
