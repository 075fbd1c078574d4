"""Vertices of a net on the surface of their region."""

import numpy as np
import pytest

from crispline.net.quads import QuadNet
from crispline.region.regionfit import RegionFit
from crispline.sharp.settle import settled
from crispline.surface import Plane


@pytest.fixture
def cube(nets):
    """A noisy net of a cube, the side of every quad, and the planes of the sides."""
    exact, quads, side = nets.box(6)
    noisy = exact + 0.03 * np.random.default_rng(5).normal(size=exact.shape)
    planes = {}
    for index in range(6):
        normal = (1.0 if index % 2 else -1.0) * np.eye(3)[index // 2]
        plane = Plane(normal, normal)
        planes[index] = RegionFit(plane, 1, np.zeros((0, 3)), np.zeros(0))
    return QuadNet(noisy, quads), side, planes, exact


def test_inner_vertices_lie_on_the_sides_and_the_others_stay(cube):
    net, side, planes, exact = cube
    moved = settled(net, side, planes, 0.5).vertices
    is_inner = (np.abs(exact) == 1.0).sum(axis=1) == 1
    np.testing.assert_allclose(np.abs(moved[is_inner]).max(axis=1), 1.0, atol=1e-12)
    np.testing.assert_array_equal(moved[~is_inner], net.vertices[~is_inner])
    # Along their side they stay where they were.
    off = np.sort(np.abs(moved - net.vertices), axis=1)[is_inner]
    np.testing.assert_allclose(off[:, :2], 0.0, atol=1e-12)


def test_vertices_that_a_surface_does_not_explain_stay(cube):
    net, side, planes, exact = cube
    away = Plane(np.array([0.0, 0.0, 1.4]), np.array([0.0, 0.0, 1.0]))
    planes = planes | {5: RegionFit(away, 1, np.zeros((0, 3)), np.zeros(0))}
    moved = settled(net, side, planes, 0.2).vertices
    on_top = exact[:, 2] == 1.0
    np.testing.assert_array_equal(moved[on_top], net.vertices[on_top])
    assert (moved[~on_top] != net.vertices[~on_top]).any()
