"""The command `convert`."""

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

from crispline import cli
from crispline.cadfile.shape_files import read_shape
from crispline.cloud.read import read_points
from crispline.exchange import write_model

POINTS = np.random.default_rng(2).normal(size=(40, 3))


def convert(*arguments):
    return CliRunner().invoke(cli.main, ["convert", *map(str, arguments)])


@pytest.mark.parametrize("target", ["scan.ply", "scan.LAS", "scan.csv", "scan.npz"])
def test_clouds(tmp_path, target):
    source = tmp_path / "scan.xyz"
    np.savetxt(source, np.vstack([POINTS, [np.nan, 0.0, 0.0]]), fmt="%.17g")
    outcome = convert(source, tmp_path / target)
    assert outcome.exit_code == 0, outcome.output
    assert outcome.output == f"{tmp_path / target}: 40 points, 1 invalid left out\n"
    np.testing.assert_allclose(read_points(tmp_path / target).points, POINTS, atol=1e-8)


def test_models(tmp_path):
    step, iges, stl = (tmp_path / f"box.{suffix}" for suffix in ("step", "igs", "stl"))
    write_model(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape(), step, "in")
    for source, target in ((step, iges), (iges, stl)):
        outcome = convert(source, target)
        assert outcome.exit_code == 0, outcome.output
        assert outcome.output == f"{target}: in in\n"
    assert read_shape(iges).unit == "in"
    assert trimesh.load(stl).volume == pytest.approx(6.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("part.step", "part.xyz"), "ends in .brep or"),
        (("scan.ply", "scan.step"), "ends in .csv or"),
        (("scan.ply", "none/scan.xyz"), "does not exist"),
        (("missing.ply", "scan.xyz"), "no such file"),
        (("missing.step", "part.stl"), "no such file"),
        (("letter.step", "part.stl"), "expected a STEP file with a shape"),
        (("scan.ply", "scan.xyz", "--tolerance", "1"), "a cloud has none"),
        (("part.step", "part.stl", "--tolerance", "0"), "--tolerance"),
    ],
)
def test_bad_usage_is_one_sentence_and_no_file(tmp_path, arguments, message):
    (tmp_path / "letter.step").write_text("Dear reader,\n")
    before = sorted(tmp_path.iterdir())
    source, target, *options = arguments
    outcome = convert(tmp_path / source, tmp_path / target, *options)
    assert outcome.exit_code == 2
    assert message in outcome.output
    assert "Traceback" not in outcome.output
    assert sorted(tmp_path.iterdir()) == before
