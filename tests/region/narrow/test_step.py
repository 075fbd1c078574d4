"""The walls of low steps, round and straight, whose place is known exactly."""

import numpy as np
import pytest
from turned import turned

from crispline.options import RegionOptions
from crispline.region.narrow.step import with_step_walls
from crispline.surface import Cylinder, Plane, Sphere

UPPER, WALL, LOWER, CRUMB = 0, 1, 2, 3
EDGE = 12.0
OPTIONS = RegionOptions()
UP = np.array([0.0, 0.0, 1.0])


def step(height, is_straight=False):
    """A pad on a plane; the wall is lost: its upper half is the pad's, the lower the plane's."""
    corners = [(2.5, height), (EDGE, height), (EDGE, 0.0), (17.5, 0.0)]
    part = turned(corners, 60, is_straight)
    above = part.evidence.graph.points[:, 2] > 0.5 * height
    label = np.where(part.face == WALL, np.where(above, UPPER, LOWER), part.face)
    return part, label


def planes(height, tilt=0.0):
    leaning = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    return {UPPER: Plane(height * UP, leaning), LOWER: Plane(np.zeros(3), UP)}


def touching(label, graph, pair):
    return (np.sort(label[graph.pairs], axis=1) == pair).all(axis=1)


@pytest.mark.parametrize("height", [0.9, 2.0, 3.0])
def test_a_round_step_gets_its_cylinder(height):
    part, label = step(height)
    new, walls = with_step_walls(label, part.fits(planes(height), label), part.evidence, OPTIONS)
    ((name, wall),) = walls.items()
    assert isinstance(wall.surface, Cylinder)
    assert abs(wall.surface.axis @ UP) == 1.0
    assert wall.surface.radius == pytest.approx(EDGE, abs=0.5)
    assert np.hypot(*wall.surface.origin[:2]) < 0.1
    assert wall.orientation == 1
    assert not touching(new, part.evidence.graph, (UPPER, LOWER)).any()
    assert (new[part.face == WALL] == name).mean() > 0.9
    assert (new[np.abs(np.hypot(*part.evidence.graph.points[:, :2].T) - EDGE) > 2.0] < name).all()


def test_a_straight_step_gets_its_plane():
    part, label = step(2.0, is_straight=True)
    new, walls = with_step_walls(label, part.fits(planes(2.0), label), part.evidence, OPTIONS)
    ((name, wall),) = walls.items()
    assert isinstance(wall.surface, Plane)
    assert abs(wall.surface.normal @ UP) < 1e-12
    assert np.abs(wall.surface.signed_distance(np.array([[EDGE, 30.0, 1.0]]))) < 0.3
    assert not touching(new, part.evidence.graph, (UPPER, LOWER)).any()
    assert (new == name).sum() >= (part.face == WALL).sum()


def test_a_pad_with_a_domed_top_gets_its_cylinder_too():
    part, label = step(1.5)
    dome = Sphere(np.array([0.0, 0.0, 1.5 - 80.0]), np.hypot(80.0, EDGE))
    lies_low = Plane(np.zeros(3), UP)
    fits = part.fits({UPPER: dome, LOWER: lies_low}, label)
    new, walls = with_step_walls(label, fits, part.evidence, OPTIONS)
    ((_, wall),) = walls.items()
    assert isinstance(wall.surface, Cylinder)
    assert wall.surface.radius == pytest.approx(EDGE, abs=0.5)
    assert not touching(new, part.evidence.graph, (UPPER, LOWER)).any()


def test_a_dome_that_meets_the_plane_gets_none():
    part, label = step(1.5)
    dome = Sphere(np.array([0.0, 0.0, -60.0]), np.hypot(60.0, EDGE))  # through the border
    fits = part.fits({UPPER: dome, LOWER: Plane(np.zeros(3), UP)}, label)
    new, walls = with_step_walls(label, fits, part.evidence, OPTIONS)
    assert walls == {}
    np.testing.assert_array_equal(new, label)


def test_a_crumb_of_the_wall_gives_way():
    part, label = step(2.0)
    crumb = (part.face == WALL) & (part.evidence.graph.points[:, 0] > 6.0)
    label = np.where(crumb, CRUMB, label)
    lean = np.array([0.8, 0.0, 0.6])
    surfaces = {**planes(2.0), CRUMB: Plane(EDGE * np.array([1.0, 0.0, 0.0]), lean)}
    new, walls = with_step_walls(label, part.fits(surfaces, label), part.evidence, OPTIONS)
    ((name, wall),) = walls.items()
    assert isinstance(wall.surface, Cylinder)
    assert not (new == CRUMB).any()
    assert (new[part.face == WALL] == name).mean() > 0.9


def test_an_axis_beside_holds_a_short_wall():
    part, label = step(2.0)
    graph = part.evidence.graph
    is_short = np.abs(np.arctan2(graph.points[:, 1], graph.points[:, 0])) < 0.9
    boss = ~is_short & (part.face == UPPER)  # as if a boss stood on the pad
    label = np.where(boss, CRUMB, np.where(is_short, label, LOWER))
    surfaces = {**planes(2.0), CRUMB: Cylinder(np.zeros(3), UP, 5.0)}
    _, walls = with_step_walls(label, part.fits(surfaces, label), part.evidence, OPTIONS)
    ((_, wall),) = walls.items()
    assert isinstance(wall.surface, Cylinder)
    np.testing.assert_allclose(wall.surface.origin[:2], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("height", "tilt"),
    [(0.4, 0.0), (5.0, 0.0), (2.0, np.radians(6.0))],
    ids=["within noise", "high enough to be found", "not parallel"],
)
def test_no_wall_where_none_must_be(height, tilt):
    part, label = step(height)
    fits = part.fits(planes(height, tilt), label)
    new, walls = with_step_walls(label, fits, part.evidence, OPTIONS)
    assert not walls
    np.testing.assert_array_equal(new, label)
