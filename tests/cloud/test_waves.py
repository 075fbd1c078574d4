"""Noise that neighbours share, told from white noise, from curvature and from edges."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from crispline.cloud.waves import noise_growth
from crispline.cloud.working import working_cloud
from crispline.options import CloudOptions
from crispline.shapes import SHAPES, sample


def table(white, waves, length=3.0, n=60, bend=0.0, seed=0):
    """A square of n by n points a spacing apart, with ripples of rms ``waves``."""
    stream = np.random.default_rng(seed)
    x, y = np.meshgrid(np.arange(n) - n / 2, np.arange(n) - n / 2)
    ripple = gaussian_filter(stream.normal(size=(n, n)), length, mode="wrap")
    z = white * stream.normal(size=(n, n)) + waves * ripple / ripple.std() + bend * x**2
    jitter = stream.uniform(-0.3, 0.3, (2, n, n))
    return np.stack([x + jitter[0], y + jitter[1], z], axis=-1).reshape(-1, 3)


def growth(points, sigma):
    return noise_growth(points, cKDTree(points), np.full(len(points), sigma), threads=1)


@pytest.mark.parametrize("white", [0.05, 0.2])
def test_white_noise_does_not_grow(white):
    assert growth(table(white, 0.0), white) == 1.0


@pytest.mark.parametrize("waves", [0.15, 0.3])
def test_ripples_are_measured_beyond_what_neighbours_tell(waves):
    truth = np.hypot(0.05, waves)
    assert 0.05 * growth(table(0.05, waves), 0.05) == pytest.approx(truth, rel=0.15)


def test_a_bent_face_is_no_noise():
    assert growth(table(0.05, 0.0, bend=2e-3), 0.05) == 1.0


@pytest.mark.parametrize("name", ["box-cylinder", "bracket"])
@pytest.mark.parametrize("n_points", [5000, 20000])
def test_edges_and_rounds_are_no_noise(name, n_points):
    scan = sample(SHAPES[name](), n_points, noise=0.002, seed=1)
    cloud = working_cloud(scan.points, CloudOptions(), 1)
    sigma = max(cloud.sigma, 0.05)
    assert noise_growth(cloud.points, cloud.tree, np.full(len(cloud.points), sigma), 1) == 1.0
