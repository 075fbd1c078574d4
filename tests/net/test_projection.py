"""RIMLS projection: a slow twin, known surfaces, edges."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.net import projection
from crispline.net.projection import project_to_cloud

SUPPORT = 4.0


def naive_step(vertex, points, normals):
    """One robust implicit moving least squares step, written out (Oztireli et al. 2009)."""
    value, gradient = 0.0, np.zeros(3)
    for iteration in range(4):
        total_w = 0.0
        total_value = 0.0
        total_slope, total_slope_value = np.zeros(3), np.zeros(3)
        total_normal = np.zeros(3)
        for point, normal in zip(points, normals, strict=True):
            offset = vertex - point
            falloff = 1.0 - offset @ offset / SUPPORT**2
            if falloff <= 0.0:
                continue
            height = offset @ normal
            robust = 1.0
            if iteration > 0:
                robust = np.exp(-(((height - value) / (0.5 * SUPPORT)) ** 2))
                robust *= np.exp(-((np.linalg.norm(normal - gradient) / 0.7) ** 2))
            w = robust * falloff**4
            slope = robust * 2.0 * offset * (-4.0 * falloff**3 / SUPPORT**2)
            total_w += w
            total_value += w * height
            total_slope += slope
            total_slope_value += slope * height
            total_normal += w * normal
        value = total_value / total_w
        gradient = (total_slope_value - value * total_slope + total_normal) / total_w
    return vertex - value * gradient / (gradient @ gradient)


def rough_sheet(n=900, sigma=0.1, seed=0):
    rng = np.random.default_rng(seed)
    side = np.sqrt(n)
    points = np.column_stack([rng.uniform(0, side, (n, 2)), sigma * rng.normal(size=n)])
    normals = np.column_stack([0.1 * rng.normal(size=(n, 2)), np.ones(n)])
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)


def test_one_step_equals_the_slow_twin(monkeypatch):
    points, normals = rough_sheet()
    rng = np.random.default_rng(1)
    vertices = np.column_stack([rng.uniform(8, 22, (12, 2)), rng.uniform(-1, 1, 12)])
    tree = cKDTree(points)
    monkeypatch.setattr(projection, "_N_NEIGHBOURS", 60)  # all points in the support
    moved = project_to_cloud(vertices, tree, normals, 1)
    for vertex, result in zip(vertices, moved, strict=True):
        near = tree.query_ball_point(vertex, SUPPORT)
        np.testing.assert_allclose(
            result, naive_step(vertex, points[near], normals[near]), atol=2e-5
        )


@pytest.mark.parametrize("height", [-1.0, 0.5, 1.5])
def test_reaches_a_plane_exactly(height):
    i, j = np.mgrid[:20, :20]
    points = np.column_stack([i.ravel(), j.ravel(), np.zeros(400)]).astype(float)
    vertices = np.array([[9.3, 9.8, height], [7.1, 11.2, height]])
    moved = project_to_cloud(vertices, cKDTree(points), np.tile([0.0, 0.0, 1.0], (400, 1)), 4)
    np.testing.assert_allclose(moved[:, 2], 0.0, atol=1e-6)
    np.testing.assert_allclose(moved[:, :2], vertices[:, :2], atol=1e-6)


def test_averages_noise_away():
    points, normals = rough_sheet(2500, sigma=0.2)
    vertices = points[(np.abs(points[:, :2] - 25.0) < 18.0).all(axis=1)]
    moved = project_to_cloud(vertices, cKDTree(points), normals, 4)
    assert moved[:, 2].std() < 0.4 * 0.2


def test_keeps_a_right_angle_better_than_a_mean_would():
    """Points of two walls: vertices near the edge go to their own wall."""
    i, j = np.mgrid[:21, :11]
    wall = np.column_stack([i.ravel(), j.ravel() + 0.5, np.zeros(231)]).astype(float)
    points = np.concatenate([wall, wall[:, [0, 2, 1]]])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, -1.0, 0.0]], 231, axis=0)
    vertices = np.array([[10.2, 1.2, 0.3], [10.2, 0.3, 1.2]])
    moved = project_to_cloud(vertices, cKDTree(points), normals, 4)
    assert abs(moved[0, 2]) < 0.1
    assert abs(moved[1, 1]) < 0.1


def test_vertices_far_from_the_cloud_stay():
    points, normals = rough_sheet()
    vertices = np.array([[10.0, 10.0, 7.0]])
    np.testing.assert_array_equal(project_to_cloud(vertices, cKDTree(points), normals, 3), vertices)


def test_far_vertices_do_not_change_what_becomes_of_the_near_ones():
    points, normals = rough_sheet()
    near, far = points[:40] + 0.5 * normals[:40], points[40:80] + np.array([0.0, 0.0, 30.0])
    mixed = np.stack([far, near], axis=1).reshape(-1, 3)
    moved = project_to_cloud(mixed, cKDTree(points), normals, 2)
    np.testing.assert_array_equal(moved[::2], far)
    np.testing.assert_array_equal(moved[1::2], project_to_cloud(near, cKDTree(points), normals, 2))


def test_chunks_do_not_change_the_result(monkeypatch):
    points, normals = rough_sheet()
    vertices = points + 0.3 * normals
    whole = project_to_cloud(vertices, cKDTree(points), normals, 2)
    monkeypatch.setattr(projection, "_CHUNK", 97)
    np.testing.assert_array_equal(project_to_cloud(vertices, cKDTree(points), normals, 2), whole)
