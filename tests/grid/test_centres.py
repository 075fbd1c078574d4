"""Centres and curvature of grids: a plain stencil, the spline itself, borders and gaps."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.grid.centres import grid_centres, grid_curvature, surface_centres
from crispline.grid.detect import curvature
from crispline.spline.tensor import spline_over_grid

POSITION = np.array([1, 23, 23, 1]) / 48
FIRST = np.array([-1, -5, 5, 1]) / 8
SECOND = np.array([1, -1, -1, 1]) / 2


def plain(points):
    """Sums of 16 terms at the cells that have all their neighbours."""
    m, n = points.shape[:2]

    def derivative(a, b):
        return sum(
            a[k] * b[q] * points[k : m - 3 + k, q : n - 3 + q] for k in range(4) for q in range(4)
        )

    du, dv = derivative(FIRST, POSITION), derivative(POSITION, FIRST)
    normal = np.cross(du, dv)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    e, f, g = ((a * b).sum(axis=2) for a, b in ((du, du), (du, dv), (dv, dv)))
    pairs = (SECOND, POSITION), (FIRST, FIRST), (POSITION, SECOND)
    ll, mm, nn = ((derivative(*pair) * normal).sum(axis=2) for pair in pairs)
    return (e * nn - 2 * f * mm + g * ll) / (2 * (e * g - f * f))


def rough(m, n, seed=0):
    i, j = np.mgrid[:m, :n].astype(float)
    return np.stack([i, j, 0 * i], axis=2) + 0.2 * np.random.default_rng(seed).normal(
        size=(m, n, 3)
    )


@pytest.mark.parametrize("shape", [(4, 4), (5, 40), (200, 130), (40, 5)])
def test_curvature_equals_the_plain_stencil(shape):
    points = rough(*shape)
    np.testing.assert_allclose(
        grid_curvature(points).mean[1:-1, 1:-1], plain(points), rtol=1e-9, atol=1e-12
    )


def test_is_the_curvature_of_the_spline_up_to_the_border():
    points = rough(12, 9)
    spline = spline_over_grid(points)
    centres = surface_centres(spline, np.arange(12.0), np.arange(9.0))
    own = grid_centres(points)
    for name in ("point", "du", "dv", "duu", "duv", "dvv"):
        np.testing.assert_allclose(getattr(own, name), getattr(centres, name), atol=1e-12)
    np.testing.assert_allclose(curvature(spline).mean, grid_curvature(points).mean, atol=1e-12)


def test_beside_an_invalid_pixel_the_rows_go_on_straight():
    """A grid cut off at a column has the values of a grid that ends there."""
    points = rough(10, 12)
    is_valid = np.ones((10, 12), dtype=bool)
    is_valid[:, 7:] = False
    whole = grid_curvature(np.where(is_valid[:, :, None], points, 0.0), is_valid)
    np.testing.assert_allclose(whole.mean[:, :6], grid_curvature(points[:, :7]).mean, atol=1e-12)
    assert (whole.mean[:, 6:] == 0.0).all()
    assert (whole.size[:, 6:] == 0.0).all()


def test_a_plane_with_holes_is_flat_everywhere():
    i, j = np.mgrid[:15, :15].astype(float)
    points = np.stack([i, j, 0.3 * i - 0.2 * j], axis=2)
    is_valid = np.random.default_rng(0).random((15, 15)) > 0.2
    bend = grid_curvature(np.where(is_valid[:, :, None], points, 0.0), is_valid)
    np.testing.assert_allclose(bend.mean, 0.0, atol=1e-12)


@given(seed=st.integers(0, 100), exponent=st.floats(-3, 3))
def test_is_one_over_length(seed, exponent):
    points, scale = rough(6, 7, seed), 10.0**exponent
    one, other = curvature(points), curvature(scale * points)
    np.testing.assert_allclose(other.mean * scale, one.mean, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(other.size, one.size * scale, rtol=1e-9)
