"""Narrow fillets between known faces, straight and about an axis."""

from dataclasses import replace

import numpy as np
import pytest
from broken_edge import EDGE, SIDE, TOP, arc, broken_edge
from turned import SIGMA, turned
from witnessed import witnessed

from crispline.options import RegionOptions
from crispline.region.fitting import held_fit
from crispline.region.narrow.rounds import with_rounds
from crispline.surface import Cone, Cylinder, Plane, Sphere, Torus

CRUMB = 2
RADIUS = 2.2
UP, ACROSS, ALONG = np.eye(3)[[2, 0, 1]]
EYE, BALL = 30.0, 6.0
OPTIONS = RegionOptions()


def rounded(is_straight, turn=-1.0, n_pieces=5):
    return broken_edge(arc(RADIUS, n_pieces, turn), is_straight, turn)


def surfaces(is_straight):
    side = Plane(EDGE * ACROSS, ACROSS) if is_straight else Cylinder(np.zeros(3), UP, EDGE)
    return {TOP: Plane(np.zeros(3), UP), SIDE: side, CRUMB: Sphere(-9.0 * UP, EDGE)}


def found(made, label, is_straight):
    known = {k: s for k, s in surfaces(is_straight).items() if (label == k).any()}
    return with_rounds(label, made.fits(known, label), {}, made.evidence, OPTIONS)


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


@pytest.mark.parametrize("radius", [4.2, 5.2, 6.4])
def test_a_larger_round_is_found_where_a_crumb_is_part_of_it(radius):
    # The corner of a pocket was a torus, as its faces had taken both of its ends.
    made, label, _ = broken_edge(arc(radius, 6), is_straight=True)
    label = np.where((made.face > 2) & (made.face < 5), CRUMB, label)
    _new, rounds = found(made, label, is_straight=True)
    ((_, fit),) = rounds.items()
    assert fit.surface.radius == pytest.approx(radius, abs=0.3)


@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
def test_a_sharp_edge_stays_sharp(is_straight):
    made, label, _ = broken_edge([(EDGE, 0.0)], is_straight)
    new, rounds = found(made, label, is_straight)
    assert not rounds
    np.testing.assert_array_equal(new, label)


@pytest.mark.parametrize("is_straight", [True, False], ids=["straight", "turned"])
@pytest.mark.parametrize("width", [1.8, 2.0, 2.6])
def test_a_chamfer_is_no_round(width, is_straight):
    # Small ones were rounds, as few points lie off both faces to tell a line from an arc.
    breaking = [(EDGE - width, 0.0), (EDGE, -width)]
    made, label, _ = broken_edge(breaking, is_straight, n_around=150)
    assert not found(made, label, is_straight)[1]


def with_strip(breaking):
    """A broken edge that one plane stands for, in more patches than a crumb has."""
    made, label, is_broken = broken_edge(breaking, is_straight=True)
    label = np.where(is_broken, CRUMB, label)
    normal = (UP + ACROSS) / np.sqrt(2.0)
    middle = made.evidence.graph.points[is_broken].mean(axis=0)
    known = {**surfaces(is_straight=True), CRUMB: Plane(middle, normal)}
    options = replace(OPTIONS, max_pruned_patches=100)
    assert is_broken.sum() > options.max_pruned_patches
    return label, *with_rounds(label, made.fits(known, label), {}, made.evidence, options)


def test_a_long_strip_of_a_plane_gives_way_to_the_round_it_stands_for():
    turns = np.linspace(0.0, 0.5 * np.pi, 6)
    inner = EDGE - RADIUS
    arc = [(inner + RADIUS * np.sin(t), -RADIUS * (1.0 - np.cos(t))) for t in turns]
    label, new, rounds = with_strip(arc)
    ((name, fit),) = rounds.items()
    assert (new[label == CRUMB] == name).mean() > 0.9
    assert isinstance(fit.surface, Cylinder)
    assert fit.surface.radius == pytest.approx(RADIUS, abs=0.2)


