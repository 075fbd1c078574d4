import io
from pathlib import Path

import numpy as np
import pypcd4.pypcd4
import pytest
import trimesh

from crispline.cloud.read import read_points
from crispline.cloud.write import write_points
from crispline.errors import InputError

POINTS = np.random.default_rng(7).normal(size=(40, 3))
ROWS = "\n".join(" ".join(map(repr, row)) for row in POINTS.tolist())
PLY_HEADER = """ply
format {format} 1.0
comment made by hand
element vertex 2
property float x
property float y
property float z
end_header
"""


def rows(separator: str) -> str:
    return "\n".join(separator.join(map(repr, row)) for row in POINTS.tolist())


def write(path: Path, content: str | bytes) -> Path:
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path


# --- text ---------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix", [".xyz", ".txt", ".csv", ".asc", ".pts", ".XYZ"])
@pytest.mark.parametrize("separator", [" ", "   ", ",", ", ", ";", "\t"])
def test_text_with_any_separator(tmp_path, suffix, separator):
    path = write(tmp_path / f"cloud{suffix}", rows(separator))
    np.testing.assert_array_equal(read_points(path).points, POINTS)


@pytest.mark.parametrize(
    "preamble",
    [
        "# a comment\n\n// another\n",
        "X Y Z\n",
        "//X Y Z\n40\n",
        "40\n",
        "\ufeffx y z\n",
        "easting northing height\n",
    ],
)
def test_text_with_comments_header_or_count(tmp_path, preamble):
    path = write(tmp_path / "cloud.pts", preamble + ROWS + "\n# the end\n")
    np.testing.assert_array_equal(read_points(path).points, POINTS)


def test_extra_columns_are_ignored(tmp_path):
    table = "\n".join(f"{line} 0.5 255 wall" for line in ROWS.splitlines())
    cloud = read_points(write(tmp_path / "cloud.xyz", table))
    np.testing.assert_array_equal(cloud.points, POINTS)
    assert cloud.normals is None


def test_named_columns_are_found_wherever_they_stand(tmp_path):
    lines = [f"{i},{z},{y},{x},0,0,2" for i, (x, y, z) in enumerate(POINTS.tolist())]
    text = '"id","Z","Y","X","nx","ny","nz"\n' + "\n".join(lines)
    cloud = read_points(write(tmp_path / "cloud.csv", text))
    np.testing.assert_array_equal(cloud.points, POINTS)
    np.testing.assert_array_equal(cloud.normals, np.tile([0.0, 0.0, 1.0], (40, 1)))


def test_a_header_with_units_does_not_shift_the_columns(tmp_path):
    text = "x [m] y [m] z [m]\n" + ROWS
    np.testing.assert_array_equal(read_points(write(tmp_path / "cloud.txt", text)).points, POINTS)


@pytest.mark.parametrize("separator", [";", " ", "\t"])
def test_decimal_commas(tmp_path, separator):
    path = write(tmp_path / "cloud.csv", rows(separator).replace(".", ","))
    np.testing.assert_array_equal(read_points(path).points, POINTS)


def test_rows_that_are_not_finite_are_dropped_and_counted(tmp_path):
    path = write(tmp_path / "cloud.xyz", f"nan nan nan\n{ROWS}\n1 inf 2\n")
    cloud = read_points(path)
    assert cloud.n_dropped == 2
    np.testing.assert_array_equal(cloud.points, POINTS)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 2 3\n4 five 6\n", "line 2: expected a number, found 'five'"),
        ("# head\n1 2 3\n\n4 5\n", "line 4: expected at least 3 columns, found 2"),
        ("1,2,3\n4,,6\n", "line 2: expected a number, found ''"),
        ("1 2\n3 4\n", "line 1: expected at least 3 columns, found 2"),
        ("hello world\nsecond line\n", "line 2: expected a number, found 'second'|columns"),
        ("hello world\n", "expected rows of x y z, found none"),
        ("# nothing\n", "expected rows of x y z, found none"),
        ("\n\n", "expected rows of x y z, found none"),
        ("ncols 4\nnrows 4\n1 2 3 4\n", "line 1"),
        ("nan nan nan\ninf 0 0\n", "found 2 rows, all NaN or infinite"),
        ("1;2;3\n1,5;2;3\n", "line 2: expected a number, found '1,5'"),
    ],
)
def test_faulty_text_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_points(write(tmp_path / "cloud.txt", text))


# --- binary and mesh formats --------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float32, np.float64, np.int32])
def test_npy(tmp_path, dtype):
    points = (100.0 * POINTS).astype(dtype)
    np.save(tmp_path / "cloud.npy", np.hstack([points, points]))
    np.testing.assert_array_equal(read_points(tmp_path / "cloud.npy").points, points)


@pytest.mark.parametrize(
    ("array", "message"),
    [
        (np.zeros((3, 400)), "transpose it"),
        (np.zeros((40, 2)), r"got \(40, 2\)"),
        (np.zeros((4, 4, 3)), r"got \(4, 4, 3\)"),
        (np.array(["a"] * 4), "shape"),
        (np.array([{"x": 1}], dtype=object), "cannot be read"),
    ],
)
def test_npy_of_another_kind_is_refused(tmp_path, array, message):
    np.save(tmp_path / "cloud.npy", array)
    with pytest.raises(InputError, match=message):
        read_points(tmp_path / "cloud.npy")


