"""STEP, IGES and BREP files: units, names, colours, and what is refused."""

import re

import numpy as np
import pytest
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy, BRepBuilderAPI_MakeFace
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder

from crispline import occt
from crispline.brep.build import build_shape
from crispline.cadfile import readback, step
from crispline.cadfile.curve_files import write_curves
from crispline.cadfile.readback import is_same_solid
from crispline.cadfile.shape_files import SHAPE_SUFFIXES, read_millimetres, read_shape, write_shape
from crispline.cadfile.step import read_step, write_step
from crispline.cadfile.styled import FaceStyle
from crispline.cadfile.units import MILLIMETRES
from crispline.curve import BSplineCurve, Circle, Line
from crispline.errors import InputError, ReconstructionError
from crispline.occt.measure import Tessellation, diagonal, tessellate, volume
from crispline.surface import BSplineSurface
from crispline.surface.basis import uniform_knots

import brep_models  # isort: skip

X, Y, Z = np.eye(3)
DRUM = BRepPrimAPI_MakeCylinder(5.0, 10.0).Shape()
STYLES = [FaceStyle(f"part {k}", (0.2 * k, 0.5, 1.0)) for k in range(3)]


@pytest.mark.parametrize("unit", MILLIMETRES)
@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_five_in_a_unit_is_read_as_that_many_millimetres(tmp_path, suffix, unit):
    path = tmp_path / f"drum{suffix}"
    write_shape(DRUM, path, unit)
    factor = MILLIMETRES[unit]
    in_millimetres, named = read_millimetres(path)
    assert named == unit
    assert volume(in_millimetres) == pytest.approx(np.pi * 250.0 * factor**3, rel=1e-9)
    found = read_shape(path)
    assert found.unit == unit
    assert volume(found.shape) == pytest.approx(np.pi * 250.0, rel=1e-9)


@pytest.mark.parametrize("suffix", SHAPE_SUFFIXES)
@pytest.mark.parametrize("name", ["box_cylinder", "spline_top", "vase"])
def test_a_solid_comes_back_the_same_from_the_same_bytes(tmp_path, suffix, name):
    sample = brep_models.SAMPLES[name]()
    path = tmp_path / f"part{suffix}"
    contents = []
    for _ in range(2):
        write_shape(build_shape(sample.model).shape, path)
        contents.append(path.read_bytes())
    assert contents[0] == contents[1]
    copy = read_shape(path).shape
    assert len(occt.subshapes(copy, occt.SOLID)) == 1
    assert volume(copy) == pytest.approx(sample.volume, rel=1e-6)


def test_faces_have_names_and_colours_in_step(tmp_path):
    write_shape(DRUM, tmp_path / "drum.step", "cm", STYLES)
    text = (tmp_path / "drum.step").read_text()
    assert "AP242" in text
    faces = dict(re.findall(r"#(\d+) = ADVANCED_FACE\('([^']*)'", text))
    assert sorted(faces.values()) == [style.name for style in STYLES]
    styled = re.findall(r"STYLED_ITEM\('color',\(#\d+\),#(\d+)\)", text)
    assert sorted(styled) == sorted(faces)
    colours = re.findall(r"COLOUR_RGB\('',([^,]*),([^,]*),([^)]*)\)", text)
    found = sorted(tuple(map(float, colour)) for colour in colours)
    np.testing.assert_allclose(found, [style.colour for style in STYLES], atol=1e-6)


def test_a_style_is_needed_for_every_face(tmp_path):
    with pytest.raises(ValueError, match="zip"):
        write_step(DRUM, tmp_path / "drum.step", "mm", STYLES[:2])


def test_numbers_stand_in_the_file_as_they_are(tmp_path):
    write_step(BRepPrimAPI_MakeBox(2.3, 1.0, 1.0).Shape(), tmp_path / "box.step", "in")
    text = (tmp_path / "box.step").read_text()
    assert 2.3 in {float(number) for number in re.findall(r"\d\.\d*(?:E[+-]\d+)?", text)}


