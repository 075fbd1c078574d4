"""The surface of an oriented cloud by signed distance: on the points, a little beyond."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.errors import ReconstructionError
from crispline.net.signed_distance import sheet_mesh


def test_a_plane_runs_on_as_a_plane():
    points = np.random.default_rng(0).uniform(-10.0, 10.0, (400, 3)) * [1.0, 1.0, 0.0]
    normals = np.broadcast_to([0.0, 0.0, 1.0], points.shape)
    mesh = sheet_mesh(cKDTree(points), normals, np.ones(400), reach=3.0)
    np.testing.assert_allclose(mesh.vertices[:, 2], 0.0, atol=1e-5)
    extent = np.ptp(mesh.vertices, axis=0)[:2]
    assert (extent > 22.0).all()
    assert (extent < 27.0).all()
    assert len(np.unique(mesh.pieces())) == 1


def test_a_ball_is_closed():
    normals = np.random.default_rng(1).normal(size=(3000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    radius = np.sqrt(3000 / (4.0 * np.pi))
    mesh = sheet_mesh(cKDTree(radius * normals), normals, np.ones(3000), reach=3.0)
    assert len(mesh.borders()) == 0
    height = np.linalg.norm(mesh.vertices, axis=1) - radius
    assert np.abs(height).max() < 0.3


def test_two_sheets_two_spacings_apart_stay_apart():
    flat = np.random.default_rng(2).uniform(-10.0, 10.0, (400, 3)) * [1.0, 1.0, 0.0]
    points = np.concatenate([flat, flat + np.array([0.3, 0.2, 2.0])])
    normals = np.repeat([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]], 400, axis=0)
    mesh = sheet_mesh(cKDTree(points), normals, np.ones(800), reach=2.5)
    inner = np.abs(mesh.vertices[:, :2]).max(axis=1) < 8.0
    z = mesh.vertices[inner, 2]
    assert np.minimum(np.abs(z), np.abs(z - 2.0)).max() < 0.2
    assert set(np.round(z / 2.0).astype(int).tolist()) == {0, 1}


def test_no_surface_is_refused():
    points = np.random.default_rng(3).uniform(0.0, 9.0, (100, 3))
    normals = np.zeros((100, 3))
    with pytest.raises(ReconstructionError, match="no surface could be found"):
        sheet_mesh(cKDTree(points), normals, np.ones(100), reach=2.0)
