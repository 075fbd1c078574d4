"""Rounds that go on round a corner of their wall."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from witnessed import witnessed

from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import held_fit
from crispline.region.narrow.turns import with_turns
from crispline.surface import Cone, Cylinder, Plane, Torus

BALL, SIGMA, REACH, HIGH = 6.0, 0.12, 30, 14
FLOOR, ROUND, WALL, CRUMB = 0, (1, 2), 3, 4


def corner(major, is_pad=False):
    """Patches about a unit apart round the corner of a pocket or on the top of a pad.

    A ball rolls along a floor at z = 0 and two planes, which a cylinder about the z axis joins;
    its way round the cylinder has the radius ``major``. Where the ball is inside of the part, the
    same surfaces are the top of a pad.
    """
    steps = np.arange(REACH) + 0.5
    bow = (np.arange(9) + 0.5) * (0.5 * np.pi / 9)  # of the section, from the wall to the floor
    turns = np.linspace(0.0, 0.5 * np.pi, 2 * int(np.ceil(major + BALL)))
    out, down = np.cos(bow), -np.sin(bow)
    rows, face = [], []

    def add(name, radial, height, position, direction):
        """Rows of a section ``(radial, height)`` about the way of the ball."""
        place = position[:, None] + radial[None, :, None] * direction[:, None]
        place = place + height[None, :, None] * np.array([0.0, 0.0, 1.0])
        rows.append(place.reshape(-1, 3))
        face.extend([name] * rows[-1].shape[0])

    across = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    middle = np.tile([0.0, 0.0, BALL], (len(turns), 1))
    add(CRUMB, major + BALL * out, BALL * down, middle, across)
    add(WALL, np.full(HIGH, major + BALL), np.arange(HIGH) + 0.5, middle, across)
    for k, name in enumerate(ROUND):
        way = np.zeros((REACH, 3))
        way[:, 1 - k], way[:, 2] = -steps, BALL
        side = np.tile(np.eye(3)[k], (REACH, 1))
        add(name, major + BALL * out, BALL * down, way, side)
    x, y = (grid.ravel() for grid in np.meshgrid(*2 * [np.arange(-REACH, major) + 0.5]))
    inside = (x < 0.0) | (y < 0.0) | (np.hypot(x, y) < major)
    rows.append(np.column_stack([x, y, 0.0 * x])[inside])
    face += [FLOOR] * int(inside.sum())
    points, face = np.concatenate(rows), np.array(face)
    surfaces = truth(major)
    normals = np.empty_like(points)
    for name, surface in surfaces.items():
        normals[face == name] = surface.project(points[face == name])[1]
    normals[face != FLOOR] *= -1.0  # what the ball has left is hollow
    if is_pad:
        normals = -normals
    pairs = cKDTree(points).query_pairs(1.6, output_type="ndarray")
    return witnessed(points, normals, pairs[np.lexsort(pairs.T)], SIGMA), face


def truth(major):
    centre, z = np.array([0.0, 0.0, BALL]), np.array([0.0, 0.0, 1.0])
    rounds = {
        name: Cylinder(centre + major * np.eye(3)[k], np.eye(3)[1 - k], BALL)
        for k, name in enumerate(ROUND)
    }
    return {
        FLOOR: Plane(np.zeros(3), z),
        **rounds,
        WALL: Cylinder(np.zeros(3), -z, major + BALL),
        CRUMB: Torus(centre, z, major, BALL),
    }


def covered(evidence, face, surfaces):
    """The faces have what of the torus they nearly explain; the rest passes for a cone."""
    points, label = evidence.graph.points, face.copy()
    for name in (FLOOR, *ROUND, WALL):
        near = np.abs(surfaces[name].signed_distance(points)) < 0.25
        label[(face == CRUMB) & near] = name
    cone = Cone(np.array([0.0, 0.0, -12.0]), np.array([0.0, 0.0, 1.0]), np.radians(40.0))
    return label, {**surfaces, CRUMB: cone}


def found(evidence, label, surfaces):
    fits = {
        name: held_fit(surface, np.flatnonzero(label == name), evidence)
        for name, surface in surfaces.items()
    }
    return with_turns(label, fits, evidence, RegionOptions(), FitOptions())


@pytest.mark.parametrize("is_pad", [False, True], ids=["pocket", "pad"])
@pytest.mark.parametrize("major", [7.0, 3.0], ids=["ring", "spindle"])
def test_the_round_goes_on_round_the_corner(major, is_pad):
    evidence, face = corner(major, is_pad)
    label, surfaces = covered(evidence, face, truth(major))
    new, turns = found(evidence, label, surfaces)
    assert len(turns) == 1
    ((name, fit),) = turns.items()
    assert isinstance(fit.surface, Torus)
    np.testing.assert_allclose(fit.surface.centre, [0.0, 0.0, BALL], atol=1e-9)
    assert fit.surface.major_radius == pytest.approx(major)
    assert fit.surface.minor_radius == pytest.approx(BALL)
    assert fit.orientation == (1 if is_pad else -1)
    assert np.isin(new[label == CRUMB], name).mean() > 0.9
    # Beside the lines where it leaves its neighbours, patches are of both.
    taken = evidence.graph.points[new == name]
    assert np.abs(truth(major)[CRUMB].signed_distance(taken)).max() < 0.5
    assert (face[new == name] == CRUMB).mean() > 0.8


def test_a_floor_without_a_round_gets_none():
    evidence, face = corner(7.0)
    label, surfaces = covered(evidence, face, truth(7.0))
    for name in ROUND:  # tilted planes, where a chamfer goes along the floor
        surfaces[name] = Plane(np.zeros(3), np.eye(3)[name - 1])
    assert not found(evidence, label, surfaces)[1]


def test_what_is_known_takes_the_place_of_what_was_fitted_a_little_better():
    evidence, face = corner(7.0)
    surfaces = truth(7.0)
    surfaces[WALL] = Cylinder(np.zeros(3), -np.eye(3)[2], 7.0 + BALL + 0.05)
    _, turns = found(evidence, face, surfaces)
    assert [fit.surface.major_radius for fit in turns.values()] == pytest.approx([7.05])


def test_a_crumb_tells_no_ball_for_its_own_place():
    evidence, face = corner(7.0)
    surfaces = truth(7.0)
    for name in ROUND:
        surfaces[name] = Plane(np.zeros(3), np.eye(3)[name - 1])
    surfaces[CRUMB] = Torus(np.array([0.4, 0.4, BALL]), np.eye(3)[2], 7.0, BALL)
    assert not found(evidence, face, surfaces)[1]


@pytest.mark.parametrize("is_explained", [True, False])
def test_points_off_the_way_of_the_ball_stay_as_they_are(is_explained):
    evidence, face = corner(7.0)
    label, surfaces = covered(evidence, face, truth(7.0))
    own = (label == CRUMB)[evidence.patch]
    moved = evidence.points - 0.6 * own[:, None] * evidence.normals
    witnesses = moved.reshape(evidence.witnesses.shape)
    evidence = type(evidence)(**{**vars(evidence), "points": moved, "witnesses": witnesses})
    if is_explained:
        surfaces[CRUMB] = Torus(np.array([0.0, 0.0, BALL]), np.eye(3)[2], 7.0, BALL + 0.6)
    new, turns = found(evidence, label, surfaces)
    assert not turns
    np.testing.assert_array_equal(new, label)
