"""Narrow chamfers between known faces, straight and about an axis."""

import numpy as np
import pytest
from broken_edge import EDGE, SIDE, TOP, arc, broken_edge
from turned import turned

from crispline.options import RegionOptions
from crispline.region.narrow.bevels import with_bevels
from crispline.surface import Cone, Cylinder, Plane

FIRST, SECOND = 2, 3
UP, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
OPTIONS = RegionOptions()


def chamfered(is_straight, setbacks=(2.0, 2.0), turn=-1.0):
    return broken_edge([(EDGE - setbacks[0], 0.0), (EDGE, turn * setbacks[1])], is_straight, turn)


def surfaces(is_straight, lean=0.0):
    side = Plane(EDGE * ACROSS, ACROSS) if is_straight else Cylinder(np.zeros(3), UP, EDGE)
    middle = np.array([EDGE - 1.0, 0.0, -1.0])
    crumbs = [
        Plane(middle, np.array([np.cos(angle), 0.0, np.sin(angle)]))
        for angle in (0.25 * np.pi + lean, 0.25 * np.pi - lean)
    ]
    return {TOP: Plane(np.zeros(3), UP), SIDE: side, FIRST: crumbs[0], SECOND: crumbs[1]}


def found(made, label, is_straight, lean=0.0):
    known = {k: s for k, s in surfaces(is_straight, lean).items() if (label == k).any()}
    return with_bevels(label, made.fits(known, label), {}, made.evidence, OPTIONS)


def setbacks_of(surface):
    """Where a chamfer begins on the top and on the side, from their edge."""
    if isinstance(surface, Plane):
        off = (surface.origin - EDGE * ACROSS) @ surface.normal
        return -off / surface.normal[0], -off / surface.normal[2]
    height = surface.apex[2] + surface.axis[2] * EDGE / np.tan(surface.half_angle)
    return EDGE - abs(surface.apex[2]) * np.tan(surface.half_angle), -height


@pytest.mark.parametrize("turn", [-1.0, 1.0], ids=["convex", "concave"])
@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
def test_a_chamfer_that_two_faces_closed_over_comes_back(is_straight, turn):
    made, label, is_broken = chamfered(is_straight, turn=turn)
    new, bevels = found(made, label, is_straight)
    ((name, fit),) = bevels.items()
    assert isinstance(fit.surface, Plane if is_straight else Cone)
    assert (new[is_broken] == name).mean() > 0.8
    assert (new == name)[~is_broken].mean() < 0.05
    on_top, on_side = setbacks_of(fit.surface)
    assert on_top == pytest.approx(2.0, abs=0.15)
    assert on_side == pytest.approx(-turn * 2.0, abs=0.15)


def test_legs_that_differ_are_told_apart():
    made, label, _ = chamfered(is_straight=True, setbacks=(3.2, 1.8))
    _, bevels = found(made, label, is_straight=True)
    ((_, fit),) = bevels.items()
    assert setbacks_of(fit.surface) == pytest.approx((3.2, 1.8), abs=0.25)


@pytest.mark.parametrize("lean", [0.0, 0.2, 0.35])
def test_crumbs_that_lean_give_way(lean):
    made, label, is_broken = chamfered(is_straight=True)
    along = made.evidence.graph.points[:, 1]
    label = np.where(is_broken & (along < 25.0), FIRST, label)
    label = np.where(is_broken & (along > 35.0), SECOND, label)
    new, bevels = found(made, label, True, lean)
    ((name, fit),) = bevels.items()
    assert set(np.unique(new)) == {TOP, SIDE, name}
    assert setbacks_of(fit.surface) == pytest.approx((2.0, 2.0), abs=0.15)
    # Equal legs are what a cutter leaves: it leans by half a right angle, exactly.
    assert abs(fit.surface.normal[0]) == pytest.approx(np.sqrt(0.5), abs=1e-6)


def test_a_chamfer_is_as_wide_as_the_crumb_in_its_place():
    # Round the corner of a block the short piece of a wide chamfer passed for a cylinder.
    made = turned([(3.0, 0.0), (EDGE - 7.0, 0.0), (EDGE, -7.0), (EDGE, -14.0)], 30)
    label = np.choose(made.face, [TOP, FIRST, SIDE])
    new, bevels = found(made, label, is_straight=False)
    ((name, fit),) = bevels.items()
    assert (new[label == FIRST] == name).all()
    assert setbacks_of(fit.surface) == pytest.approx((7.0, 7.0), abs=0.1)


@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
def test_a_sharp_edge_stays_sharp(is_straight):
    made, label, _ = broken_edge([(EDGE, 0.0)], is_straight)
    new, bevels = found(made, label, is_straight)
    assert not bevels
    np.testing.assert_array_equal(new, label)


@pytest.mark.parametrize("radius", [2.2, 3.0])
def test_a_round_is_no_chamfer(radius):
    made, label, _ = broken_edge(arc(radius), is_straight=True)
    assert not found(made, label, is_straight=True)[1]


def test_a_chamfer_that_is_there_stays():
    made, label, is_broken = chamfered(is_straight=True)
    new, bevels = found(made, np.where(is_broken, FIRST, label), is_straight=True)
    assert not bevels
    assert (new[is_broken] == FIRST).all()


def test_the_ledge_of_a_step_is_no_place_for_a_chamfer():
    """Nothing has the wall of the step yet, and a chamfer over the ledge passes its points."""
    made, label, _ = broken_edge([(EDGE - 4.0, 0.0), (EDGE - 3.9, -1.4), (EDGE, -1.4)], True)
    points = made.evidence.graph.points
    on_ledge = (np.abs(points[:, 2] + 1.4) < 0.4) & (points[:, 0] < EDGE - 0.3)
    label = np.where(on_ledge, FIRST, label)
    fits = made.fits(
        {
            TOP: Plane(np.zeros(3), UP),
            SIDE: Plane(EDGE * ACROSS, ACROSS),
            FIRST: Plane(-1.4 * UP, UP),
        },
        label,
    )
    new, bevels = with_bevels(label, fits, {}, made.evidence, OPTIONS)
    assert not bevels
    np.testing.assert_array_equal(new, label)
