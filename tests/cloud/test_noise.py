"""The estimate of noise over sizes of cloud, levels of noise and outliers."""

import numpy as np
import pytest

from crispline.cloud.noise import noise_levels
from crispline.cloud.scale import cloud_scale
from crispline.cloud.working import working_cloud
from crispline.options import CloudOptions
from crispline.shapes import SHAPES, sample


def scan(n_points, noise, outliers, seed=0):
    """The bracket with Gaussian noise along the normals; its spacing by area."""
    clean = sample(SHAPES["bracket"](), n_points, seed=seed)
    stream = np.random.default_rng(seed)
    off = noise * clean.spacing * stream.normal(size=(len(clean.points), 1))
    points = clean.points + off * clean.normals
    low, high = points.min(axis=0), points.max(axis=0)
    room = 0.1 * (high - low)
    stray = stream.uniform(low - room, high + room, (int(outliers * n_points), 3))
    return np.vstack([points, stray]), clean.spacing


# Largest estimate over the truth that is accepted; measured values lie 5 to 10 % below. With the
# median in place of the quartile the rows of 2,000 points give 4.0, 1.5 and 2.1.
@pytest.mark.parametrize(
    ("n_points", "noise", "outliers", "most"),
    [
        (2000, 0.05, 0.0, 2.2),
        (2000, 0.2, 0.0, 1.35),
        (2000, 0.2, 0.3, 2.0),
        (5000, 0.05, 0.0, 1.2),
        (5000, 0.2, 0.1, 1.25),
        (20000, 0.05, 0.0, 1.1),
        (20000, 0.2, 0.0, 1.08),
        (20000, 0.2, 0.3, 1.25),
        (20000, 0.4, 0.0, 1.06),
    ],
)
def test_noise_is_not_far_overestimated_and_never_under(n_points, noise, outliers, most):
    points, spacing = scan(n_points, noise, outliers)
    cloud = working_cloud(points, CloudOptions())
    ratio = cloud.sigma * cloud.spacing / (noise * spacing)
    assert 0.95 < ratio < most


def test_a_clean_cloud_has_no_noise_to_speak_of():
    points, _ = scan(20000, 0.0, 0.0)
    assert working_cloud(points, CloudOptions()).sigma < 0.002


def test_a_sample_of_the_points_tells_the_same():
    points, _ = scan(20000, 0.2, 0.0)
    cloud = working_cloud(points, CloudOptions())
    found, noise = cloud_scale(points)
    assert found == pytest.approx(cloud.spacing, rel=0.02)
    assert noise == pytest.approx(cloud.sigma * cloud.spacing, rel=0.03)
    assert np.isnan(cloud_scale(points[:23])).all()


def test_a_half_with_four_times_the_noise_has_four_times_the_noise():
    stream = np.random.default_rng(0)
    flat = stream.uniform(0.0, 100.0, (10_000, 2))
    noise = np.where(flat[:, 0] > 50.0, 0.2, 0.05)
    points = np.column_stack([flat, noise * stream.normal(size=len(flat))])
    cloud = working_cloud(points, CloudOptions())
    found = noise_levels(cloud.points, cloud.neighbours, 0.05 / cloud.spacing)
    at = cloud.to_user.points(cloud.points)[:, 0]
    np.testing.assert_allclose(found[at < 35.0] * cloud.spacing, 0.05, rtol=0.25)
    np.testing.assert_allclose(found[at > 65.0] * cloud.spacing, 0.2, rtol=0.25)


@pytest.mark.parametrize("shape", ["bracket", "box-cylinder"])
@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_creases_and_chance_are_no_uneven_noise(shape, noise):
    clean = sample(SHAPES[shape](), 8000, seed=1)
    stream = np.random.default_rng(1)
    points = clean.points + noise * clean.spacing * stream.normal(size=(8000, 1)) * clean.normals
    cloud = working_cloud(points, CloudOptions())
    sigma = max(cloud.sigma, 0.05)
    np.testing.assert_array_equal(noise_levels(cloud.points, cloud.neighbours, sigma), sigma)
