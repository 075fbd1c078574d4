"""Common points and parallel curves of lines and circles, against their definitions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.fit.contact import crossing, offset, outward
from crispline.fit.swept import Circle, Line

NEAR = np.array([3.0, 4.0])


def height(profile, point):
    if isinstance(profile, Line):
        return point @ profile.normal - profile.offset
    return np.linalg.norm(point - profile.centre) - profile.radius


def through(kind, turn, curvature):
    """A line or circle through the place ``NEAR``."""
    normal = np.array([np.cos(turn), np.sin(turn)])
    if kind == "line":
        return Line(turn, float(normal @ NEAR))
    return Circle(NEAR - normal / curvature, 1.0 / curvature)


@pytest.mark.parametrize("first", ["line", "circle"])
@pytest.mark.parametrize("second", ["line", "circle"])
@given(
    turn=st.floats(0.0, 6.0),
    between=st.floats(0.4, 2.7),
    size=st.tuples(*2 * [st.floats(0.02, 1.0)]),
)
def test_the_common_point_near_a_place(first, second, turn, between, size):
    curves = through(first, turn, size[0]), through(second, turn + between, size[1])
    np.testing.assert_allclose(crossing(*curves, NEAR + 1e-3), NEAR, atol=1e-6)


@pytest.mark.parametrize("kind", ["line", "circle"])
def test_an_offset_curve_is_so_far_everywhere(kind):
    curve = through(kind, 0.4, 0.2)
    moved = offset(curve, -1.5)
    on_it = NEAR - 1.5 * outward(curve, NEAR)
    assert height(moved, on_it) == pytest.approx(0.0, abs=1e-12)
    assert height(curve, on_it) == pytest.approx(-1.5)


def test_what_has_no_answer():
    assert offset(Circle(NEAR, 1.0), -1.0) is None
    assert crossing(Line(0.0, 1.0), Line(0.0, 2.0), NEAR) is None
    assert crossing(Circle(NEAR, 1.0), Circle(NEAR, 2.0), NEAR) is None
    assert crossing(Circle(NEAR, 1.0), Line(0.0, 9.0), NEAR) is None
    assert crossing(Circle(NEAR, 1.0), Circle(NEAR + 9.0, 2.0), NEAR) is None
