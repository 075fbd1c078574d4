"""Narrow fillets between known faces, straight and about an axis."""

import numpy as np
import pytest
from turned import turned

from crispline.options import RegionOptions
from crispline.region.narrow.rounds import with_rounds
from crispline.surface import Cylinder, Plane, Sphere, Torus

TOP, SIDE, CRUMB = 0, 1, 2
RADIUS, EDGE, N_AROUND = 2.2, 16.2, 60
UP, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
OPTIONS = RegionOptions()


def part(breaking, is_straight, turn=-1.0):
    """A top whose rim is broken as given, and a side that goes down from it, or up."""
    corners = [(3.0, 0.0), *breaking, (EDGE, turn * 9.0)]
    made = turned(corners, N_AROUND, is_straight)
    points = made.evidence.graph.points
    reach = points[:, 0] if is_straight else np.hypot(points[:, 0], points[:, 1])
    label = np.where(EDGE - reach > np.abs(points[:, 2]), TOP, SIDE)  # they meet halfway
    is_broken = (made.face > 0) & (made.face < made.face.max())
    return made, label, is_broken


def rounded(is_straight, turn=-1.0, n_pieces=5):
    turns = np.linspace(0.0, 0.5 * np.pi, n_pieces + 1)
    inner = EDGE - RADIUS
    arc = [(inner + RADIUS * np.sin(t), turn * RADIUS * (1.0 - np.cos(t))) for t in turns]
    return part(arc, is_straight, turn)


def surfaces(is_straight):
    side = Plane(EDGE * ACROSS, ACROSS) if is_straight else Cylinder(np.zeros(3), UP, EDGE)
    return {TOP: Plane(np.zeros(3), UP), SIDE: side, CRUMB: Sphere(-9.0 * UP, EDGE)}


def found(made, label, is_straight):
    known = {k: s for k, s in surfaces(is_straight).items() if (label == k).any()}
    return with_rounds(label, made.fits(known, label), made.evidence, OPTIONS)


@pytest.mark.parametrize("turn", [-1.0, 1.0], ids=["convex", "concave"])
@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
def test_a_round_that_two_faces_closed_over_comes_back(is_straight, turn):
    made, label, is_broken = rounded(is_straight, turn)
    new, rounds = found(made, label, is_straight)
    ((name, fit),) = rounds.items()
    assert (new[is_broken] == name).mean() > 0.8
    assert (new == name)[~is_broken].mean() < 0.05
    if is_straight:
        assert isinstance(fit.surface, Cylinder)
        assert fit.surface.radius == pytest.approx(RADIUS, abs=0.2)
    else:
        assert isinstance(fit.surface, Torus)
        assert fit.surface.minor_radius == pytest.approx(RADIUS, abs=0.2)
        centre = turn * fit.surface.minor_radius
        np.testing.assert_allclose(fit.surface.centre, [0.0, 0.0, centre], atol=1e-6)
    assert fit.orientation == -turn
    for face in (TOP, SIDE):  # it touches both
        touching = surfaces(is_straight)[face].project(fit.points)[0]
        gap = np.abs(fit.surface.signed_distance(touching)).min()
        assert gap < 0.05


def test_a_crumb_of_the_round_gives_way():
    made, label, is_broken = rounded(is_straight=True)
    points = made.evidence.graph.points
    label = np.where(is_broken & (points[:, 1] > 20.0) & (points[:, 1] < 40.0), CRUMB, label)
    new, rounds = found(made, label, is_straight=True)
    ((name, _),) = rounds.items()
    assert not (new == CRUMB).any()
    assert (new[is_broken] == name).mean() > 0.8


@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
def test_a_sharp_edge_stays_sharp(is_straight):
    made, label, _ = part([(EDGE, 0.0)], is_straight)
    new, rounds = found(made, label, is_straight)
    assert not rounds
    np.testing.assert_array_equal(new, label)


def test_a_chamfer_is_no_round():
    made, label, _ = part([(EDGE - 2.0, 0.0), (EDGE, -2.0)], is_straight=True)
    assert not found(made, label, is_straight=True)[1]