@pytest.mark.parametrize("turn", [-1.0, 1.0], ids=["convex", "concave"])
def test_a_cone_in_the_middle_of_a_wide_round_about_an_axis_gives_way(turn):
    radius, edge = 5.0, 30.0
    turns = np.linspace(0.0, 0.5 * np.pi, 9)
    inner = edge - radius
    arc = [(inner + radius * np.sin(t), turn * radius * (1.0 - np.cos(t))) for t in turns]
    made = turned([(12.0, 0.0), *arc, (edge, turn * 18.0)], 150)
    points = made.evidence.graph.points
    reach = np.hypot(points[:, 0], points[:, 1])
    label = np.where(edge - reach > np.abs(points[:, 2]), TOP, SIDE)
    is_middle = np.isin(made.face, [4, 5])
    label[is_middle] = CRUMB
    middle = inner + radius * np.sqrt(0.5) + turn * turn * radius * (1.0 - np.sqrt(0.5))
    known = {
        TOP: Plane(np.zeros(3), UP),
        SIDE: Cylinder(np.zeros(3), UP, edge),
        CRUMB: Cone(-turn * middle * -UP, turn * -UP, np.pi / 4.0),
    }
    options = replace(OPTIONS, max_pruned_patches=100)
    assert is_middle.sum() > options.max_pruned_patches
    new, rounds = with_rounds(label, made.fits(known, label), {}, made.evidence, options)
    ((name, fit),) = rounds.items()
    assert isinstance(fit.surface, Torus)
    assert fit.surface.minor_radius == pytest.approx(radius, abs=0.2)
    assert (new[(made.face > 1) & (made.face < 8)] == name).mean() > 0.9


def test_a_long_strip_of_a_chamfer_stays():
    label, new, rounds = with_strip([(EDGE - 2.0, 0.0), (EDGE, -2.0)])
    assert not rounds
    np.testing.assert_array_equal(new, label)


CORNER, LENGTH, DEPTH = 18.0, 60, 14.0  # radius of the plate's corner, its sides, its wall


def plate_rim(radii, seed):
    """A quarter of the rim of a plate: side, round corner, side; a fillet along all of it.

    Returns the evidence, the labels without the fillet, and the surfaces: top, first side,
    corner, second side.
    """
    bend = np.arange(0.5, 0.5 * np.pi * CORNER)
    places = [("first", k + 0.5) for k in range(LENGTH)]
    places += [("corner", b / CORNER) for b in bend]
    places += [("second", k + 0.5) for k in range(LENGTH)]
    rows = []
    for part, at in places:
        radius = radii[part]
        arc = np.linspace(0.0, 0.5 * np.pi, 2 * round(1.6 * radius) + 1)[1::2]
        inward = [*np.arange(8.5, radius, -1.0), *(radius * (1.0 - np.sin(arc)))]
        depth = [*(0.0 * np.arange(8.5, radius, -1.0)), *(radius * (1.0 - np.cos(arc)))]
        tilt = [*(0.0 * np.arange(8.5, radius, -1.0)), *arc]
        n_wall = 20 - len(inward)
        down = radius + (np.arange(n_wall) + 0.5) * (DEPTH - radius) / n_wall
        inward, depth = [*inward, *(0.0 * down)], [*depth, *down]
        tilt = [*tilt, *np.full(n_wall, 0.5 * np.pi)]
        if part == "first":
            origin, out = np.array([CORNER, at - LENGTH, 0.0]), ACROSS
        elif part == "second":
            origin, out = np.array([-at, CORNER, 0.0]), np.array([0.0, 1.0, 0.0])
        else:
            out = np.array([np.cos(at), np.sin(at), 0.0])
            origin = CORNER * out
        for d, z, t in zip(inward, depth, tilt, strict=True):
            rows.append((*(origin - d * out - z * UP), *(np.sin(t) * out + np.cos(t) * UP), d - z))
    table = np.array(rows)
    number = np.arange(len(table)).reshape(len(places), 20)
    pairs = (
        [number[:-1].ravel(), number[1:].ravel()],
        [number[:, :-1].ravel(), number[:, 1:].ravel()],
    )
    pairs = np.concatenate([np.column_stack(pair) for pair in pairs])
    side = np.array([{"first": 1, "corner": 2, "second": 3}[part] for part, _ in places])
    label = np.where(table[:, 6] > 0.0, TOP, side.repeat(20))
    evidence = witnessed(table[:, :3], table[:, 3:6], pairs, SIGMA, seed)
    known = {
        TOP: Plane(np.zeros(3), UP),
        1: Plane(CORNER * ACROSS, ACROSS),
        2: Cylinder(np.zeros(3), UP, CORNER),
        3: Plane(np.array([0.0, CORNER, 0.0]), np.array([0.0, 1.0, 0.0])),
    }
    fits = {
        k: held_fit(surface, np.flatnonzero(label == k), evidence) for k, surface in known.items()
    }
    return evidence, label, fits


