"""The extruded surface against its definition, and as the B-spline that it is."""

import numpy as np
import pytest

from crispline.surface import ExtrudedSurface, Similarity, unit
from crispline.surface.basis import basis_functions, uniform_knots

RNG = np.random.default_rng(0)
DIRECTION = unit(np.array([2.0, -1.0, 2.0]))
KNOTS = uniform_knots(-3.0, 5.0, 4)
PROFILE = np.cumsum(RNG.uniform(0.5, 2.0, (7, 3)), axis=0)
SURFACE = ExtrudedSurface.of(KNOTS, PROFILE, DIRECTION, (-2.0, 6.0))


def _curve(u):
    first, values = basis_functions(KNOTS, u)
    return np.einsum("nk,nkx->nx", values[0], PROFILE[first[:, None] + np.arange(4)])


def test_it_is_the_curve_moved_along_the_direction():
    u, v = RNG.uniform(-3.0, 5.0, 50), RNG.uniform(-2.0, 6.0, 50)
    np.testing.assert_allclose(
        SURFACE.evaluate(u, v), _curve(u) + v[:, None] * DIRECTION, atol=1e-12
    )


def test_rulings_have_one_normal():
    u = RNG.uniform(-3.0, 5.0, 20)
    places = [SURFACE.evaluate(u, np.full(20, v)) for v in (-1.0, 5.0)]
    first, second = (SURFACE.project(place)[1] for place in places)
    np.testing.assert_allclose(first, second, atol=1e-9)
    np.testing.assert_allclose(first @ DIRECTION, 0.0, atol=1e-9)


def test_a_similarity_keeps_what_it_is():
    turn = np.linalg.qr(RNG.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = SURFACE.transformed(Similarity(2.5, turn, np.array([1.0, 2.0, 3.0])))
    assert isinstance(moved, ExtrudedSurface)
    np.testing.assert_allclose(moved.direction, turn @ DIRECTION, atol=1e-12)
    assert moved.n_parameters == 7 + 2
    assert moved.parameters()["direction"] == pytest.approx((turn @ DIRECTION).tolist())
