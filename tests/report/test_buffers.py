"""What the page carries is what was there."""

import base64
from dataclasses import replace

import numpy as np
import pytest

from crispline.report import buffers
from crispline.report.buffers import NO_FACE, encoded
from crispline.report.scene import scene_of

TYPES = {"Float32Array": "<f4", "Uint8Array": "u1", "Uint16Array": "<u2", "Uint32Array": "<u4"}


@pytest.fixture(scope="module")
def scene(cube, points):
    return scene_of(cube, points, cube.deviations(points))


def array(stored, name):
    one = stored["arrays"][name]
    return np.frombuffer(base64.b64decode(one["base64"]), TYPES[one["type"]])


def places(stored, name):
    steps = array(stored, name).reshape(-1, 3).astype(float)
    return np.array(stored["origin"]) + steps / 65535 * stored["extent"]


def test_positions_and_deviations_come_back(scene, points):
    stored = encoded(scene)
    step = stored["extent"] / 65535
    np.testing.assert_allclose(places(stored, "points"), points, atol=0.51 * step)
    np.testing.assert_allclose(places(stored, "plain"), scene.patches.plain, atol=0.51 * step)
    found = array(stored, "deviations")
    np.testing.assert_allclose(found, np.where(points[:, 2] > 10.1, 0.15, -0.15), atol=1e-6)
    np.testing.assert_array_equal(array(stored, "point_faces"), np.repeat(np.arange(6), 400))
    assert stored["n_outside"] == stored["n_skipped"] == 0


def test_indices_of_patches_come_back(scene):
    def whole(values):
        return values.reshape(-1, 3).astype(np.int64) @ [1, 256, 65536]

    quads = scene.patches.quads
    np.testing.assert_array_equal(whole(array(encoded(scene), "quads")), quads.ravel())
    large = np.array([[0, 255, 256, 65535], [65536, 70_000, 2**24 - 2, 2**24 - 1]])
    np.testing.assert_array_equal(whole(buffers._three_bytes(large)), large.ravel())


def test_the_mesh_keeps_its_area_face_by_face(scene):
    stored = encoded(scene)
    vertices, triangles = places(stored, "vertices"), array(stored, "triangles").reshape(-1, 3)
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    rows = array(stored, "vertex_faces")[triangles]
    assert (rows == rows[:, :1]).all()
    np.testing.assert_allclose(np.bincount(rows[:, 0], area), np.full(6, 400.0), rtol=1e-4)


def test_points_far_away_are_counted_and_left_out(scene):
    far = np.array([[500.0, 0.0, 0.0], [0.0, 0.0, -500.0]])
    cloud = scene.cloud
    more = replace(
        scene,
        cloud=replace(
            cloud,
            points=np.concatenate([far, cloud.points]),
            deviations=np.concatenate([[490.0, 490.0], cloud.deviations]),
            faces=np.concatenate([[-1, -1], cloud.faces]),
        ),
    )
    stored, plain = encoded(more), encoded(scene)
    assert stored["n_outside"] == 2
    assert stored["arrays"] == plain["arrays"]


def test_large_clouds_are_thinned_evenly(scene, monkeypatch):
    monkeypatch.setattr(buffers, "MAX_POINTS", 1000)
    stored = encoded(scene)
    assert stored["n_skipped"] == 1600
    np.testing.assert_array_equal(array(stored, "points"), array_of_every(scene, 3))


def array_of_every(scene, k):
    stored = encoded(replace(scene, cloud=replace(scene.cloud, points=scene.cloud.points[::k],
        deviations=scene.cloud.deviations[::k], faces=scene.cloud.faces[::k])))  # fmt: skip
    return array(stored, "points")


def test_unknown_deviations_and_faces_are_marked(unbuilt, points):
    stored = encoded(scene_of(unbuilt, points, None))
    assert (array(stored, "deviations") > 1e29).all()
    assert (array(stored, "point_faces") == NO_FACE).all()
