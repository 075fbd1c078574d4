"""Profiles recovered exactly, and what they sweep against its definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.fit.swept import (
    Circle,
    Line,
    Revolution,
    Translation,
    concentric,
    fit_circle,
    fit_line,
)
from crispline.surface import Plane, unit

RNG = np.random.default_rng(0)
DIRECTION = unit(np.array([1.0, 2.0, -2.0]))
PLACE = np.array([3.0, -1.0, 2.0])


@given(angle=st.floats(-3.1, 3.1), offset=st.floats(-50.0, 50.0))
def test_a_line_is_recovered(angle, offset):
    line = Line(angle, offset)
    along = np.array([-line.normal[1], line.normal[0]])
    flat = offset * line.normal + np.outer(np.linspace(-4.0, 7.0, 20), along)
    found = fit_line(flat, 0.1)
    assert abs(found.normal @ line.normal) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(flat @ found.normal, found.offset, atol=1e-9)


@given(x=st.floats(-9.0, 9.0), radius=st.floats(1.0, 30.0), arc=st.floats(0.8, 6.0))
def test_a_circle_is_recovered_by_either_fit(x, radius, arc):
    centre = np.array([x, 2.0])
    angle = np.linspace(0.0, arc, 25)
    flat = centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    free, held = fit_circle(flat, 0.1), concentric(centre)(flat, 0.1)
    np.testing.assert_allclose(free.centre, centre, atol=1e-5)
    assert free.radius == pytest.approx(radius, abs=1e-5)
    np.testing.assert_array_equal(held.centre, centre)
    assert held.radius == pytest.approx(radius, abs=1e-9)


def test_foreign_points_do_not_count():
    angle = np.linspace(0.0, 2.0, 60)
    flat = 8.0 * np.column_stack([np.cos(angle), np.sin(angle)])
    flat[::15] += 3.0
    assert fit_circle(flat, 0.1).radius == pytest.approx(8.0, abs=1e-6)


@pytest.mark.parametrize("points", [np.empty((0, 2)), np.ones((1, 2))])
def test_too_few_points_have_no_profile(points):
    assert fit_line(points, 0.1) is None
    assert fit_circle(points, 0.1) is None


@pytest.mark.parametrize("profile", [Line(0.4, 3.0), Line(-2.0, 1.0), Circle(np.array([9, 4]), 2)])
@pytest.mark.parametrize("sweep", [Translation(DIRECTION), Revolution(PLACE, DIRECTION)])
def test_distances_are_those_of_the_profile(sweep, profile):
    """For points so near that their feet are on the same side of the axis."""
    if isinstance(profile, Line):
        along = np.array([-profile.normal[1], profile.normal[0]])
        flat = profile.offset * profile.normal + np.outer(np.linspace(-9.0, 9.0, 40), along)
    else:
        angle = np.linspace(0.0, 6.0, 40)
        flat = profile.centre + profile.radius * np.column_stack([np.cos(angle), np.sin(angle)])
    flat = flat + RNG.uniform(-0.1, 0.1, flat.shape)
    flat = flat[flat[:, 0] > 0.5]
    points = placed(sweep, flat)
    np.testing.assert_allclose(sweep.flattened(points), flat, atol=1e-9)
    if isinstance(profile, Line):
        expected = np.abs(flat @ profile.normal - profile.offset)
    else:
        expected = np.abs(np.linalg.norm(flat - profile.centre, axis=1) - profile.radius)
    surface = sweep.surface(profile)
    np.testing.assert_allclose(np.abs(surface.signed_distance(points)), expected, atol=1e-9)


def test_lines_across_and_along_the_axis():
    sweep = Revolution(PLACE, DIRECTION)
    assert isinstance(sweep.surface(Line(np.pi / 2.0, 3.0)), Plane)
    assert sweep.surface(Line(0.0, 3.0)).radius == 3.0
    assert sweep.surface(Circle(np.array([1.0, 0.0]), 2.0)) is None  # it would cross the axis


def placed(sweep, flat):
    """Points at random places of the sweep that cross the plane of the profile at ``flat``."""
    frame = np.linalg.svd(DIRECTION[None])[2][1:]
    if isinstance(sweep, Translation):
        back = np.linalg.lstsq(sweep.flattened(np.eye(3)).T, flat.T, rcond=None)[0].T
        return back + RNG.uniform(-5.0, 5.0, (len(flat), 1)) * DIRECTION
    turn = RNG.uniform(0.0, 2.0 * np.pi, len(flat))
    spoke = np.column_stack([np.cos(turn), np.sin(turn)]) @ frame
    return PLACE + flat[:, :1] * spoke + flat[:, 1:] * DIRECTION
