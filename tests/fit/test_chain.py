"""Grooves, undercuts and chamfers from the profiles of their noisy points."""

import numpy as np
import pytest
from profiles import SIGMA, sampled

from crispline.fit.chain import corner_cost, fit_chain
from crispline.fit.outline import Ray, round_cost
from crispline.fit.swept import Circle, Line

SHAFT = Line(0.0, 30.0)
SHOULDER = Line(np.pi / 2.0, 0.0)


def fitted(outline, first, last, n=1500):
    flat = sampled(np.array(outline), n)
    rays = Ray(first, np.array(outline[0])), Ray(last, np.array(outline[-1]))
    off = [np.abs(flat @ ray.line.normal - ray.line.offset) for ray in rays]
    chain = fit_chain(flat, np.min(off, axis=0) > 2.0 * SIGMA, rays, SIGMA, 0.5)
    return flat, rays, chain


GROOVE = [(30.0, -7.0), (30.0, -1.0), (28.0, -1.0), (28.0, 1.0), (30.0, 1.0), (30.0, 7.0)]


def test_a_groove_is_three_lines_and_likelier_than_a_round_or_nothing():
    flat, rays, chain = fitted(GROOVE, SHAFT, SHAFT)
    np.testing.assert_allclose(chain.vertices, GROOVE[1:-1], atol=0.15)
    assert [line.angle for line in chain.lines] == [np.pi / 2.0, 0.0, np.pi / 2.0]
    assert chain.cost < corner_cost(flat, rays, SIGMA)
    assert chain.cost < round_cost(flat, Circle(np.array([29.2, 0.0]), 1.2), rays, SIGMA) - 20.0


def test_a_round_groove_is_likelier_round():
    angle = np.linspace(np.pi / 2.0, 3.0 * np.pi / 2.0, 40)[::-1]
    arc = np.column_stack([30.0 + 2.0 * np.cos(angle), 2.0 * np.sin(angle)])
    outline = [(30.0, -7.0), *map(tuple, arc.tolist()), (30.0, 7.0)]
    flat, rays, chain = fitted(outline, SHAFT, SHAFT)
    circle = Circle(np.array([30.0, 0.0]), 2.0)
    assert round_cost(flat, circle, rays, SIGMA) < corner_cost(flat, rays, SIGMA)
    assert chain is None or round_cost(flat, circle, rays, SIGMA) < chain.cost


def test_an_undercut_is_a_bottom_and_a_wall():
    outline = [(36.0, 0.0), (28.5, 0.0), (28.5, 1.5), (30.0, 1.5), (30.0, 8.0)]
    _, _, chain = fitted(outline, SHOULDER, SHAFT)
    np.testing.assert_allclose(chain.vertices, outline[1:-1], atol=0.15)
    assert [line.angle for line in chain.lines] == [0.0, np.pi / 2.0]


def test_a_chamfer_and_the_foot_of_one_that_runs_back_are_one_line():
    for height in (2.0, -1.6):
        outline = [(38.0, 0.0), (32.0, 0.0), (30.0, height), (30.0, height + 8.0)]
        _, _, chain = fitted(outline, SHOULDER, SHAFT)
        assert len(chain.lines) == 1
        np.testing.assert_allclose(chain.vertices, outline[1:-1], atol=0.25)


@pytest.mark.parametrize("first", [SHOULDER, SHAFT])
def test_a_sharp_corner_or_a_plain_shaft_stays(first):
    start = (38.0, 0.0) if first is SHOULDER else (30.0, -8.0)
    flat, rays, chain = fitted([start, (30.0, 0.0), (30.0, 8.0)], first, SHAFT)
    if first is SHOULDER:
        assert chain is None or chain.cost > corner_cost(flat, rays, SIGMA)
    else:
        assert corner_cost(flat, rays, SIGMA) == np.inf  # they do not meet in one point
        assert chain is None
