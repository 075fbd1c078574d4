"""A plane that narrows beside the cylinder it touches is one face."""

import numpy as np
import pytest
from witnessed import witnessed

from crispline.options import RegionOptions
from crispline.region.fitting import held_fit
from crispline.region.narrow.necks import with_necks
from crispline.surface import Cylinder, Plane

SIGMA, RADIUS = 0.15, 16.0
LENGTH, WIDTH, NECK = 60, 12, 3
LEFT, RIGHT, ROUND, HOLE = range(4)
X, Y, Z = np.eye(3)


def scene(drop=0.0, seed=0):
    """A round along y that goes over into a plane at x > 0, cut to ``NECK`` rows for 12 patches.

    The round has taken the neck; beyond it the plane's second piece lies ``drop`` lower.
    """
    x, y = (g.ravel() for g in np.meshgrid(np.arange(-9.5, WIDTH), np.arange(LENGTH) + 0.5))
    in_neck = np.abs(y - LENGTH / 2) < 6.0
    low = drop * ((x > 0.0) & (y > LENGTH / 2))
    angle = np.minimum(x, 0.0) / RADIUS
    bent = x < 0.0
    points = np.column_stack(
        [np.where(bent, RADIUS * np.sin(angle), x), y, RADIUS * (np.cos(angle) - 1.0) - low]
    )
    normals = np.column_stack([np.sin(angle), 0.0 * x, np.cos(angle)])
    n_x = WIDTH + 10
    index = np.arange(len(x)).reshape(LENGTH, n_x)
    pairs = np.concatenate(
        [
            np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
            np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
        ]
    )
    evidence = witnessed(points, normals, pairs, SIGMA, seed)
    truth = np.where(bent, ROUND, np.where(y < LENGTH / 2, LEFT, RIGHT))
    truth[in_neck & (x > NECK)] = HOLE
    label = np.where(in_neck & (x < NECK), ROUND, truth)
    surfaces = {
        LEFT: Plane(np.zeros(3), Z),
        RIGHT: Plane(-drop * Z, Z),
        ROUND: Cylinder(-RADIUS * Z, Y, RADIUS),
        HOLE: Plane(WIDTH * X, X),
    }
    fits = {n: held_fit(s, np.flatnonzero(label == n), evidence) for n, s in surfaces.items()}
    return evidence, truth, label, fits


def test_the_pieces_become_one_over_the_neck():
    evidence, truth, label, fits = scene()
    new = with_necks(label, fits, evidence, RegionOptions())
    plane = np.isin(truth, [LEFT, RIGHT])
    assert len(np.unique(new[plane])) == 1
    np.testing.assert_array_equal(new[truth == ROUND], ROUND)
    np.testing.assert_array_equal(new[truth == HOLE], HOLE)


@pytest.mark.parametrize("drop", [0.25, 0.5, 1.0])
def test_pieces_at_two_heights_stay_two(drop):
    evidence, _, label, fits = scene(drop)
    np.testing.assert_array_equal(with_necks(label, fits, evidence, RegionOptions()), label)


def test_a_round_that_is_whole_between_two_planes_stays():
    evidence, truth, label, fits = scene()
    label = np.where((label == ROUND) & (truth != ROUND), HOLE, label)  # another face lies there
    np.testing.assert_array_equal(with_necks(label, fits, evidence, RegionOptions()), label)
