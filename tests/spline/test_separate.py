"""Sheets that touch in a vertex become surfaces of their own."""

import creased_models as models
import numpy as np
import pytest

from crispline.errors import InputError
from crispline.spline.bezier import bezier_patches
from crispline.spline.creased import CreasedNet
from crispline.spline.separate import separated


def two_squares_at_a_vertex(nets):
    """Two flat grids of 3 x 3 vertices; vertex 8 of the first is the first of the second."""
    vertices, quads = nets.plane(3, 3)
    other = quads + 8
    shift = np.array([2.0, 2.0, 0.0])
    return np.vstack([vertices, vertices[1:] + shift]), np.vstack([quads, other])


def test_each_fan_gets_its_own_vertex(nets):
    vertices, quads = two_squares_at_a_vertex(nets)
    creases = np.array([[8, 11], [4, 5]])
    net = CreasedNet(vertices, quads, creases, np.array([0, 8]))
    with pytest.raises(InputError, match="touch in one vertex"):
        bezier_patches(net)
    apart = separated(net)
    assert len(apart.vertices) == 18
    np.testing.assert_array_equal(apart.vertices[17], vertices[8])
    np.testing.assert_array_equal(apart.vertices[apart.quads], vertices[quads])
    np.testing.assert_array_equal(apart.quads[:4], quads[:4])
    assert sorted(map(tuple, apart.creases.tolist())) == [(4, 5), (11, 17)]
    np.testing.assert_array_equal(np.sort(apart.corners), [0, 8, 17])
    assert np.isfinite(bezier_patches(apart)).all()


def test_a_surface_comes_back_as_it_is(nets):
    for net in (models.sharp_box(nets, 2), models.open_grid(nets, 4, 3, seed=0)):
        assert separated(net) is net
