"""Formats of scanners: LAS, E57, PCD with a viewpoint; and arrays with names."""

import numpy as np
import pye57
import pypcd4.pypcd4
import pytest
from pye57 import libe57
from scipy.spatial.transform import Rotation

from crispline.cloud.read import read_points
from crispline.errors import InputError

RNG = np.random.default_rng(5)
POINTS = RNG.normal(size=(60, 3))
UTM = np.array([497_163.0, 5_419_605.0, 272.0])


def scan(points, **more):
    return {**dict(zip(("cartesianX", "cartesianY", "cartesianZ"), points.T, strict=True)), **more}


def test_the_scans_of_an_e57_file_are_joined_in_the_common_frame(tmp_path):
    path = tmp_path / "site.e57"
    turns = [Rotation.from_rotvec([0.1, -0.7, 2.0]), Rotation.identity()]
    places = [UTM, UTM + np.array([10.0, -5.0, 1.0])]
    local = [POINTS.astype(np.float32).astype(float), 2.0 * POINTS[:20].astype(np.float32)]
    with pye57.E57(str(path), mode="w") as file:
        for points, turn, place in zip(local, turns, places, strict=True):
            quaternion = turn.as_quat(scalar_first=True)
            file.write_scan_raw(scan(points), rotation=quaternion, translation=place)
    cloud = read_points(path)
    expected = [t.apply(p) + o for p, t, o in zip(local, turns, places, strict=True)]
    np.testing.assert_allclose(cloud.points, np.concatenate(expected), rtol=0.0, atol=2e-9)
    np.testing.assert_array_equal(cloud.viewpoints[[0, -1]], places)


def test_invalid_pixels_of_an_organised_scan_are_dropped(tmp_path):
    path = tmp_path / "image.e57"
    state = np.zeros(60, dtype=np.int8)
    state[[3, 7]] = 1, 2
    rows, columns = np.divmod(np.arange(60), 10)
    with pye57.E57(str(path), mode="w") as file:
        content = scan(POINTS, cartesianInvalidState=state, rowIndex=rows, columnIndex=columns)
        file.write_scan_raw(content)
    cloud = read_points(path)
    assert (len(cloud), cloud.n_dropped) == (58, 2)
    np.testing.assert_allclose(cloud.points, np.delete(POINTS, [3, 7], axis=0), atol=1e-6)


def test_spherical_coordinates(tmp_path):
    path = tmp_path / "sphere.e57"
    distance = np.linalg.norm(POINTS, axis=1)
    azimuth = np.arctan2(POINTS[:, 1], POINTS[:, 0])
    elevation = np.arcsin(POINTS[:, 2] / distance)
    names = ("sphericalRange", "sphericalAzimuth", "sphericalElevation")
    with pye57.E57(str(path), mode="w") as file:
        _write_fields(file, dict(zip(names, (distance, azimuth, elevation), strict=True)))
    np.testing.assert_allclose(read_points(path).points, POINTS, atol=1e-14)


def _write_fields(file, fields):
    """A scan of any double fields and no pose, which `write_scan_raw` does not write."""
    image = file.image_file
    node, prototype = libe57.StructureNode(image), libe57.StructureNode(image)
    for name in fields:
        prototype.set(name, libe57.FloatNode(image, 0.0, libe57.E57_DOUBLE))
    points = libe57.CompressedVectorNode(image, prototype, libe57.VectorNode(image, True))
    node.set("points", points)
    file.data3d.append(node)
    buffers = libe57.VectorSourceDestBuffer()
    kept = [np.ascontiguousarray(values, dtype=float) for values in fields.values()]
    for name, values in zip(fields, kept, strict=True):
        buffers.append(libe57.SourceDestBuffer(image, name, values, len(values), True, True))
    writer = points.writer(buffers)
    writer.write(len(kept[0]))
    writer.close()


def test_an_e57_file_without_a_scan_is_refused(tmp_path):
    pye57.E57(str(tmp_path / "empty.e57"), mode="w").close()
    with pytest.raises(InputError, match="expected scans with points, found none"):
        read_points(tmp_path / "empty.e57")


@pytest.mark.parametrize("suffix", [".e57", ".las", ".laz", ".npz"])
@pytest.mark.parametrize("content", [b"", b"Dear reader,\n", b"\0" * 400])
def test_content_that_is_not_of_the_format(tmp_path, suffix, content):
    path = tmp_path / f"scan{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="expected") as caught:
        read_points(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("encoding", list(pypcd4.pypcd4.Encoding))
def test_every_encoding_of_pcd_keeps_doubles(tmp_path, encoding):
    points = UTM + POINTS
    content = pypcd4.pypcd4.PointCloud.from_points(points, ("x", "y", "z"), [np.float64] * 3)
    content.save(tmp_path / "scan.pcd", encoding)
    atol = 1e-3 if encoding == pypcd4.pypcd4.Encoding.ASCII else 0.0  # its writer rounds
    read = read_points(tmp_path / "scan.pcd").points
    np.testing.assert_allclose(read, points, rtol=0.0, atol=atol)


def test_pcd_tells_where_the_scanner_stood(tmp_path):
    path = tmp_path / "scan.pcd"
    pypcd4.pypcd4.PointCloud.from_xyz_points(POINTS.astype(np.float32)).save(path)
    assert read_points(path).viewpoints is None
    content = path.read_bytes()
    path.write_bytes(content.replace(b"VIEWPOINT 0.0 0.0 0.0", b"VIEWPOINT 1.5 0.0 9.0"))
    np.testing.assert_array_equal(read_points(path).viewpoints[0], [1.5, 0.0, 9.0])
    path.write_bytes(
        content.replace(b"WIDTH 60", b"WIDTH 10").replace(b"HEIGHT 1\n", b"HEIGHT 6\n")
    )
    np.testing.assert_array_equal(read_points(path).viewpoints, np.zeros((60, 3)))


@pytest.mark.parametrize("name", ["points", "xyz", "anything"])
def test_npz(tmp_path, name):
    np.savez(tmp_path / "scan.npz", **{name: np.hstack([POINTS, POINTS])})
    np.testing.assert_array_equal(read_points(tmp_path / "scan.npz").points, POINTS)


def test_npz_with_normals_and_other_arrays(tmp_path):
    units = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
    np.savez(tmp_path / "scan.npz", label=np.arange(60), points=POINTS, normals=3.0 * units)
    np.testing.assert_allclose(read_points(tmp_path / "scan.npz").normals, units)
    np.savez(tmp_path / "scan.npz", a=POINTS, b=POINTS)
    with pytest.raises(InputError, match="expected an array named 'points', found 'a', 'b'"):
        read_points(tmp_path / "scan.npz")


@pytest.mark.parametrize("separator", [" ", ",", ";"])
def test_six_columns_with_unit_vectors_are_points_and_normals(tmp_path, separator):
    units = POINTS / np.linalg.norm(POINTS, axis=1, keepdims=True)
    table = np.hstack([POINTS, units])
    path = tmp_path / "scan.xyz"
    np.savetxt(path, table, fmt="%.6f", delimiter=separator)
    np.testing.assert_allclose(read_points(path).normals, units, atol=1e-5)
    table[-1, 3:] = 0.4, 0.5, 0.6  # then they were something else
    np.savetxt(path, table, fmt="%.6f", delimiter=separator)
    cloud = read_points(path)
    assert cloud.normals is None
    np.testing.assert_allclose(cloud.points, POINTS, atol=1e-6)
