"""A projection never leaves a mesh folded or torn, and is kept where it does neither."""

import numpy as np
import pytest

from crispline.net.mesh import TriangleMesh
from crispline.net.restrain import restrained


def plate(n=12):
    """Triangles over a square of ``n`` by ``n`` cells, looking up."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0), indexing="ij")
    a = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = [[a, a + n + 1, a + n + 2], [a, a + n + 2, a + 1]]
    vertices = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    return TriangleMesh(vertices, np.concatenate([np.stack(t, axis=1) for t in triangles]))


def normals(mesh):
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return np.cross(b - a, c - a)


def test_a_move_without_folds_is_kept_to_the_last_digit():
    mesh = plate()
    moved = mesh.vertices + np.random.default_rng(0).normal(0.0, 0.1, mesh.vertices.shape)
    np.testing.assert_array_equal(restrained(mesh, moved).vertices, moved)


@pytest.mark.parametrize("step", [(2.2, 0.0, 0.0), (0.0, 0.0, 3.0)], ids=["folded", "torn"])
def test_what_is_folded_or_torn_goes_back_and_nothing_else(step):
    mesh = plate()
    lift = np.array([0.0, 0.0, 0.3])
    moved = mesh.vertices + lift
    middle = np.argmin(np.linalg.norm(mesh.vertices - [6.0, 6.0, 0.0], axis=1))
    moved[middle] += step
    found = restrained(mesh, moved)
    up = normals(found)[:, 2]
    assert up.min() > 0.0
    sides = found.vertices[found.triangles] - found.vertices[np.roll(found.triangles, -1, axis=1)]
    assert np.linalg.norm(sides, axis=2).max() < 1.6
    assert (found.vertices[middle] == mesh.vertices[middle]).all()
    distance = np.linalg.norm(mesh.vertices - mesh.vertices[middle], axis=1)
    np.testing.assert_array_equal(found.vertices[distance > 6.0], moved[distance > 6.0])


def test_scale_makes_no_difference():
    mesh = plate()
    moved = mesh.vertices.copy()
    moved[84] += [2.2, 0.0, 0.0]
    once = restrained(mesh, moved).vertices
    large = restrained(TriangleMesh(1000.0 * mesh.vertices, mesh.triangles), 1000.0 * moved)
    np.testing.assert_allclose(large.vertices, 1000.0 * once)
