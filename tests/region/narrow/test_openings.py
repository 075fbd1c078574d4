"""Windows through a thin plate whose walls came out as one region, or leaning."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from turned import SIGMA
from witnessed import witnessed

from crispline.options import RegionOptions
from crispline.region.fitting import fitted_region, held_fit
from crispline.region.narrow.openings import with_openings
from crispline.surface import Cylinder, Plane

UPPER, LOWER, WALL = 0, 1, 2
THICK = 3.0
WIDTH, HEIGHT = 14, 9
UP = np.array([0.0, 0.0, 1.0])
OPTIONS = RegionOptions()


def window(lean=0.0):
    """A plate about a window, patches a unit apart; which wall each patch is on, or -1.

    The walls lean by an angle, so that the window is wider above.
    """
    sides = [
        (np.array([0.5 * WIDTH, 0.0]), np.array([1.0, 0.0]), HEIGHT),
        (np.array([0.0, 0.5 * HEIGHT]), np.array([0.0, 1.0]), WIDTH),
        (np.array([-0.5 * WIDTH, 0.0]), np.array([-1.0, 0.0]), HEIGHT),
        (np.array([0.0, -0.5 * HEIGHT]), np.array([0.0, -1.0]), WIDTH),
    ]
    points, normals, wall = [], [], []
    for number, (middle, out, length) in enumerate(sides):
        along = np.array([-out[1], out[0]])
        for k in range(length):
            place = middle + (k + 0.5 - 0.5 * length) * along
            for away in (3.5, 2.5, 1.5, 0.5):
                points.append([*(place + away * out), 0.5 * THICK])
                normals.append(UP)
                wall.append(-1)
            for z in (1.0, 0.0, -1.0):
                points.append([*(place + z * np.tan(lean) * out), z])
                normals.append([*(-np.cos(lean) * out), np.sin(lean)])
                wall.append(number)
            for away in (0.5, 1.5, 2.5, 3.5):
                points.append([*(place + away * out), -0.5 * THICK])
                normals.append(-UP)
                wall.append(-1)
    n_across = 11
    number = np.arange(len(points)).reshape(-1, n_across)
    around = np.column_stack([number.ravel(), np.roll(number, -1, axis=0).ravel()])
    across = np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()])
    pairs = np.concatenate([around, across])
    points, normals = np.array(points), np.array(normals, dtype=float)
    return witnessed(points, normals, pairs, SIGMA), np.array(wall)


def labelled(evidence, wall, names):
    """Sides of the plate, and the walls by some names."""
    label = np.where(evidence.graph.points[:, 2] > 0.0, UPPER, LOWER)
    return np.where(wall >= 0, np.array(names)[wall], label)


def fits_of(evidence, label):
    sides = {UPPER: Plane(0.5 * THICK * UP, UP), LOWER: Plane(-0.5 * THICK * UP, -UP)}
    return {name: held_fit(s, np.flatnonzero(label == name), evidence) for name, s in sides.items()}


def unexplained(evidence, label, name):
    own = label[evidence.patch] == name
    points, normals = evidence.points[own], evidence.normals[own]
    middle = Plane(points.mean(axis=0), np.array([1.0, 0.0, 0.0]))
    return fitted_region(middle, points, normals, False)


def test_a_wall_is_cut_where_it_turns():
    evidence, wall = window()
    label = labelled(evidence, wall, [WALL] * 4)
    fits = fits_of(evidence, label) | {WALL: unexplained(evidence, label, WALL)}
    new, found = with_openings(label, fits, evidence, OPTIONS)
    assert len(found) == 4
    for number, place in enumerate([0.5 * WIDTH, 0.5 * HEIGHT] * 2):
        (name,) = np.unique(new[wall == number])
        surface = found[name].surface
        assert abs(surface.normal @ UP) < 1e-12
        assert abs(surface.origin @ surface.normal) == pytest.approx(place, abs=0.1)
    np.testing.assert_array_equal(new[wall < 0], label[wall < 0])


def test_walls_that_the_two_sides_share_come_back():
    evidence, wall = window()
    label = np.where(evidence.graph.points[:, 2] > 0.0, UPPER, LOWER)
    new, found = with_openings(label, fits_of(evidence, label), evidence, OPTIONS)
    assert len(found) == 4
    for number in range(4):
        assert len(np.unique(new[wall == number])) == 1
    np.testing.assert_array_equal(new[wall < 0], label[wall < 0])


def test_the_sides_of_a_plate_stay_where_no_wall_is_told():
    # Seen from the patches nothing is between the two, as at a tear of the net.
    evidence, _ = window()
    flat = evidence.graph.points[:, 2] > 0.0
    label = np.where(flat, UPPER, LOWER)
    sides = label == UPPER
    normals = np.where(sides[:, None], UP, -UP)
    bare = replace(evidence, graph=replace(evidence.graph, normals=normals))
    new, found = with_openings(label, fits_of(bare, label), bare, OPTIONS)
    assert not found
    np.testing.assert_array_equal(new, label)


def test_a_wall_that_noise_has_tilted_stands_upright():
    evidence, wall = window()
    label = labelled(evidence, wall, [2, 3, 4, 5])
    fits = fits_of(evidence, label)
    tilted = Rotation.from_rotvec([0.1, 0.1, 0.0]).as_matrix()
    for name, out in zip((2, 3, 4, 5), ([1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0]), strict=True):
        place = np.array(out) * [0.5 * WIDTH, 0.5 * HEIGHT, 0.0]
        plane = Plane(place, tilted @ -np.array(out, dtype=float))
        fits[name] = held_fit(plane, np.flatnonzero(label == name), evidence)
    new, found = with_openings(label, fits, evidence, OPTIONS)
    np.testing.assert_array_equal(new, label)
    assert sorted(found) == [2, 3, 4, 5]
    assert all(abs(fit.surface.normal @ UP) < 1e-12 for fit in found.values())


def test_a_wall_that_leans_stays_as_it_is():
    lean = 0.35
    evidence, wall = window(lean)
    label = labelled(evidence, wall, [2, 3, 4, 5])
    fits = fits_of(evidence, label)
    normal = np.array([-np.cos(lean), 0.0, np.sin(lean)])
    plane = Plane(np.array([0.5 * WIDTH, 0.0, 0.0]), normal)
    for name in (2, 3, 4, 5):
        fits[name] = unexplained(evidence, label, name)
    fits[2] = held_fit(plane, np.flatnonzero(label == 2), evidence)
    assert 2 not in with_openings(label, fits, evidence, OPTIONS)[1]


def test_a_round_wall_is_not_cut():
    evidence, wall = window()
    label = labelled(evidence, wall, [WALL] * 4)
    fits = fits_of(evidence, label)
    around = Cylinder(np.zeros(3), UP, 5.0)
    fits[WALL] = held_fit(around, np.flatnonzero(label == WALL), evidence)
    new, found = with_openings(label, fits, evidence, OPTIONS)
    assert not found
    np.testing.assert_array_equal(new, label)
