"""Tensor-product splines of SciPy."""

import numpy as np
import pytest
from scipy.interpolate import NdBSpline, make_interp_spline

from crispline.errors import InputError
from crispline.exchange.scipy import from_scipy, to_scipy


@pytest.mark.parametrize("degrees", [3, (3, 1)])
def test_a_spline_through_points_keeps_its_values(degrees):
    x, y = np.linspace(0.0, 4.0, 9), np.linspace(-1.0, 2.0, 7)
    values = np.random.default_rng(0).normal(size=(9, 7, 3))
    k_u, k_v = np.broadcast_to(degrees, (2,))
    along_u = make_interp_spline(x, values, k_u)
    along_v = make_interp_spline(y, along_u.c, k_v, axis=1)
    net = np.moveaxis(along_v.c, 0, 1)
    surface = from_scipy((along_u.t, along_v.t), net, degrees)
    u, v = (a.ravel() for a in np.meshgrid(x, y, indexing="ij"))
    np.testing.assert_allclose(surface.evaluate(u, v), values.reshape(-1, 3), atol=1e-12)
    spline = NdBSpline((along_u.t, along_v.t), net, degrees)
    same = from_scipy(spline.t, spline.c, spline.k)
    np.testing.assert_array_equal(same.evaluate(u, v), surface.evaluate(u, v))


def test_surfaces_go_there_and_back(creased, assert_same):
    spline = to_scipy(creased)
    assert isinstance(spline, NdBSpline)
    assert_same(from_scipy(spline.t, spline.c, spline.k), creased)
    np.testing.assert_array_equal(
        spline(np.array([[1.5, 2.5]])), creased.evaluate(np.array([1.5]), np.array([2.5]))
    )


def test_weights_have_no_place_in_scipy(rational):
    with pytest.raises(InputError, match="a surface without weights, got a rational one"):
        to_scipy(rational)


@pytest.mark.parametrize(
    ("t", "c", "k", "sentence"),
    [
        (([0, 0, 1, 1],) * 3, np.ones((2, 2, 2, 3)), 1, "two knot vectors, .* found 3"),
        (([0, 0, 1, 1],) * 2, np.ones((2, 2)), 1, r"\(n_u, n_v, 3\), found shape \(2, 2\)"),
        (([0, 0, 1, 1],) * 2, np.ones((2, 2, 3)), (1, 1, 1), "one degree or two, found 3"),
        (([0, 0, 1, 1],) * 2, np.ones((3, 2, 3)), 1, "expected 5 knots_u"),
    ],
)
def test_other_splines_are_refused(t, c, k, sentence):
    with pytest.raises(InputError, match=f"^the SciPy spline: .*{sentence}"):
        from_scipy(t, c, k)