@pytest.mark.parametrize("encoding", ["ascii", "binary", "vertex_normals"])
def test_ply_keeps_every_vertex_in_order(tmp_path, encoding):
    # Unused and repeated vertices, which mesh processing would remove.
    vertices = np.vstack([POINTS, POINTS[:5]]).astype(np.float32)
    mesh = trimesh.Trimesh(vertices, [[7, 3, 9]], process=False)
    content = mesh.export(
        file_type="ply",
        encoding="ascii" if encoding == "ascii" else "binary",
        vertex_normal=encoding == "vertex_normals",
    )
    cloud = read_points(write(tmp_path / "cloud.ply", content))
    np.testing.assert_allclose(cloud.points, vertices, atol=1e-6)


def test_ply_normals_are_read(tmp_path):
    sphere = trimesh.creation.icosphere(subdivisions=2)
    content = sphere.export(file_type="ply", vertex_normal=True)
    cloud = read_points(write(tmp_path / "ball.ply", content))
    assert cloud.normals is not None
    np.testing.assert_allclose(cloud.normals, sphere.vertex_normals, atol=1e-5)


def test_pcd_with_invalid_pixels(tmp_path):
    points = POINTS.astype(np.float32)
    points[4] = np.nan
    pypcd4.pypcd4.PointCloud.from_xyz_points(points).save(tmp_path / "cloud.pcd")
    cloud = read_points(tmp_path / "cloud.pcd")
    assert cloud.n_dropped == 1
    np.testing.assert_array_equal(cloud.points, np.delete(points, 4, axis=0))


def test_obj_keeps_vertices_that_no_face_uses(tmp_path):
    text = "# mesh\no part\n" + "".join(f"v {line}\n" for line in ROWS.splitlines())
    text += "vn 0 0 1\nvt 0 0\nf 1 2 3\n"
    np.testing.assert_array_equal(read_points(write(tmp_path / "a.obj", text)).points, POINTS)


@pytest.mark.parametrize("file_type", ["stl", "stl_ascii", "off"])
def test_vertices_of_meshes(tmp_path, file_type):
    box = trimesh.creation.box((1.0, 2.0, 4.0))
    path = write(tmp_path / f"box.{file_type[:3]}", box.export(file_type=file_type))
    np.testing.assert_array_equal(
        np.unique(read_points(path).points, axis=0), np.unique(box.vertices, axis=0)
    )
    assert len(read_points(path)) == 8


@pytest.mark.parametrize("suffix", [".ply", ".xyz", ".npy"])
def test_what_is_written_is_read_back(tmp_path, suffix):
    write_points(tmp_path / f"cloud{suffix}", POINTS)
    tolerance = 1e-6 if suffix == ".ply" else 0.0
    points = read_points(tmp_path / f"cloud{suffix}").points
    np.testing.assert_allclose(points, POINTS, rtol=0.0, atol=tolerance)


# --- every file that cannot be used -------------------------------------------------------

ALL_SUFFIXES = [".asc", ".csv", ".npy", ".obj", ".off", ".pcd", ".ply", ".pts", ".stl", ".txt"]
BINARY = bytes(range(256)) * 8


@pytest.mark.parametrize("suffix", ALL_SUFFIXES)
@pytest.mark.parametrize(
    "content",
    [b"", b"\n", b"Dear reader,\nthis is a letter.\n", BINARY, b"\0" * 100],
    ids=["empty", "blank", "letter", "binary", "zeros"],
)
def test_content_that_is_not_of_the_format(tmp_path, suffix, content):
    path = write(tmp_path / f"cloud{suffix}", content)
    with pytest.raises(InputError) as caught:
        read_points(path)
    message = str(caught.value)
    assert path.name in message
    assert "\n" not in message
    assert "expected" in message


def test_truncated_files(tmp_path):
    header = PLY_HEADER.format(format="binary_little_endian").encode()
    with pytest.raises(InputError, match="PLY"):
        read_points(write(tmp_path / "short.ply", header + b"\0" * 20))
    with pytest.raises(InputError, match="2 vertices declared, 1 present"):
        read_points(write(tmp_path / "rows.ply", PLY_HEADER.format(format="ascii") + "1 2 3\n"))
    buffer = io.BytesIO()
    np.save(buffer, POINTS)
    with pytest.raises(InputError, match="NPY"):
        read_points(write(tmp_path / "short.npy", buffer.getvalue()[:-100]))
    path = tmp_path / "short.pcd"
    pypcd4.pypcd4.PointCloud.from_xyz_points(POINTS.astype(np.float32)).save(path)
    with pytest.raises(InputError, match="PCD"):
        read_points(write(path, path.read_bytes()[:-10]))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("missing.ply", "no such file"),
        ("folder.ply", "found a folder"),
        ("cloud.docx", r"found '\.docx'"),
        ("cloud", "found 'cloud'"),
    ],
)
def test_paths_that_are_no_cloud(tmp_path, name, message):
    (tmp_path / "folder.ply").mkdir()
    for other in ("cloud.docx", "cloud"):
        write(tmp_path / other, ROWS)
    with pytest.raises(InputError, match=message):
        read_points(tmp_path / name)


def test_a_path_may_be_text(tmp_path):
    assert len(read_points(str(write(tmp_path / "cloud.xyz", ROWS)))) == len(POINTS)
