"""The likelihood of an outline against its definition."""

import numpy as np
import pytest
from profiles import SIGMA, sampled

from crispline.fit.outline import Ray, densities, from_ray, outline_between, outline_cost
from crispline.fit.swept import Line


def test_densities_of_all_spans_add_up_to_one():
    outline = np.array([[30.0, 0.0], [30.0, 6.0], [27.0, 6.0]])
    x, y = np.meshgrid(np.arange(22.0, 35.0, 0.1), np.arange(-5.0, 11.0, 0.1))
    density, _ = densities(np.column_stack([x.ravel(), y.ravel()]), outline, SIGMA)
    # In units in which a point on a line has density one across it.
    whole = density.sum() * 0.1**2 / (np.sqrt(2.0 * np.pi) * SIGMA)
    assert whole == pytest.approx(1.0, rel=1e-3)
    wide, narrow = density.sum(axis=1)
    assert wide / narrow == pytest.approx(6.0 * 30.0 / (3.0 * 28.5), rel=0.01)


def test_what_points_were_taken_from_is_likelier_than_what_is_near_it():
    groove = np.array([[30.0, -6.0], [30.0, -1.0], [28.0, -1.0], [28.0, 1.0], [30.0, 1.0], [30, 6]])
    flat = sampled(groove)
    true = outline_cost(flat, groove, SIGMA)
    plain = outline_cost(flat, groove[[0, -1]], SIGMA)
    notch = outline_cost(flat, groove[[0, 1, 3, 4, 5]], SIGMA)
    assert true < notch < plain


def test_more_lines_than_there_are_cost():
    bare = np.array([[30.0, -6.0], [30.0, 6.0]])
    flat = sampled(bare)
    busy = np.array([[30.0, -6.0], [30.0, -0.5], [29.5, -0.5], [29.5, 0.5], [30.0, 0.5], [30, 6]])
    assert outline_cost(flat, bare, SIGMA) < outline_cost(flat, busy, SIGMA) - 20.0


def test_an_outline_reaches_as_far_as_the_points():
    rays = (Ray(Line(0.0, 10.0), np.array([10.0, -3.0])), Ray(Line(0.0, 10.0), np.array([10.0, 3])))
    flat = np.column_stack([np.full(9, 10.0), np.linspace(-4.0, 7.0, 9)])
    outline = outline_between(flat, np.array([[10.0, -1.0], [10.0, 1.0]]), rays)
    np.testing.assert_allclose(outline[[0, -1]], [[10.0, -4.0], [10.0, 7.0]])


def test_distances_from_a_ray_are_those_from_its_end_behind_it():
    ray = Ray(Line(np.pi / 2.0, 2.0), np.array([9.0, 2.0]))
    flat = np.array([[6.0, 5.0], [1.0, 2.0]])
    np.testing.assert_allclose(from_ray(flat, np.array([4.0, 2.0]), ray), [3.0, 3.0])
