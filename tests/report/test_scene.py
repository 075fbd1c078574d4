"""Triangles of the model for the page."""

import numpy as np
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder

from crispline.report import scene

DRUM = BRepPrimAPI_MakeCylinder(5.0, 10.0).Shape()


def test_triangles_carry_the_rows_of_their_faces():
    mesh = scene.model_mesh(DRUM, 1.0, np.array([7, 5, -1]))
    assert set(mesh.faces.tolist()) == {7, 5, -1}
    assert np.linalg.norm(mesh.vertices[:, :2], axis=1).max() < 5.0 + 1e-9


def test_models_of_many_faces_get_fewer_triangles_each(monkeypatch):
    fine = scene.model_mesh(DRUM, 1.0, np.arange(3))
    monkeypatch.setattr(scene, "_MANY_FACES", 2)
    coarse = scene.model_mesh(DRUM, 1.0, np.arange(3))
    assert len(coarse.triangles) < 0.6 * len(fine.triangles)
    np.testing.assert_array_equal(np.unique(coarse.faces), [0, 1, 2])
