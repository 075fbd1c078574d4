import numpy as np
import pytest

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
def test_one_unusable_normal_discards_all_of_them_but_no_point(unusable):
    normals = np.ones((8, 3))
    normals[3] = unusable
    cloud = PointCloud.from_arrays(CUBE, normals)
    assert cloud.normals is None
    assert len(cloud) == 8


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
