"""Normals by principal components, and their orientation on closed shapes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from crispline.cloud.normals import orient_by_spanning_tree, principal_normals


def neighbours_of(points, k=24):
    return cKDTree(points).query(points, k=k)[1]


def sphere(n=1200, rng=None):
    normals = (rng or np.random.default_rng(0)).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return np.sqrt(n / (4 * np.pi)) * normals, normals


def box(rng, *size):
    """About one point per unit of area."""
    size = np.array(size)
    areas = np.array([size[1] * size[2], size[0] * size[2], size[0] * size[1]])
    n = round(2 * areas.sum())
    axis, side = rng.choice(3, n, p=areas / areas.sum()), rng.choice([-1.0, 1.0], n)
    points, normals = rng.uniform(-0.5, 0.5, (n, 3)) * size, np.zeros((n, 3))
    points[np.arange(n), axis] = side * size[axis] / 2.0
    normals[np.arange(n), axis] = side
    return points, normals


def torus(rng, major=12.0, minor=5.0):
    n = round(4 * np.pi**2 * major * minor)
    u, v, level = rng.random((3, 3 * n)) * np.array([[2 * np.pi], [2 * np.pi], [major + minor]])
    keep = np.flatnonzero(level < major + minor * np.cos(v))[:n]
    u, v = u[keep], v[keep]
    normals = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=1)
    return major * np.stack([np.cos(u), np.sin(u), 0.0 * u], axis=1) + minor * normals, normals


SHAPES = {
    "sphere": lambda rng: sphere(1200, rng),
    "box": lambda rng: box(rng, 20.0, 16.0, 12.0),
    "thin plate": lambda rng: box(rng, 30.0, 25.0, 3.0),
    "torus": torus,
}


def noisy(shape, sigma, seed=0):
    rng = np.random.default_rng(seed)
    points, normals = SHAPES[shape](rng)
    return points + sigma * rng.normal(size=(len(points), 1)) * normals, normals


def test_normal_is_the_least_principal_axis():
    points, _ = noisy("box", 0.1)
    neighbours = neighbours_of(points)
    normals = principal_normals(points, neighbours, 18)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    for i in range(0, len(points), 97):
        local = points[neighbours[i, :18]]
        _, _, axes = np.linalg.svd(local - local.mean(axis=0))
        assert abs(normals[i] @ axes[2]) == pytest.approx(1.0)


def test_normals_of_a_sphere_within_a_few_degrees():
    points, truth = noisy("sphere", 0.05)
    normals = principal_normals(points, neighbours_of(points), 18)
    off = np.degrees(np.arccos(np.clip(np.abs(np.einsum("ij,ij->i", normals, truth)), 0, 1)))
    assert np.quantile(off, 0.95) < 6.0


@pytest.mark.parametrize("sigma", [0.0, 0.15])
@pytest.mark.parametrize("shape", SHAPES)
def test_all_outward(shape, sigma):
    points, truth = noisy(shape, sigma)
    neighbours = neighbours_of(points)
    normals = principal_normals(points, neighbours, 18)
    oriented = orient_by_spanning_tree(points, normals, neighbours, 2.0, 0.25)
    np.testing.assert_allclose(np.abs(np.einsum("ij,ij->i", oriented, normals)), 1.0)
    agreement = np.einsum("ij,ij->i", oriented, truth)
    # On an edge the normal bisects two faces, and a noisy one may lie along a face.
    clear = np.abs(agreement) > 0.5
    assert clear.mean() > 0.85
    assert (agreement[clear] > 0.0).all()


@given(seed=st.integers(0, 10_000))
@settings(max_examples=10)
def test_signs_of_the_start_do_not_matter(seed):
    points, truth = sphere(500)
    neighbours = neighbours_of(points)
    flipped = np.random.default_rng(seed).choice([-1.0, 1.0], (500, 1)) * truth
    np.testing.assert_array_equal(
        orient_by_spanning_tree(points, flipped, neighbours, 2.0, 0.25), truth
    )


def test_every_piece_is_turned_outward_by_itself():
    points, truth = sphere(500)
    places = np.array([[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, -80.0, 0.0]])
    points = (places[:, None] + points).reshape(-1, 3)
    truth = np.tile(truth, (3, 1))
    signs = np.repeat([1.0, -1.0, -1.0], 500)[:, None]
    oriented = orient_by_spanning_tree(points, signs * truth, neighbours_of(points), 2.0, 0.25)
    np.testing.assert_array_equal(oriented, truth)


def test_a_bent_strip_needs_the_bending_term():
    """Neighbours on a tight arc: Hoppe's rule alone takes a turn over 90 degrees for a flip."""
    angle = np.radians(np.arange(0, 360, 100.0))
    ring = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1)
    points = (ring[:, None] / 1.5 + np.arange(12.0)[:, None] * [0.0, 0.0, 1.0]).reshape(-1, 3)
    truth = np.repeat(ring, 12, axis=0)
    neighbours = neighbours_of(points, 11)
    with_bending = orient_by_spanning_tree(points, truth, neighbours, 2.0, 0.0)
    np.testing.assert_array_equal(with_bending, truth)
