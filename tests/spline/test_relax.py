"""Neighbours of moved vertices slide along the surface."""

import numpy as np

from crispline.spline.creased import CreasedNet
from crispline.spline.relax import relaxed

NONE = np.zeros((0, 2), dtype=np.int64)
NO_CORNERS = np.zeros(0, dtype=np.int64)
N = 9


def squeezed(nets):
    """A plane grid whose fourth row was pushed towards the fifth."""
    vertices, quads = nets.plane(N, N)
    row = np.arange(N * N).reshape(N, N)[3]
    vertices = vertices + 0.0
    vertices[row, 0] += 0.7
    return vertices, quads, row


def areas(vertices, quads):
    corner = vertices[quads]
    return 0.5 * np.linalg.norm(
        np.cross(corner[:, 2] - corner[:, 0], corner[:, 3] - corner[:, 1]), axis=1
    )


def test_quads_become_even_and_stay_in_the_plane(nets):
    vertices, quads, row = squeezed(nets)
    even = relaxed(CreasedNet(vertices, quads, NONE, NO_CORNERS), row, 3).vertices
    is_inner = (quads % N > 1).all(axis=1) & (quads % N < N - 2).all(axis=1)
    before, after = areas(vertices, quads)[is_inner], areas(even, quads)[is_inner]
    assert after.max() / after.min() < 0.7 * before.max() / before.min()
    np.testing.assert_array_equal(even[:, 2], 0.0)


def test_fixed_open_and_far_vertices_stay(nets):
    vertices, quads, row = squeezed(nets)
    even = relaxed(CreasedNet(vertices, quads, NONE, NO_CORNERS), row, 2).vertices
    moved = np.flatnonzero((even != vertices).any(axis=1)) // N
    assert set(moved) == {1, 2, 4, 5}
    index = np.arange(N * N).reshape(N, N)
    stays = np.concatenate([row, index[0], index[-1], index[:, 0], index[:, -1]])
    np.testing.assert_array_equal(even[stays], vertices[stays])


def test_creases_and_corners_stay(nets):
    vertices, quads, row = squeezed(nets)
    index = np.arange(N * N).reshape(N, N)
    creases = np.stack([index[4, :-1], index[4, 1:]], axis=1)
    corners = index[2, 4:5]
    even = relaxed(CreasedNet(vertices, quads, creases, corners), row, 3).vertices
    stays = np.concatenate([index[4], corners])
    np.testing.assert_array_equal(even[stays], vertices[stays])
    assert (even[index[2, 3]] != vertices[index[2, 3]]).any()


def test_a_sphere_keeps_its_shape_to_second_order(nets):
    vertices, quads = nets.sphere(12, 10.0)
    even = relaxed(CreasedNet(vertices, quads, NONE, NO_CORNERS), np.array([0]), 4).vertices
    moved = np.linalg.norm(even - vertices, axis=1)
    off = np.abs(np.linalg.norm(even, axis=1) - 10.0)
    assert moved.max() > 0.0
    assert off.max() < 2.0 * moved.max() ** 2 / 20.0
