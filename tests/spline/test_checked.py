"""Every way in which numbers from outside can be wrong gives one clear sentence."""

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.spline.checked import checked_grid, checked_spline

KNOTS = [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0]
NET = np.random.default_rng(0).normal(size=(5, 5, 3))


def checked(**changes):
    given = {
        "degree_u": 3,
        "degree_v": 3,
        "knots_u": KNOTS,
        "knots_v": KNOTS,
        "control_points": NET,
        "weights": None,
    }
    return checked_spline(**{**given, **changes}, where="'lid.json'")


def changed(array, place, value):
    array = np.array(array, dtype=float)
    array[place] = value
    return array


def test_good_numbers_pass_and_are_copied():
    spline = checked(weights=changed(np.ones((5, 5)), (2, 2), 2.0))
    assert spline.control_points is not NET
    np.testing.assert_array_equal(spline.control_points, NET)
    assert spline.weights[2, 2] == 2.0


def test_equal_weights_are_none():
    assert checked(weights=np.full((5, 5), 0.7)).weights is None


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"control_points": []}, "control points, found none"),
        ({"control_points": np.ones((5, 5))}, r"\(n_u, n_v, 3\), found shape \(5, 5\)"),
        ({"control_points": np.ones((5, 5, 4))}, r"found shape \(5, 5, 4\)"),
        ({"control_points": [[1.0], [1.0, 2.0]]}, "as an array of numbers, found other content"),
        ({"control_points": "net"}, "as an array of numbers, found other content"),
        ({"control_points": changed(NET, (1, 1, 1), np.nan)}, "finite control points, found 1"),
        ({"degree_u": 0}, "a degree_u of at least 1, found 0"),
        ({"degree_v": 2.5}, "a degree_v of at least 1, found 2.5"),
        ({"degree_v": 5}, "at least 6 control points along v for degree 5, found 5"),
        ({"knots_u": KNOTS[1:]}, r"9 knots_u \(5 control points \+ degree 3 \+ 1\)"),
        ({"knots_v": changed(KNOTS, 4, np.inf)}, "finite knots_v, found 1"),
        ({"knots_v": changed(KNOTS, 4, 3.0)}, "found 3 followed by 2 at place 5"),
        ({"knots_u": [0.0] * 5 + [2.0] * 4}, "found one more than 4 times"),
        ({"knots_u": [0.0] * 9}, "found one more than 4 times"),
        ({"weights": np.ones(25)}, r"one weight for each control point, shape \(5, 5\)"),
        ({"weights": changed(np.ones((5, 5)), (3, 1), 0.0)}, r"found 0 at \(3, 1\)"),
        ({"weights": changed(np.ones((5, 5)), (3, 1), np.nan)}, "finite weights, found 1"),
    ],
)
def test_numbers_that_make_no_sense_are_refused(changes, sentence):
    with pytest.raises(InputError, match=f"^'lid.json': expected .*{sentence}.*; ") as caught:
        checked(**changes)
    assert "\n" not in str(caught.value)


def test_a_surface_torn_inside_is_refused():
    knots = [0.0] * 4 + [1.0] * 4 + [2.0] * 4
    with pytest.raises(InputError, match=r"at most 3 times inside .* one more than 3 times"):
        checked(knots_u=knots, control_points=np.ones((8, 5, 3)))


def grid():
    return np.random.default_rng(1).normal(size=(6, 7, 3))


def test_invalid_pixels_become_nan_as_a_whole():
    points = grid()
    points[1, 1, 2] = np.inf
    points[2, 3] = points[4, 4] = 0.0
    found = checked_grid(points)
    is_invalid = np.isnan(found).all(axis=2)
    assert np.argwhere(is_invalid).tolist() == [[1, 1], [2, 3], [4, 4]]
    np.testing.assert_array_equal(found[~is_invalid], points[~is_invalid])
    assert np.isinf(points[1, 1, 2])  # what was given stays as it is


def test_a_single_point_at_the_origin_is_a_point():
    points = grid()
    points[2, 3] = 0.0
    np.testing.assert_array_equal(checked_grid(points), points)


@pytest.mark.parametrize(
    ("points", "sentence"),
    [
        (np.ones((50, 3)), r"found shape \(50, 3\); rebuild the rows and columns"),
        (np.ones((50, 40)), r"found shape \(50, 40\); turn a depth image into x, y and z"),
        (np.ones((5, 5, 4)), r"found shape \(5, 5, 4\)"),
        (grid()[:3], "at least 4 rows and 4 columns of points, found 3 x 7"),
        (np.full((5, 5, 3), np.nan), "finite points, found none"),
        (np.zeros((5, 5, 3)), "finite points, found none"),
        (np.ones((5, 5, 3)), "a surface, found one point 25 times"),
        (np.array([["a"]]), "points as an array of numbers"),
    ],
)
def test_what_is_no_grid_of_points_is_refused(points, sentence):
    with pytest.raises(InputError, match=f"^the grid: expected .*{sentence}"):
        checked_grid(points)
