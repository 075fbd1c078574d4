"""Repairs, and independence of unit and place."""

import time
from dataclasses import replace

import brep_models
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crispline import occt
from crispline.brep import check, compose
from crispline.brep.build import build_shape
from crispline.brep.check import check_file, check_shape
from crispline.brep.compose import make_solid
from crispline.brep.heal import heal
from crispline.cadfile import step
from crispline.cadfile.step import faces_lost_in_step, write_step
from crispline.curve import Line
from crispline.errors import ReconstructionError
from crispline.occt.measure import tessellate
from crispline.surface import Similarity

ROTATION = Rotation.from_rotvec([0.3, 0.5, -0.2]).as_matrix()


@pytest.mark.parametrize(
    ("scale", "shift"),
    [(1.0, 0.0), (1e-3, 0.0), (1e3, 0.0), (1.0, 1e6), (1e-3, 1e3), (0.0254, 1e6)],
)
@pytest.mark.parametrize(
    "name", ["box_cylinder", "two_boxes", "conical_hole", "stepped_shaft", "spline_top"]
)
def test_unit_and_place_do_not_matter(name, scale, shift, tmp_path):
    sample = brep_models.SAMPLES[name]()
    moved = sample.model.transformed(Similarity(scale, ROTATION, np.full(3, shift)))
    solid = make_solid(moved, None, scale)
    write_step(solid.shape, tmp_path / "part.step")
    for found in (solid.check, check_file(tmp_path / "part.step", None, scale)):
        assert found.is_good
        assert found.n_faces == len(sample.model.faces)
        assert found.volume == pytest.approx(sample.volume * scale**3, rel=1e-6)


@pytest.mark.parametrize("scale", [1e-3, 25.4])
def test_model_with_gaps_stays_valid_in_other_units(scale, tmp_path):
    model = brep_models.shaken(brep_models.box_cylinder().model, 0.1, seed=2)
    solid = make_solid(model.transformed(Similarity(scale, ROTATION, np.zeros(3))), None, scale)
    write_step(solid.shape, tmp_path / "part.step")
    assert solid.check.is_good
    assert solid.check.vertex_tolerance < 0.4 * scale
    assert check_file(tmp_path / "part.step", None, scale).is_good


def turned_roof():
    model = brep_models.box().model
    face = model.faces[1]
    faces = (model.faces[0], replace(face, orientation=-face.orientation), *model.faces[2:])
    return replace(model, faces=faces)


def test_repair_is_tried_told_and_checked():
    solid = make_solid(turned_roof(), None, 1.0)
    assert solid.attempt == "healed to 0.1 spacings"
    assert solid.check.is_good
    assert solid.check.volume == pytest.approx(60 * 40 * 30)


def test_a_repair_that_loses_the_numbers_of_the_faces_is_dropped(monkeypatch):
    lone = occt.subshapes(build_shape(brep_models.box().model).shape, occt.FACE)[0]
    monkeypatch.setattr(compose, "heal", lambda *_: lone)  # valid, and far from the points
    solid = make_solid(turned_roof(), np.full((50, 3), 1e3), 1.0)
    assert solid.attempt == "as built"
    assert min(fault.index for fault in solid.check.bad_faces) >= 0


def test_a_crossed_wire_is_built_again_with_the_cusps_of_its_face_opened(monkeypatch):
    asked = []

    def judged(shape, *rest):
        found = check_shape(shape, *rest)
        return found if asked else replace(found, bad_faces=(crossed,))

    def opened(model, faces):
        asked.append(list(faces))
        return model

    crossed = check.BadFace(2, "BRepCheck_SelfIntersectingWire")
    monkeypatch.setattr(compose, "check_shape", judged)
    monkeypatch.setattr(compose, "with_cusps_opened", opened)
    solid = make_solid(brep_models.box().model, None, 1.0, time_limit=0.0)
    assert (solid.attempt, solid.check.is_good) == ("cusps opened", True)
    assert asked == [[build_shape(brep_models.box().model).face_order[2]]]


