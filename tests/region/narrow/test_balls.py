"""Corners where three rounds of one radius meet."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from witnessed import witnessed

from crispline.options import RegionOptions
from crispline.region.fitting import held_fit
from crispline.region.narrow.balls import with_balls
from crispline.surface import Cone, Cylinder, Plane, Sphere, unit

RADIUS, LENGTH, SIGMA = 9.0, 25.0, 0.15
OPTIONS = RegionOptions()
CRUMB = 3
BALL = Sphere(np.zeros(3), RADIUS)


def corner():
    """Patches about a unit apart on an eighth of a ball and on the rounds that end at it."""
    turns = (np.arange(14) + 0.5) * (0.5 * np.pi / 14)
    turn, along = (grid.ravel() for grid in np.meshgrid(turns, -np.arange(LENGTH) - 0.5))
    normals, points, face = [], [], []
    for k in range(3):
        across = np.cos(turn)[:, None] * np.eye(3)[k - 2] + np.sin(turn)[:, None] * np.eye(3)[k - 1]
        normals.append(across)
        points.append(RADIUS * across + along[:, None] * np.eye(3)[k])
        face += [k] * len(turn)
    number = np.arange(8 * 170) + 0.5  # Fibonacci's lattice on the whole sphere
    height = 1.0 - 2.0 * number / len(number)
    angle = number * np.pi * (1.0 + np.sqrt(5.0))
    level = np.sqrt(1.0 - height**2)
    sphere = np.column_stack([level * np.cos(angle), level * np.sin(angle), height])
    sphere = sphere[(sphere > 0.02).all(axis=1)]
    normals, points = np.concatenate([*normals, sphere]), np.concatenate([*points, RADIUS * sphere])
    pairs = cKDTree(points).query_pairs(1.6, output_type="ndarray")
    order = np.lexsort(pairs.T)
    return (
        witnessed(points, normals, pairs[order], SIGMA),
        np.array(face + [CRUMB] * len(sphere)),
    )


def rounds(radii=(RADIUS, RADIUS, RADIUS), shift=0.0):
    """Cylinders about the three axes; the last one's may be beside the corner."""
    shifts = np.zeros((3, 3))
    shifts[2, 0] = shift
    return {k: Cylinder(shifts[k], (-1.0) ** k * np.eye(3)[k], radii[k]) for k in range(3)}


def covered(evidence, face):
    """The rounds have what of the corner they nearly explain; the rest is a cone."""
    points = evidence.graph.points
    label = face.copy()
    near = [np.abs(surface.signed_distance(points)) < 0.3 for surface in rounds().values()]
    for k in range(3):
        label[(face == CRUMB) & near[k]] = k
    apex = (RADIUS + 1.0) / np.sqrt(3.0) * np.ones(3)
    cone = Cone(apex, unit(-np.ones(3)), np.radians(62.0))
    return label, cone


def found(evidence, label, surfaces):
    fits = {
        name: held_fit(surface, np.flatnonzero(label == name), evidence)
        for name, surface in surfaces.items()
    }
    return with_balls(label, fits, evidence, OPTIONS)


def test_the_ball_takes_the_place_of_a_crumb_and_of_what_the_rounds_have_covered():
    evidence, face = corner()
    label, cone = covered(evidence, face)
    assert (label == CRUMB).sum() < 0.7 * (face == CRUMB).sum()
    new, balls = found(evidence, label, {**rounds(), CRUMB: cone})
    ball = balls[CRUMB].surface
    assert isinstance(ball, Sphere)
    np.testing.assert_allclose(ball.centre, 0.0, atol=1e-12)
    assert ball.radius == pytest.approx(RADIUS)
    assert balls[CRUMB].orientation == 1
    np.testing.assert_array_equal(new, face)


@pytest.mark.parametrize(
    "others", [rounds(shift=1.2), rounds(radii=(9.0, 9.0, 9.9))], ids=["aside", "wider"]
)
def test_rounds_of_different_balls_have_no_corner_ball(others):
    evidence, face = corner()
    label, cone = covered(evidence, face)
    new, balls = found(evidence, label, {**others, CRUMB: cone})
    assert not balls
    np.testing.assert_array_equal(new, label)


def test_a_corner_that_is_cut_off_stays_flat():
    evidence, face = corner()
    normal = unit(np.ones(3))
    cut = Plane((RADIUS - 1.5) * normal, normal)
    flat = evidence.points + 0.0
    own = (face == CRUMB)[evidence.patch]
    flat[own] -= np.outer(cut.signed_distance(flat[own]), normal)
    evidence = type(evidence)(**{**vars(evidence), "points": flat})
    assert not found(evidence, face, {**rounds(), CRUMB: cut})[1]
