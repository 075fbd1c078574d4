from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from crispline.cloud.pointcloud import PointCloud
from crispline.errors import InputError

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])


def test_keeps_values_and_counts_what_it_drops():
    points = CUBE.astype(np.float32)
    points[2, 1], points[5, 0] = np.nan, -np.inf
    cloud = PointCloud.from_arrays(points)
    assert cloud.n_dropped == 2
    assert cloud.points.dtype == np.float64
    np.testing.assert_array_equal(cloud.points, np.delete(CUBE, [2, 5], axis=0))


def test_normals_become_unit_and_follow_the_dropped_rows():
    points = CUBE.astype(float)
    points[0, 0] = np.nan
    normals = np.arange(24.0).reshape(8, 3) + 1.0
    cloud = PointCloud.from_arrays(points, normals)
    assert cloud.normals is not None
    np.testing.assert_allclose(
        cloud.normals, normals[1:] / np.linalg.norm(normals[1:], axis=1, keepdims=True)
    )


@pytest.mark.parametrize("unusable", [0.0, np.nan])
def test_an_unusable_normal_is_not_known_and_drops_no_point(unusable):
    normals = np.tile([0.0, 0.0, 2.0], (8, 1))
    normals[3] = unusable
    cloud = PointCloud.from_arrays(CUBE, normals)
    assert cloud.normals is not None
    expected = np.tile([0.0, 0.0, 1.0], (8, 1))
    expected[3] = 0.0
    np.testing.assert_array_equal(cloud.normals, expected)


def test_normals_of_which_none_is_usable_are_none():
    assert PointCloud.from_arrays(CUBE, np.zeros((8, 3))).normals is None


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((0, 3)), "found none"),
        (np.full((4, 3), np.nan), "4 rows, all NaN or infinite"),
        (np.zeros((5, 2)), r"expected an array of shape \(n, 3\), got \(5, 2\)"),
        (np.zeros((3, 50)), "transpose it"),
        (np.zeros(3), r"got \(3,\)"),
        ([[1, 2, 3], [4, 5]], "shape"),
        (np.array([["a", "b", "c"]]), "expected real numbers"),
        (np.ones((4, 3), dtype=complex), "expected real numbers"),
    ],
)
def test_refuses_what_is_not_a_cloud(points, message):
    with pytest.raises(InputError, match=message):
        PointCloud.from_arrays(points)


def test_refuses_another_number_of_normals():
    with pytest.raises(InputError, match="7 normals for 8 points"):
        PointCloud.from_arrays(CUBE, np.ones((7, 3)))


def test_the_constructor_itself_accepts_only_finite_rows_of_three():
    with pytest.raises(InputError, match="from_arrays"):
        PointCloud(np.full((2, 3), np.nan))
    with pytest.raises(InputError, match="normals"):
        PointCloud(np.zeros((2, 3)), np.ones((3, 3)))


# --- objects of other packages ------------------------------------------------------------


class Open3D:
    """What is used of ``open3d.geometry.PointCloud``, which is too large to install here."""

    def __init__(self, points, normals):
        self.points, self.normals = points, normals

    def has_normals(self):
        return len(self.normals) > 0


class Tensor:
    def __init__(self, values):
        self.values = values

    def numpy(self):
        return self.values


class TensorMap(dict):
    """``open3d.t.geometry.PointCloud.point``: names in it are attributes of it."""

    __getattr__ = dict.__getitem__


@pytest.mark.parametrize("has_normals", [False, True])
def test_clouds_of_open3d(has_normals):
    normals = np.tile([0.0, 0.0, 2.0], (8, 1)) if has_normals else np.empty((0, 3))
    cloud = PointCloud.from_any(Open3D(CUBE, normals))
    np.testing.assert_array_equal(cloud.points, CUBE)
    assert (cloud.normals is not None) == has_normals
    fields = TensorMap(positions=Tensor(CUBE))
    if has_normals:
        fields["normals"] = Tensor(normals)
    cloud = PointCloud.from_any(SimpleNamespace(point=fields))
    np.testing.assert_array_equal(cloud.points, CUBE)
    assert (cloud.normals is not None) == has_normals


def test_clouds_and_meshes_of_trimesh_and_pyvista():
    box = trimesh.creation.box((1.0, 2.0, 3.0))
    for source in (box, trimesh.PointCloud(box.vertices), pyvista_like(box.vertices)):
        np.testing.assert_array_equal(PointCloud.from_any(source).points, box.vertices)


def pyvista_like(points):
    return SimpleNamespace(points=points)


def test_anything_else_with_points(tmp_path):
    np.save(tmp_path / "cube.npy", CUBE)
    cloud = PointCloud(CUBE)
    assert PointCloud.from_any(cloud) is cloud
    for source in (CUBE, CUBE.tolist(), tmp_path / "cube.npy", str(tmp_path / "cube.npy")):
        np.testing.assert_array_equal(PointCloud.from_any(source).points, CUBE)
    for source in (object(), 3, None, "no such file.ply"):
        with pytest.raises(InputError, match=r"expected|no such file"):
            PointCloud.from_any(source)
