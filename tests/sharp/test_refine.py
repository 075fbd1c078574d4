"""Refinement ends, whatever the constraints do."""

import numpy as np
import pytest

from crispline.options import LocateOptions
from crispline.sharp import refine
from crispline.surface import Cone, Cylinder, Plane
from crispline.surface.intersect import intersect


def test_refinement_stops_when_new_points_fall_on_old_ones(monkeypatch):
    """Two cylinders whose curve needs more nodes than are ever kept."""
    t = np.linspace(-1.0, 1.0, 40)
    curve = np.stack([4.0 * np.cos(t), 4.0 * np.sin(t), np.sqrt(100.0 - (4 * np.sin(t)) ** 2)], 1)
    pipes = [
        Cylinder(np.zeros(3), np.array([0.0, 0.0, 1.0]), 4.0),
        Cylinder(np.zeros(3), np.array([1.0, 0.0, 0.0]), 10.0),
    ]
    rounds = iter(range(50))
    kept = []

    def stubborn(points):
        if next(rounds, None) is None:
            pytest.fail("no end of the refinement")
        kept.append(distinct(points))
        return kept[min(1, len(kept) - 1)]  # the second call makes the first nodes

    distinct = refine._distinct
    monkeypatch.setattr(refine, "_distinct", stubborn)
    found = refine.curve_along(curve, (curve[0], curve[-1]), pipes, LocateOptions())
    assert len(kept) > 2
    np.testing.assert_allclose(found.samples(2), curve[[0, -1]], atol=1e-9)


def test_points_that_repeat_the_last_are_dropped():
    """Three in one place at the end of a crease: a rocker arm broke down on them."""
    points = np.zeros((6, 3))
    points[:, 0] = [0.0, 0.0, 1.0, 2.0, 2.0, 2.0]
    np.testing.assert_array_equal(refine._distinct(points)[:, 0], [0.0, 1.0, 2.0])


@pytest.mark.parametrize("is_closed", [False, True])
def test_points_drawn_into_one_are_no_curve(is_closed):
    """Two surfaces that touched in one point, on a scan with much noise, broke down here."""
    turn = np.linspace(0.0, 2.0 * np.pi, 25)
    ring = np.stack([np.cos(turn) - 1.0, np.sin(turn), 1.0 + np.cos(turn)], axis=1)
    ring[[0, -1]] = 0.0
    ends = None if is_closed else (np.zeros(3), np.zeros(3))
    corner = [Plane(np.zeros(3), normal) for normal in np.eye(3)]
    assert refine.curve_along(ring, ends, corner, LocateOptions()) is None


@pytest.mark.parametrize("miss", [0.06, 0.16, 0.3])
def test_a_curve_leads_to_a_corner_beside_it_without_a_hook(miss):
    """A rim of a bent sheet crossed itself where its corner lay off its plane."""
    sides = [Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])), Plane(np.zeros(3), np.eye(3)[1])]
    x = np.concatenate([[0.0], np.linspace(0.05, 20.0, 30)])
    points = np.stack([x, np.zeros_like(x), np.zeros_like(x)], axis=1)
    ends = (points[0] + [0.0, 0.7 * miss, 0.7 * miss], points[-1])
    points[0] = ends[0]
    curve = refine.curve_along(points, ends, sides, LocateOptions())
    places = curve.samples(2000)
    assert (np.diff(places[:, 0]) > 0.0).all()
    assert np.abs(places[:, 1:]).max() < 1.1 * miss
    far = places[places[:, 0] > 4.0]
    np.testing.assert_allclose(far[:, 1:], 0.0, atol=1e-2)
    np.testing.assert_allclose(places[[0, -1]], np.stack(ends), atol=1e-9)


@pytest.mark.parametrize("lift", [-3e-3, 0.0, 3e-3])
@pytest.mark.parametrize("at_start", [True, False])
def test_two_curves_leave_a_cusp_without_crossing(lift, at_start):
    """The round chamfer of a nut touches a flat: OCCT could not fill the crescent beside."""
    radius, axis = 45.0, np.array([0.0, 0.0, 1.0])
    apex = (radius / np.tan(np.radians(60.0))) * axis
    cone = Cone(apex, -axis, np.radians(60.0))
    top, side = Plane(np.zeros(3), axis), Plane((radius + lift) * np.eye(3)[0], np.eye(3)[0])
    tip = np.array([radius + lift, 0.0, 0.0])
    curves = []
    for flat in (top, side):
        y = np.linspace(0.0, 20.0, 30)
        points, _ = intersect(np.stack([0 * y + radius, y, -0.005 * y**2], 1), [cone, flat])
        ends = (tip, points[-1])
        if not at_start:
            points, ends = points[::-1], ends[::-1]
        cusps = (at_start, not at_start)
        curve = refine.curve_along(points, ends, [cone, flat], LocateOptions(), cusps)
        places = curve.samples(4001)
        assert np.linalg.norm(places[0 if at_start else -1] - tip) < 1e-9
        assert max(np.abs(s.signed_distance(places)).max() for s in (cone, flat)) < 0.02
        curves.append(places if at_start else places[::-1])
    circle, hyperbola = curves
    width = np.interp(hyperbola[:, 1], circle[:, 1], circle[:, 2]) - hyperbola[:, 2]
    along = hyperbola[:, 1]
    near = (along > 0.01) & (along < 5.0)
    assert (width[near] > 0.004 * along[near]).all()