def ball(fit):
    torus = isinstance(fit.surface, Torus)
    return fit.surface.minor_radius if torus else fit.surface.radius


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_one_ball_rolls_round_a_corner(seed):
    evidence, label, fits = plate_rim(dict.fromkeys(("first", "corner", "second"), 2.2), seed)
    rounds = with_rounds(label, fits, {}, evidence, OPTIONS)[1]
    kinds = sorted(fit.surface.kind for fit in rounds.values())
    assert kinds == ["cylinder", "cylinder", "torus"]
    radii = [ball(fit) for fit in rounds.values()]
    assert len(set(radii)) == 1
    assert radii[0] == pytest.approx(2.2, abs=0.1)


def test_balls_that_the_points_tell_apart_stay_two():
    evidence, label, fits = plate_rim({"first": 2.5, "corner": 2.5, "second": 3.6}, 0)
    rounds = with_rounds(label, fits, {}, evidence, OPTIONS)[1]
    straight = sorted(ball(fit) for fit in rounds.values() if isinstance(fit.surface, Cylinder))
    assert straight == pytest.approx([2.5, 3.6], abs=0.3)


def shank_and_eye(away):
    """A plane and a cylinder along it, which a ball touches from outside (1) or inside (-1)."""
    at = np.radians(-30.0)  # where the ball touches the eye, from its centre above the plane
    toward = np.array([np.cos(at), np.sin(at)])
    eye = np.array([0.0, BALL]) + (BALL + away * EYE) * toward
    turn = np.radians(np.linspace(-90.0, -30.0, 7))
    arc = np.column_stack([np.cos(turn), 1.0 + np.sin(turn)]) * BALL
    steps = np.arange(1.0, 15.0) / EYE
    turn = at + np.pi - steps if away > 0.0 else at + steps
    wall = eye + EYE * np.column_stack([np.cos(turn), np.sin(turn)])
    made = turned([(-15.0, 0.0), *arc, *wall], 40, is_straight=True)
    return made, Cylinder(np.array([eye[0], 0.0, eye[1]]), ALONG, EYE)


@pytest.mark.parametrize("away", [1.0, -1.0], ids=["boss", "bore"])
def test_the_round_between_a_plane_and_a_cylinder_along_it_comes_back(away):
    # The shank of a rod runs into its eye: what was found of the round passed for a plane.
    made, eye = shank_and_eye(away)
    is_broken, is_middle = (made.face > 0) & (made.face < 7), np.isin(made.face, [3, 4])
    label = np.select([is_middle, made.face < 4], [CRUMB, TOP], SIDE)
    middle = made.evidence.graph.points[is_middle].mean(axis=0)
    tilted = Plane(middle, np.array([-0.5, 0.0, np.sqrt(0.75)]))
    fits = made.fits({TOP: Plane(np.zeros(3), UP), SIDE: eye, CRUMB: tilted}, label)
    new, rounds = with_rounds(label, fits, {}, made.evidence, OPTIONS)
    ((name, fit),) = rounds.items()
    assert (new[is_broken] == name).mean() > 0.8
    assert (new == name)[~is_broken].mean() < 0.1
    assert isinstance(fit.surface, Cylinder)
    assert fit.surface.radius == pytest.approx(BALL, abs=0.4)
    centre = (fit.surface.origin - eye.origin)[[0, 2]]  # it touches both
    assert np.linalg.norm(centre) == pytest.approx(EYE + away * fit.surface.radius)
    assert fit.surface.origin[2] == pytest.approx(fit.surface.radius)
