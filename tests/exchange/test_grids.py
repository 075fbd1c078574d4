"""Organised points from NPY and PCD files."""

import numpy as np
import pytest
from pypcd4 import PointCloud

from crispline.errors import InputError
from crispline.exchange.grids import read_grid_npy, read_grid_pcd


def grid(m=5, n=7):
    return np.random.default_rng(0).normal(size=(m, n, 3)).astype(np.float32)


def write_pcd(path, points, height, width, fields=("x", "y", "z")):
    columns = list(np.asarray(points, dtype=np.float32).reshape(-1, len(fields)).T)
    cloud = PointCloud.from_points(columns, fields, (np.float32,) * len(fields))
    cloud.metadata.height, cloud.metadata.width = height, width
    cloud.save(path)


def test_arrays_come_as_they_are(tmp_path):
    points = grid()
    points[1, 2, 0] = np.nan
    np.save(tmp_path / "a.npy", points)
    found = read_grid_npy(tmp_path / "a.npy")
    assert found.dtype == np.float64
    assert np.isnan(found[1, 2]).all()
    points[1, 2] = np.nan
    np.testing.assert_array_equal(found, points)


def test_pcd_rows_are_rows(tmp_path):
    points = grid()
    points[0, 3], points[4, 4], points[2, 2] = 0.0, 0.0, np.nan
    write_pcd(tmp_path / "a.pcd", points, 5, 7)
    found = read_grid_pcd(tmp_path / "a.pcd")
    is_invalid = np.isnan(found).all(axis=2)
    assert np.argwhere(is_invalid).tolist() == [[0, 3], [2, 2], [4, 4]]
    np.testing.assert_array_equal(found[~is_invalid], points[~is_invalid])


def test_further_fields_are_left_out(tmp_path):
    points = np.concatenate([grid(), np.ones((5, 7, 1))], axis=2)
    write_pcd(tmp_path / "a.pcd", points, 5, 7, ("x", "y", "z", "intensity"))
    np.testing.assert_array_equal(read_grid_pcd(tmp_path / "a.pcd"), points[:, :, :3])


def test_unorganised_points_are_refused(tmp_path):
    write_pcd(tmp_path / "a.pcd", grid(), 1, 35)
    with pytest.raises(InputError, match=r"expected organised points, .* found 35 x 1 for 35 poi"):
        read_grid_pcd(tmp_path / "a.pcd")


def test_a_pcd_without_z_is_refused(tmp_path):
    write_pcd(tmp_path / "a.pcd", grid()[:, :, :2], 5, 7, ("x", "y"))
    with pytest.raises(InputError, match=r"a\.pcd': expected a PCD file with x, y and z"):
        read_grid_pcd(tmp_path / "a.pcd")


def test_other_content_is_refused(tmp_path):
    for name, read in (("a.npy", read_grid_npy), ("a.pcd", read_grid_pcd)):
        (tmp_path / name).write_bytes(b"points")
        with pytest.raises(InputError, match=rf"{name}': expected .* found content that cannot"):
            read(tmp_path / name)


def test_an_array_of_objects_is_refused(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[1, "a"]], dtype=object), allow_pickle=True)
    with pytest.raises(InputError, match=r"a\.npy': expected an NPY file"):
        read_grid_npy(tmp_path / "a.npy")


def test_a_depth_image_is_refused(tmp_path):
    np.save(tmp_path / "a.npy", np.ones((48, 64)))
    with pytest.raises(InputError, match=r"a\.npy': expected a grid .* turn a depth image into"):
        read_grid_npy(tmp_path / "a.npy")
