from __future__ import annotations

import numpy as np
import pytest

from crispline.fit.bend import MODEL, Bend, fit_bend
from crispline.surface import Torus, unit
from crispline.surface.base import Array

AXIS = unit(np.array([0.2, -0.3, 1.0]))
MIDDLE = unit(np.cross(AXIS, [0.3, 1.0, 0.1]))
TRUTH = Bend(Torus(np.array([3.0, -2.0, 1.0]), AXIS, 40.0, 12.0), MIDDLE, -0.7, 0.6)


def on_bend(bend: Bend, lengths: tuple[float, float], n: int = 4000, noise: float = 0.0) -> Array:
    """Points all over a bend whose straights are so long; both may be zero."""
    rng = np.random.default_rng(1)
    torus = bend.torus
    arc = torus.major_radius * (bend.last - bend.first)
    at = rng.uniform(-lengths[0], arc + lengths[1], n)
    angle = bend.first + np.clip(at, 0.0, arc) / torus.major_radius
    beyond = np.where(at < 0.0, at, np.maximum(at - arc, 0.0))
    outward = bend.outward(angle)
    spine = torus.major_radius * outward + beyond[:, None] * np.cross(torus.axis, outward)
    turn = rng.uniform(0.0, 2.0 * np.pi, n)[:, None]
    radius = torus.minor_radius + noise * rng.standard_normal(n)[:, None]
    return np.asarray(
        torus.centre + spine + radius * (np.cos(turn) * outward + np.sin(turn) * torus.axis)
    )


def test_distances_vanish_on_the_bend_and_its_derivatives_are_those_of_its_distances() -> None:
    points = on_bend(TRUTH, (9.0, 14.0), 300)
    assert np.abs(MODEL.linearise(TRUTH, points)[0]).max() < 1e-12
    near = points + np.random.default_rng(2).normal(0.0, 2.0, points.shape)
    jacobian = MODEL.linearise(TRUTH, near)[1]
    step = 1e-6
    for k in range(9):
        ahead, behind = (
            MODEL.linearise(MODEL.move(TRUTH, sign * step * np.eye(9)[k]), near)[0]
            for sign in (1.0, -1.0)
        )
        assert (ahead - behind) / (2.0 * step) == pytest.approx(jacobian[:, k], abs=1e-5)


@pytest.mark.parametrize("lengths", [(8.0, 8.0), (0.0, 8.0), (30.0, 6.0)])
def test_a_bend_is_found_from_the_torus_that_its_straights_have_bent(
    lengths: tuple[float, float],
) -> None:
    points = on_bend(TRUTH, lengths, noise=0.1)
    start = Torus(TRUTH.torus.centre + 0.3, AXIS, 40.6, 12.1)
    bend = fit_bend(points, 0.1, start)
    assert bend is not None
    assert bend.torus.major_radius == pytest.approx(40.0, abs=0.1)
    assert bend.torus.minor_radius == pytest.approx(12.0, abs=0.02)
    assert np.linalg.norm(bend.torus.centre - TRUTH.torus.centre) < 0.15
    truth = [TRUTH.straight(0), TRUTH.straight(1)]
    for side in (0, 1):
        if lengths[side] > 0.0:
            assert bend.straight(side).axis @ truth[side].axis == pytest.approx(1.0, abs=1e-4)
            assert np.abs(bend.straight(side).axis @ bend.torus.axis) < 1e-12


def test_a_bend_tells_what_is_on_its_straights() -> None:
    points = on_bend(TRUTH, (10.0, 10.0))
    for side in (0, 1):
        beyond = TRUTH.is_on_straight(points, side)
        along = (points - TRUTH.straight(side).origin) @ TRUTH.straight(side).axis
        assert beyond.mean() > 0.1
        assert (along[beyond] > 0.0).all()
        assert np.abs(TRUTH.straight(side).signed_distance(points[beyond])).max() < 1e-9


def test_a_whole_ring_is_no_bend() -> None:
    ring = on_bend(Bend(TRUTH.torus, MIDDLE, -np.pi, np.pi), (0.0, 0.0))
    assert fit_bend(ring, 0.1, TRUTH.torus) is None
