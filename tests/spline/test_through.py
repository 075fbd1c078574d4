"""Control nets whose limit surface passes through given points."""

import numpy as np
import pytest

from crispline.spline.bezier import corner_points
from crispline.spline.creased import CreasedNet
from crispline.spline.through import passing_through

NONE = np.zeros((0, 2), dtype=np.int64)
NO_CORNERS = np.zeros(0, dtype=np.int64)


def limit_radius(net):
    return np.linalg.norm(corner_points(net).position, axis=1)


def test_a_sphere_keeps_its_radius(nets):
    vertices, quads = nets.sphere(12, 5.0)
    plain = CreasedNet(vertices, quads, NONE, NO_CORNERS)
    shrunk = 5.0 - limit_radius(plain).mean()
    assert shrunk > 0.02
    off = np.abs(limit_radius(passing_through(plain)) - 5.0)
    assert off.mean() < 0.01 * shrunk
    assert off.max() < 0.1 * shrunk  # at the eight vertices of valence 3


def test_more_rounds_come_nearer(nets):
    vertices, quads = nets.sphere(6, 5.0)
    rough = vertices * (1.0 + 0.02 * np.random.default_rng(3).normal(size=(len(vertices), 1)))
    net = CreasedNet(rough, quads, NONE, NO_CORNERS)
    misses = [
        np.abs(corner_points(passing_through(net, n)).position - rough).max() for n in (0, 2, 6, 18)
    ]
    assert np.all(np.diff(misses) < 0.0)
    # The roughest wave that a regular net can carry keeps 8/9 of its miss a round.
    assert misses[3] < misses[0] * (8.0 / 9.0) ** 18 * 2.0


def test_creases_and_corners_of_a_cube_stay_straight(nets):
    vertices, quads, side = nets.box(6)
    creases = nets.borders(quads, side)
    n_ends = np.bincount(creases.ravel(), minlength=len(vertices))
    net = CreasedNet(vertices, quads, creases, np.flatnonzero(n_ends > 2))
    through = passing_through(net)
    np.testing.assert_allclose(corner_points(through).position, vertices, atol=1e-3)
    np.testing.assert_allclose(np.abs(through.vertices).max(axis=1), 1.0, atol=1e-12)


def test_vertices_without_quads_stay(nets):
    vertices, quads = nets.sphere(4)
    extra = np.vstack([vertices, [[9.0, 9.0, 9.0]]])
    net = passing_through(CreasedNet(extra, quads, NONE, NO_CORNERS), 2)
    np.testing.assert_array_equal(net.vertices[-1], 9.0)
    assert limit_radius(net)[:-1] == pytest.approx(1.0, abs=0.05)
