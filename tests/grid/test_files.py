"""`crispline sharpen`: files in, files out, read back; bad use."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from crispline import occt
from crispline.cadfile.step import read_step
from crispline.cli import main
from crispline.exchange.read import read_surfaces
from crispline.exchange.write import write_surfaces
from crispline.grid import sharpen
from crispline.spline.tensor import TensorSpline, spline_over_grid


def run(*arguments):
    return CliRunner().invoke(main, ["sharpen", *map(str, arguments)])


def test_a_grid_becomes_a_step_file_that_reads_back_creased(grids, tmp_path):
    np.save(tmp_path / "fold.npy", grids.folded(0.3))
    result = run(
        tmp_path / "fold.npy", "-o", tmp_path / "out.step", "--summary", tmp_path / "s.json"
    )
    assert result.exit_code == 0, result.output
    (surface,) = read_surfaces(tmp_path / "out.step")
    (level,) = [x for x in np.unique(surface.knots_v)[1:-1] if (surface.knots_v == x).sum() == 3]
    crease = surface.evaluate(np.linspace(0, 8, 50), np.full(50, level))
    assert np.hypot(crease[:, 0], crease[:, 2]).max() < 1e-9
    (summary,) = json.loads((tmp_path / "s.json").read_text())["surfaces"]
    assert summary["patches"] == {"flat": 112, "curved": 16, "sharp": 8}
    assert summary["kind"] == "tensor product"
    assert summary["n_edges"] == len(summary["edges"]) == 1
    assert summary["spacing"] == pytest.approx(1.0)
    assert summary["noise"] < 1e-9


@pytest.mark.parametrize("suffix", [".step", ".iges", ".json", ".npz"])
def test_a_surface_keeps_its_kind_of_file_and_its_control_points(grids, tmp_path, suffix):
    surface = spline_over_grid(grids.heights(lambda i, j: -np.abs(j - 8.7)))
    write_surfaces(tmp_path / f"in{suffix}", surface)
    result = run(tmp_path / f"in{suffix}", "-o", tmp_path / f"out{suffix}")
    assert result.exit_code == 0, result.output
    (back,) = read_surfaces(tmp_path / f"out{suffix}")
    u, v = np.random.default_rng(0).uniform(0, 23, (2, 2000))
    points = back.evaluate(u, v)
    np.testing.assert_allclose(points[:, 2], -np.abs(points[:, 1] - 8.7), atol=1e-9)
    far = np.abs(v - 8.7) > 2.4
    np.testing.assert_allclose(points[far], surface.evaluate(u[far], v[far]), atol=1e-11)


@pytest.mark.parametrize("suffix", [".step", ".json", ".npz", ".ply", ".obj", ".iges"])
def test_a_net_is_written_in_every_format(grids, tmp_path, suffix):
    result = sharpen(grids.corner(0.2))
    path = tmp_path / f"corner{suffix}"
    result.write(path)
    assert path.stat().st_size > 0
    if suffix == ".step":
        shape = read_step(path)
        assert occt.subshapes(shape, occt.SHELL)
    elif suffix in (".json", ".npz"):
        pieces = read_surfaces(path)
        assert len(pieces) > 3
        assert all(isinstance(piece, TensorSpline) for piece in pieces)


def test_several_surfaces_and_their_unit(grids, tmp_path):
    surface = spline_over_grid(grids.folded(0.3))
    write_surfaces(tmp_path / "two.step", [surface, surface], unit="in")
    result = run(tmp_path / "two.step", "-o", tmp_path / "out.step")
    assert result.exit_code == 0, result.output
    one, _ = read_surfaces(tmp_path / "out.step")
    assert np.ptp(one.control_points[:, :, 0]) == pytest.approx(8.3, abs=1.0)


def test_the_mesh_has_the_crease_among_its_vertices(grids):
    vertices, triangles = sharpen(grids.folded(0.3)).mesh(1)
    assert triangles.max() < len(vertices)
    assert (np.hypot(vertices[:, 0], vertices[:, 2]) < 1e-9).sum() == 17


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["--rule", "other"], "other"),
        (["--repeat", "4"], "4"),
        (["--eps", "-1"], "-1"),
        (["-o", "out.txt"], ".txt"),
    ],
)
def test_bad_use(grids, tmp_path, arguments, text):
    np.save(tmp_path / "fold.npy", grids.folded(0.3))
    output = [] if "-o" in arguments else ["-o", tmp_path / "out.step"]
    result = run(tmp_path / "fold.npy", *output, *arguments)
    assert result.exit_code == 2
    assert text in result.output


def test_a_bad_file_is_one_sentence(tmp_path):
    np.save(tmp_path / "points.npy", np.zeros((50, 3)))
    result = run(tmp_path / "points.npy", "-o", tmp_path / "out.step")
    assert result.exit_code == 2
    assert "(m, n, 3)" in result.output
    assert not (tmp_path / "out.step").exists()
