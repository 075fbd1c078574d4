"""Borders and corners of sculptures, on two planes that meet at an angle."""

import numpy as np
import pytest

from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.sharp.draw import drawn_border, drawn_corner, drawn_crease
from crispline.sharp.trace import guide_along
from crispline.surface import Plane, Sphere

OPTIONS = LocateOptions(smooth_angle_deg=25.0)
UP = np.array([0.0, 0.0, 1.0])


def sides(angle_deg):
    """A level plane and one that falls off beyond the x axis."""
    angle = np.radians(angle_deg)
    slope = np.array([0.0, np.sin(angle), np.cos(angle)])
    empty = np.zeros((0, 3)), np.zeros(0)
    return [RegionFit(Plane(0.0 * UP, normal), 1, *empty, True) for normal in (UP, slope)]


def chain(height=0.0):
    x = np.arange(21.0)
    return np.column_stack([x, 0.4 * (-1.0) ** np.arange(21), np.full(21, height)])


@pytest.mark.parametrize(("angle_deg", "is_sharp"), [(20.0, False), (30.0, True), (90.0, True)])
def test_the_angle_along_the_guide_tells_what_is_sharp(angle_deg, is_sharp):
    border = drawn_border(guide_along(chain(), is_closed=False), sides(angle_deg), OPTIONS)
    assert border.is_contact != is_sharp
    rim = drawn_border(guide_along(chain(), is_closed=False), sides(angle_deg)[:1], OPTIONS)
    assert not rim.is_contact


def test_a_sharp_border_is_drawn_onto_its_edge_and_a_smooth_one_stays():
    for angle_deg, is_sharp in ((90.0, True), (10.0, False)):
        border = drawn_border(guide_along(chain(0.3), is_closed=False), sides(angle_deg), OPTIONS)
        curve = drawn_crease(border, (0.0 * UP, np.array([20.0, 0.0, 0.0]))).curve
        middle = curve.samples(101)[30:71]
        assert abs(middle[:, 1]).max() < 0.1
        level = 0.0 if is_sharp else 0.3
        np.testing.assert_allclose(middle[:, 2], level, atol=0.1)


def test_a_closed_smooth_border_stays_closed():
    turn = np.linspace(0.0, 2.0 * np.pi, 41)
    ring = np.column_stack([6.0 * np.cos(turn), 6.0 * np.sin(turn), 0.0 * turn])
    curve = drawn_crease(drawn_border(guide_along(ring, is_closed=True), sides(5.0), OPTIONS), None)
    ends = curve.curve.samples(2)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_an_end_of_a_sharp_border_goes_to_where_its_surfaces_meet_unless_that_is_far():
    surfaces = [side.surface for side in sides(90.0)]
    corner = drawn_corner(np.array([3.0, 0.5, 0.4]), surfaces, OPTIONS)
    np.testing.assert_allclose(corner.position, [3.0, 0.0, 0.0], atol=1e-12)
    assert corner.gap == pytest.approx(0.0, abs=1e-12)
    ball = [*surfaces, Sphere(np.array([9.0, 0.0, 0.0]), 7.0)]
    corner = drawn_corner(np.array([2.4, 0.5, 0.4]), ball, OPTIONS)
    np.testing.assert_allclose(corner.position, [2.0, 0.0, 0.0], atol=1e-3)
    far = drawn_corner(3.0 * UP, [Sphere(0.0 * UP, 20.0), surfaces[0]], OPTIONS)
    np.testing.assert_array_equal(far.position, 3.0 * UP)
