import numpy as np
import pytest
import trimesh

from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.read import READ_SUFFIXES, read_points
from crispline.cloud.write import WRITE_SUFFIXES, write_points
from crispline.errors import InputError

RNG = np.random.default_rng(3)
UTM = np.array([497_163.0, 5_419_605.0, 272.0])
NORMALS = RNG.normal(size=(300, 3))
NORMALS /= np.linalg.norm(NORMALS, axis=1, keepdims=True)
FAR = PointCloud(UTM + RNG.normal(scale=20.0, size=(300, 3)), NORMALS)
# LAS counts steps of 1e-7 here, plus the rounding of a double; the others hold every double.
STEP = {".las": 5.1e-8, ".laz": 5.1e-8}


@pytest.mark.parametrize("suffix", WRITE_SUFFIXES)
def test_large_coordinates_and_normals_come_back(tmp_path, suffix):
    path = tmp_path / f"scan{suffix}"
    write_points(path, FAR)
    cloud = read_points(path)
    assert np.abs(cloud.points - FAR.points).max() <= STEP.get(suffix, 0.0)
    if suffix == ".npy":
        assert cloud.normals is None
    else:
        np.testing.assert_allclose(cloud.normals, NORMALS, atol=1e-7)


@pytest.mark.parametrize("suffix", WRITE_SUFFIXES)
def test_bare_points_come_back_and_the_bytes_are_the_same(tmp_path, suffix):
    points = RNG.normal(size=(50, 3))
    contents = []
    for _ in range(2):
        write_points(tmp_path / f"scan{suffix}", points)
        contents.append((tmp_path / f"scan{suffix}").read_bytes())
    assert contents[0] == contents[1]
    cloud = read_points(tmp_path / f"scan{suffix}")
    assert cloud.normals is None
    np.testing.assert_allclose(cloud.points, points, atol=1e-8)
    assert set(WRITE_SUFFIXES) <= set(READ_SUFFIXES)


def test_ply_is_short_where_that_loses_nothing(tmp_path):
    points = RNG.normal(size=(50, 3))
    write_points(tmp_path / "double.ply", points)
    write_points(tmp_path / "single.ply", points.astype(np.float32))
    assert b"property double x" in (tmp_path / "double.ply").read_bytes()
    assert b"property float x" in (tmp_path / "single.ply").read_bytes()
    read = trimesh.load(tmp_path / "single.ply").vertices
    np.testing.assert_array_equal(read, points.astype(np.float32))


def test_viewpoints_go_into_npz(tmp_path):
    seen = PointCloud(FAR.points, None, 0, FAR.points + np.array([0.0, 0.0, 50.0]))
    write_points(tmp_path / "scan.npz", seen)
    np.testing.assert_array_equal(read_points(tmp_path / "scan.npz").viewpoints, seen.viewpoints)


def test_las_of_one_point(tmp_path):
    write_points(tmp_path / "one.las", [[1.5, -2.25, 1e6]])
    np.testing.assert_allclose(read_points(tmp_path / "one.las").points, [[1.5, -2.25, 1e6]])


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "laspy", None)
    with pytest.raises(InputError, match=r"pip install 'crispline\[las\]'"):
        write_points(tmp_path / "scan.las", FAR)
    assert list(tmp_path.iterdir()) == []