def test_an_unknown_unit_is_refused(tmp_path):
    for suffix in (".step", ".igs"):
        with pytest.raises(InputError, match=r"expected a length unit out of mm, um, .* got 'ell'"):
            write_shape(DRUM, tmp_path / f"drum{suffix}", "ell")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_a_file_that_reads_back_as_something_else_does_not_appear(tmp_path, monkeypatch, suffix):
    other = tmp_path / f"other{suffix}"
    write_shape(BRepPrimAPI_MakeCylinder(5.0, 10.1).Shape(), other)
    content = other.read_bytes()
    other.unlink()
    monkeypatch.setattr(step, "step_bytes", lambda *_: content)
    monkeypatch.setattr("crispline.cadfile.shape_files.iges_bytes", lambda *_, **__: content)
    with pytest.raises(ReconstructionError, match="does not read back as the same solid"):
        write_shape(DRUM, tmp_path / f"drum{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_what_is_the_same_solid():
    assert is_same_solid(DRUM, DRUM)
    assert not is_same_solid(None, DRUM)
    assert not is_same_solid(BRepPrimAPI_MakeCylinder(5.0, 10.0001).Shape(), DRUM)
    assert is_same_solid(BRepPrimAPI_MakeCylinder(50.0, 100.0).Shape(), DRUM, 10.0)
    assert not is_same_solid(occt.subshapes(DRUM, occt.FACE)[0], DRUM)


def test_the_same_triangles_need_no_exact_volume(monkeypatch):
    copy = BRepBuilderAPI_Copy(DRUM).Shape()
    monkeypatch.setattr(readback, "_volume", lambda _: pytest.fail("integrated"))
    assert is_same_solid(copy, DRUM)


def test_only_faces_whose_triangles_differ_are_integrated(monkeypatch):
    integrated = []

    def cone(shape, faces, apex):
        integrated.append(faces.tolist())
        return exactly(shape, faces, apex)

    def cones(mesh, apex, n_faces):
        found = honest(mesh, apex, n_faces)
        found[1] *= next(factors)
        return found

    exactly, honest = readback._cone, Tessellation.cones
    monkeypatch.setattr(readback, "_cone", cone)
    monkeypatch.setattr(Tessellation, "cones", cones)
    # The volume of the one, its cones, those of the other, for three comparisons.
    factors = iter([1.0, 1.0, 1.01] * 3)
    assert is_same_solid(DRUM, DRUM)
    assert integrated == [[1], [1]]
    assert is_same_solid(BRepPrimAPI_MakeCylinder(50.0, 100.0).Shape(), DRUM, 10.0)
    assert not is_same_solid(BRepPrimAPI_MakeCylinder(5.0, 10.0001).Shape(), DRUM)


def test_the_same_spline_surfaces_need_no_integral_whatever_their_triangles(monkeypatch):
    bent, integrated = wavy(0.0), []
    honest, exactly = Tessellation.cones, readback._volume

    def whole(shape):
        integrated.append(shape)
        return exactly(shape)

    monkeypatch.setattr(readback, "_volume", whole)
    factors = iter([1.0, 1.0, 1.0 + 1e-4] * 2)
    monkeypatch.setattr(Tessellation, "cones", lambda *args: honest(*args) * next(factors))
    assert is_same_solid(BRepBuilderAPI_Copy(bent).Shape(), bent)
    assert not integrated
    assert is_same_solid(wavy(1e-9), bent)
    assert len(integrated) == 2


def wavy(shift):
    """One wavy B-spline face, one of its control points shifted."""
    grid = np.stack(np.meshgrid(np.arange(8.0), np.arange(7.0), [1.0], indexing="ij"), axis=-1)
    controls = grid[:, :, 0] + 0.2 * np.random.default_rng(0).normal(size=(8, 7, 3))
    controls[4, 3, 2] += shift
    knots = (uniform_knots(0.0, 5.0, 5), uniform_knots(0.0, 4.0, 4))
    surface = occt.bspline_surface(BSplineSurface(*knots, controls))
    return BRepBuilderAPI_MakeFace(surface, 1e-7).Face()


@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_volume_of_triangles(shift):
    box = BRepPrimAPI_MakeBox(occt.point(np.full(3, shift)), 1.0, 2.0, 3.0).Shape()
    assert tessellate(box, 0.1).volume() == pytest.approx(6.0, rel=1e-9)
    assert tessellate(box.Reversed(), 0.1).volume() == pytest.approx(-6.0, rel=1e-9)
    lid = occt.subshapes(box, occt.FACE)[0]
    assert tessellate(lid, 0.1).volume() == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("suffix", SHAPE_SUFFIXES)
@pytest.mark.parametrize("content", [b"", b"Dear reader,\n", b"\0" * 100])
def test_content_that_is_not_of_the_format(tmp_path, suffix, content):
    path = tmp_path / f"part{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="expected a") as caught:
        read_shape(path)
    assert "\n" not in str(caught.value)


def test_wires_of_exact_curves(tmp_path):
    arc = Circle(np.array([1.0, 2, 3]), Z, X, 2.0, 0.5, 2.0)
    net = np.array([[0.0, 0, 0], [1, 2, 0], [3, 2, 1], [4, 0, 0]])
    spline = BSplineCurve(np.repeat([0.0, 1.0], 4), net)
    curves = [Line(np.zeros(3), Y, 1.0, 6.0), arc, Circle(np.zeros(3), X, Y, 1.0, 0.0, 2 * np.pi)]
    write_curves([*curves, spline], tmp_path / "edges.step", "m")
    shape = read_step(tmp_path / "edges.step")
    assert len(occt.subshapes(shape, occt.EDGE)) == 4
    lengths = sorted(diagonal(edge) for edge in occt.subshapes(shape, occt.EDGE))
    assert lengths[-1] == pytest.approx(5000.0, rel=1e-3)
    text = (tmp_path / "edges.step").read_text()
    assert "CIRCLE(" in text
    assert "B_SPLINE_CURVE" in text
    with pytest.raises(InputError, match="expected at least one edge"):
        write_curves([], tmp_path / "none.step")
