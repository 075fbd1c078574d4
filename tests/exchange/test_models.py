"""Models to every format, from shapes whose volume is known."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
import rhino3dm
import trimesh
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from crispline.cadfile import shape_files
from crispline.errors import InputError, ReconstructionError
from crispline.exchange import convert_model, write_model
from crispline.exchange.models import MODEL_SUFFIXES, SHAPE_SUFFIXES
from crispline.exchange.palette import KIND_COLOURS, kind_colour

FAR = np.array([5.0e5, 5.4e6, 300.0])


def box_with_drum(x=0.0, y=0.0, z=0.0):
    """10 x 10 x 4 with a cylinder of radius 2.5 and height 3 on top: seven planes, one cylinder."""
    box = BRepPrimAPI_MakeBox(gp_Pnt(x - 5, y - 5, z), 10.0, 10.0, 4.0).Shape()
    axes = gp_Ax2(gp_Pnt(x, y, z + 4), gp_Dir(0.0, 0.0, 1.0))
    drum = BRepPrimAPI_MakeCylinder(axes, 2.5, 3.0).Shape()
    return BRepAlgoAPI_Fuse(box, drum).Shape()


SHAPE = box_with_drum()
VOLUME = 400.0 + np.pi * 2.5**2 * 3.0


def result(shape=SHAPE, order=(3, 2, 1, 0, 4, 5, -1, 7), valid=True):
    solid = SimpleNamespace(shape=shape, face_order=order)
    return SimpleNamespace(solid=solid, valid=valid, spacing=0.5)


@pytest.mark.parametrize("suffix", sorted(set(MODEL_SUFFIXES) - {".3dm"}))
def test_the_same_model_gives_the_same_bytes(tmp_path, suffix):
    contents = []
    for _ in range(2):
        write_model(box_with_drum(), tmp_path / f"part{suffix}")
        contents.append((tmp_path / f"part{suffix}").read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
@pytest.mark.parametrize("tolerance", [0.2, 0.01])
def test_triangles_are_closed_and_within_the_tolerance(tmp_path, suffix, tolerance):
    write_model(SHAPE, tmp_path / f"part{suffix}", tolerance=tolerance)
    mesh = trimesh.load(tmp_path / f"part{suffix}", process=suffix == ".stl")
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    # Chords lie inside the drum, by no more than the tolerance.
    assert 0.0 <= VOLUME - mesh.volume <= tolerance * 2.0 * np.pi * 2.5 * 3.0
    np.testing.assert_allclose(mesh.bounds, [[-5, -5, 0], [5, 5, 7]], atol=1e-6)


def test_the_tolerance_follows_the_spacing(tmp_path):
    for name, model in (("coarse", result()), ("fine", SHAPE)):
        write_model(model, tmp_path / f"{name}.ply")
    coarse, fine = (len(trimesh.load(tmp_path / f"{n}.ply").faces) for n in ("coarse", "fine"))
    assert coarse < fine


def test_glb_is_in_metres_with_y_up_and_a_colour_for_each_kind(tmp_path):
    write_model(box_with_drum(*FAR), tmp_path / "part.glb", "cm")
    scene = trimesh.load(tmp_path / "part.glb")
    assert set(scene.geometry) == {"plane", "cylinder"}
    for kind, mesh in scene.geometry.items():
        expected = np.append(np.round(255 * np.array(kind_colour(kind))), 255)
        np.testing.assert_array_equal(mesh.visual.material.baseColorFactor, expected)
        # Near zero, where single precision has digits to spare.
        assert np.abs(mesh.vertices).max() < 10.0
    low, high = 0.01 * (FAR + np.array([[-5, -5, 0], [5, 5, 7]]))
    expected = [[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]]
    np.testing.assert_allclose(scene.bounds, expected, rtol=1e-12)
    assert scene.to_mesh().volume == pytest.approx(1e-6 * VOLUME, rel=2e-3)


def test_names_are_those_of_the_report(tmp_path):
    write_model(result(), tmp_path / "part.step")
    names = re.findall(r"ADVANCED_FACE\('([^']*)'", (tmp_path / "part.step").read_text())
    kinds = [name.split()[0] for name in names]
    numbers = [int(name.split()[1]) for name in names]
    assert numbers == [3, 2, 1, 0, 4, 5, 6, 7]
    assert kinds[6] == "patch"
    write_model(SimpleNamespace(wrapped=SHAPE, solid=lambda: None), tmp_path / "part.step")
    names = re.findall(r"ADVANCED_FACE\('([^']*)'", (tmp_path / "part.step").read_text())
    assert sorted(name.split()[0] for name in names) == ["cylinder"] + 7 * ["plane"]
    assert [int(name.split()[1]) for name in names] == list(range(8))


def test_3dm_is_a_trimmed_solid_in_its_unit(tmp_path):
    write_model(SHAPE, tmp_path / "part.3dm", "in")
    model = rhino3dm.File3dm.Read(str(tmp_path / "part.3dm"))
    assert model.Settings.ModelUnitSystem == rhino3dm.UnitSystem.Inches
    assert len(model.Objects) == 1
    solid = model.Objects[0].Geometry
    assert (solid.IsValid, solid.IsSolid, solid.IsManifold) == (True, True, True)
    assert len(solid.Faces) == 8


def test_what_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match=r"got '\.docx'"):
        write_model(SHAPE, tmp_path / "part.docx")
    for suffix in MODEL_SUFFIXES:
        with pytest.raises(InputError, match="expected a length unit"):
            write_model(SHAPE, tmp_path / f"part{suffix}", "ell")
        with pytest.raises(ReconstructionError, match="no valid model"):
            write_model(result(valid=False), tmp_path / f"part{suffix}")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rhino3dm", None)
    with pytest.raises(InputError, match=r"pip install 'crispline\[rhino\]'"):
        write_model(SHAPE, tmp_path / "part.3dm")


@pytest.mark.parametrize("source", [".step", ".igs", ".brep"])
@pytest.mark.parametrize("target", [".stp", ".iges", ".brp", ".3dm", ".stl"])
def test_conversion_keeps_numbers_and_unit(tmp_path, source, target):
    unit = "mm" if source == ".brep" else "in"
    write_model(SHAPE, tmp_path / f"part{source}", unit)
    assert convert_model(tmp_path / f"part{source}", tmp_path / f"copy{target}") == unit
    if target in SHAPE_SUFFIXES:
        found = shape_files.read_shape(tmp_path / f"copy{target}")
        assert found.unit == ("mm" if target == ".brp" else unit)
        write_model(found.shape, tmp_path / "copy.stl")
    if target != ".3dm":
        assert trimesh.load(tmp_path / "copy.stl").volume == pytest.approx(VOLUME, rel=2e-3)


def test_every_kind_of_surface_has_a_colour():
    for colour in KIND_COLOURS:
        assert len(kind_colour(colour)) == 3
    assert kind_colour("plane") != kind_colour("cylinder") != kind_colour("offset")
