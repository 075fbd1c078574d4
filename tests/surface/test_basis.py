import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.surface.basis import SpanPolynomials, basis_functions, uniform_knots


def de_boor(knots, i, degree, x):
    """Naive recursion, Piegl and Tiller equation 2.5. Useful only for testing."""
    if degree == 0:
        is_last = knots[i] < knots[i + 1] == knots[-1] == x
        return 1.0 if knots[i] <= x < knots[i + 1] or is_last else 0.0
    value = 0.0
    if knots[i + degree] > knots[i]:
        left = (x - knots[i]) / (knots[i + degree] - knots[i])
        value += left * de_boor(knots, i, degree - 1, x)
    if knots[i + degree + 1] > knots[i + 1]:
        right = (knots[i + degree + 1] - x) / (knots[i + degree + 1] - knots[i + 1])
        value += right * de_boor(knots, i + 1, degree - 1, x)
    return value


@given(
    steps=st.lists(st.floats(0.1, 3.0), min_size=1, max_size=6),
    fraction=st.floats(0.0, 1.0),
)
def test_values_agree_with_the_recursion(steps, fraction):
    breaks = np.concatenate([[0.0], np.cumsum(steps)])
    knots = np.concatenate([np.zeros(3), breaks, np.full(3, breaks[-1])])
    x = min(fraction * breaks[-1], breaks[-1])
    first, values = basis_functions(knots, np.array([x]))
    full = np.zeros(len(knots) - 4)
    full[first[0] : first[0] + 4] = values[0, 0]
    naive = [de_boor(knots, i, 3, x) for i in range(len(full))]
    np.testing.assert_allclose(full, naive, atol=1e-12)


def test_partition_of_unity_and_vanishing_sum_of_derivatives():
    knots = uniform_knots(-2.0, 5.0, 9)
    _, values = basis_functions(knots, np.linspace(-2.0, 5.0, 101), 3)
    sums = values.sum(axis=2)
    np.testing.assert_allclose(sums[0], 1.0, atol=1e-14)
    np.testing.assert_allclose(sums[1:], 0.0, atol=1e-11)


@pytest.mark.parametrize("derivative", [1, 2, 3])
def test_derivatives_agree_with_finite_differences(derivative):
    knots = np.concatenate([np.zeros(4), [0.7, 1.0, 2.5], np.full(4, 3.0)])
    x, h = np.array([0.3, 0.85, 1.7, 2.9]), 1e-6
    _, values = basis_functions(knots, x, 3)
    _, ahead = basis_functions(knots, x + h, 3)
    _, behind = basis_functions(knots, x - h, 3)
    slope = (ahead[derivative - 1] - behind[derivative - 1]) / (2 * h)
    np.testing.assert_allclose(values[derivative], slope, atol=1e-7)


def test_the_right_end_belongs_to_the_last_span():
    knots = uniform_knots(0.0, 4.0, 4)
    first, values = basis_functions(knots, np.array([4.0]), 1)
    assert first[0] == 3
    np.testing.assert_allclose(values[0, 0], [0, 0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(values[1, 0], [0, 0, -3, 3], atol=1e-14)


@given(steps=st.lists(st.floats(0.1, 2.0), min_size=2, max_size=6), order=st.integers(0, 3))
def test_span_polynomials_are_the_same_functions(steps, order):
    inner = np.cumsum([0.0, *steps])
    inner = np.sort(np.append(inner, inner[1:2]))  # a double knot has no span of its own
    knots = np.concatenate([inner[:1].repeat(3), inner, inner[-1:].repeat(3)])
    places = np.concatenate([np.linspace(-0.5, inner[-1] + 0.5, 41), inner])
    first, values = SpanPolynomials.of(knots).at(places, order)
    expected_first, expected = basis_functions(knots, places, order)
    np.testing.assert_array_equal(first, expected_first)
    np.testing.assert_allclose(values, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
