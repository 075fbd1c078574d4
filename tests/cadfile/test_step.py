"""STEP files: the same bytes, whole or not at all, and read back."""

import os
from pathlib import Path

import brep_models
import pytest

from crispline.brep.build import build_shape
from crispline.brep.check import check_file
from crispline.cadfile.step import read_step, step_bytes, write_step
from crispline.errors import InputError


@pytest.mark.parametrize("has_pcurves", [False, True])
@pytest.mark.parametrize("name", ["box_cylinder", "two_boxes", "spline_top"])
def test_equal_shapes_give_equal_bytes(name, has_pcurves):
    model = brep_models.SAMPLES[name]().model
    contents = [step_bytes(build_shape(model).shape, has_pcurves) for _ in range(3)]
    assert contents[0] == contents[1] == contents[2]


def test_header_names_no_time_and_unit_is_millimetre():
    content = step_bytes(build_shape(brep_models.box().model).shape, False)
    assert b"'1970-01-01T00:00:00'" in content
    assert b"SI_UNIT(.MILLI.,.METRE.)" in content


def test_curves_in_the_parameter_plane_are_left_out(tmp_path):
    shape = build_shape(brep_models.spline_top().model).shape
    write_step(shape, tmp_path / "part.step")
    content = (tmp_path / "part.step").read_bytes()
    assert content == step_bytes(shape, has_pcurves=False)
    assert b"PCURVE" not in content
    assert b"PCURVE" in step_bytes(shape, has_pcurves=True)


def test_coordinates_keep_their_digits(tmp_path):
    model = brep_models.box().model
    shape = build_shape(model).shape
    write_step(shape, tmp_path / "part.step")
    assert check_file(tmp_path / "part.step").volume == pytest.approx(72000, rel=1e-15)


def test_writing_replaces_and_leaves_nothing_else_behind(tmp_path):
    path = tmp_path / "part.step"
    path.write_text("old")
    write_step(build_shape(brep_models.box().model).shape, path)
    assert os.listdir(tmp_path) == ["part.step"]
    assert path.read_bytes().startswith(b"ISO-10303-21;")


def test_failed_writing_leaves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "part.step"
    path.write_text("old")

    def fail(*_):
        raise OSError("disk full")

    monkeypatch.setattr(Path, "write_bytes", fail)
    with pytest.raises(InputError, match="disk full"):
        write_step(build_shape(brep_models.box().model).shape, path)
    assert os.listdir(tmp_path) == ["part.step"]
    assert path.read_text() == "old"


@pytest.mark.parametrize("content", [b"", b"solid", b"ISO-10303-21;\nHEADER;\n"])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "part.step"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"part\.step: expected a STEP file"):
        read_step(path)


def test_nothing_is_printed(tmp_path, capfd):
    write_step(build_shape(brep_models.box().model).shape, tmp_path / "part.step")
    check_file(tmp_path / "part.step")
    assert capfd.readouterr() == ("", "")