def test_without_time_the_faulty_shape_is_returned_as_faulty():
    solid = make_solid(turned_roof(), None, 1.0, time_limit=0.0)
    assert solid.attempt == "as built"
    assert not solid.check.is_valid


def test_the_time_limit_is_for_repairs_alone(monkeypatch):
    given = []

    def slow(*arguments):
        time.sleep(0.3)
        return check_shape(*arguments)

    monkeypatch.setattr(compose, "check_shape", slow)
    monkeypatch.setattr(compose, "heal", lambda shape, gap, limit, drop: given.append(limit))
    make_solid(turned_roof(), None, 1.0, time_limit=1.0)
    assert given[0] > 0.9


def test_a_faulty_shape_is_meshed_coarsely_only(monkeypatch):
    tried = []

    def spied(shape, deflection):
        tried.append(deflection)
        return tessellate(shape, deflection)

    monkeypatch.setattr(check, "tessellate", spied)
    check_shape(build_shape(turned_roof()).shape)
    assert len(tried) == 1
    check_shape(build_shape(brep_models.box().model).shape)
    assert len(tried) == 3


def test_healing_stops_at_its_time_limit():
    shape = build_shape(turned_roof()).shape
    start = time.monotonic()
    assert heal(shape, 0.1, time_limit=0.05) is None
    assert time.monotonic() - start < 5.0


def test_healing_leaves_its_input_alone():
    shape = build_shape(turned_roof()).shape
    before = occt.to_text(shape)
    healed = heal(shape, 0.1, time_limit=60.0, drop_pcurves=True)
    assert check_shape(healed).is_good
    assert occt.to_text(shape) == before


def test_edge_without_geometry_is_refused_by_name():
    model = brep_models.box().model
    edge = model.edges[0]
    void = replace(edge, curve=Line(edge.curve.origin, np.zeros(3), 0.0, 1.0))
    with pytest.raises(ReconstructionError, match="line between faces"):
        make_solid(replace(model, edges=(void, *model.edges[1:])), None, 1.0)


def test_bad_faces_are_told_in_the_numbers_of_the_model():
    model = brep_models.box_with_void().model
    face = model.faces[8]
    moved = face.surface.transformed(Similarity(1.0, np.eye(3), 5.0 * face.surface.normal))
    faces = tuple(replace(f, surface=moved) if i == 8 else f for i, f in enumerate(model.faces))
    solid = make_solid(replace(model, faces=faces), None, 1.0, time_limit=0.0)
    assert 8 in {bad.index for bad in solid.check.bad_faces}
    assert all(bad.index >= 6 for bad in solid.check.bad_faces)


def test_faces_with_large_gaps_are_asked_for_in_a_file(monkeypatch):
    # A corner of a housing, valid in memory, crossed itself once it had been written.
    asked = []

    def spoilt(shape):
        asked.append(shape)
        return (2,)

    monkeypatch.setattr(compose, "faces_lost_in_step", spoilt)
    tight = make_solid(brep_models.box_cylinder().model, None, 1.0)
    assert tight.check.is_good
    assert not asked
    loose = make_solid(brep_models.shaken(brep_models.box().model, 0.5, seed=2), None, 1.0)
    assert loose.check.vertex_tolerance > compose.LOOSE
    assert [fault.reason for fault in loose.check.bad_faces] == [compose.SPOILT]
    assert loose.attempt == "as built"  # no repair can tell
    assert len(asked) == 1


def test_a_sound_shape_loses_no_face_in_a_file():
    shape = build_shape(brep_models.shaken(brep_models.box().model, 0.5, seed=2)).shape
    assert faces_lost_in_step(shape) == ()


@pytest.mark.parametrize("copy", [None, "turned"])
def test_a_shape_that_is_another_in_a_file_names_a_face(monkeypatch, copy):
    read = None if copy is None else build_shape(turned_roof()).shape
    monkeypatch.setattr(step, "_read", lambda content: read)
    assert faces_lost_in_step(build_shape(brep_models.box().model).shape)
