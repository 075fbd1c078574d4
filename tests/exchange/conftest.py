from dataclasses import replace

import numpy as np
import pytest

from crispline.spline.tensor import spline_over_grid


def _creased(is_rational):
    x, y = np.meshgrid(np.arange(9.0), np.arange(8.0), indexing="ij")
    grid = np.stack([x, y, np.sin(x / 2.0) * np.cos(y / 3.0)], axis=-1)
    spline = spline_over_grid(grid).with_knot_u(4.0, 3)
    net = spline.control_points.copy()
    net[int(np.searchsorted(spline.knots_u, 4.0)) - 1, :, 2] += 0.7
    weights = np.random.default_rng(0).uniform(0.5, 2.0, net.shape[:2]) if is_rational else None
    return replace(spline, control_points=net, weights=weights)


@pytest.fixture(scope="session")
def creased():
    """A bicubic surface with unclamped knots and a crease at u = 4."""
    return _creased(False)


@pytest.fixture(scope="session")
def rational():
    """The same with random weights."""
    return _creased(True)


@pytest.fixture(scope="session")
def assert_same():
    """Checks that two surfaces have the same numbers; `rtol` is relative to their size."""

    def check(found, expected, rtol=0.0):
        names = ("degree_u", "degree_v", "knots_u", "knots_v", "control_points")
        for name in names:
            value = getattr(expected, name)
            atol = rtol * np.abs(value).max()
            np.testing.assert_allclose(getattr(found, name), value, rtol=0, atol=atol)
        assert (found.weights is None) == (expected.weights is None)
        if expected.weights is not None:
            np.testing.assert_allclose(found.weights, expected.weights, rtol=rtol)

    return check
