"""Deliberate defects are found and named, and never called good."""

from dataclasses import replace

import brep_models
import numpy as np
import pytest

from crispline.brep import check as check_module
from crispline.brep import compose
from crispline.brep.build import build_shape
from crispline.brep.check import check_shape
from crispline.brep.compose import make_solid
from crispline.curve import Line
from crispline.gauge.deviation import sample_triangles
from crispline.occt.measure import tessellate
from crispline.surface import Similarity

UP = Similarity(1.0, np.eye(3), np.array([0.0, 0.0, 5.0]))


@pytest.fixture(autouse=True)
def _no_repairs(monkeypatch):
    monkeypatch.setattr(compose, "_HEALINGS", ())


def cloud_of(model):
    return sample_triangles(tessellate(build_shape(model).shape, 0.02), 1.0)[0]


def with_face(model, index, **changes):
    faces = list(model.faces)
    faces[index] = replace(faces[index], **changes)
    return replace(model, faces=tuple(faces))


def reversed_loops(face):
    return tuple(tuple((e, -s) for e, s in loop[::-1]) for loop in face.loops)


NAMES = ["box_cylinder", "bored_block", "conical_hole", "rounded_box", "pipe_elbow", "fillet"]


@pytest.mark.parametrize("name", NAMES)
def test_sound_model_follows_its_cloud(name):
    model = brep_models.SAMPLES[name]().model
    solid = make_solid(model, cloud_of(model), 1.0)
    assert solid.check.is_good
    assert solid.attempt == "as built"
    assert solid.check.face_distances.max() < 2.0


@pytest.mark.parametrize("name", NAMES)
def test_missing_face(name):
    model = brep_models.SAMPLES[name]().model
    check = make_solid(replace(model, faces=model.faces[:-1]), cloud_of(model), 1.0).check
    assert not check.is_closed
    assert not check.is_good
    assert check.n_uncovered > 0


@pytest.mark.parametrize("name", NAMES)
def test_every_swapped_orientation(name):
    model = brep_models.SAMPLES[name]().model
    cloud = cloud_of(model)
    for index in range(0, len(model.faces), 1 + len(model.faces) // 3):
        face = model.faces[index]
        turned = [
            {"orientation": -face.orientation},
            {"loops": reversed_loops(face)},
            {"orientation": -face.orientation, "loops": reversed_loops(face)},
        ]
        for changes in turned:
            check = make_solid(with_face(model, index, **changes), cloud, 1.0).check
            assert not check.is_good, (index, changes)
            assert check.bad_faces or check.problems


def test_infinite_face_is_named():
    model = brep_models.bored_block().model
    check = make_solid(with_face(model, 6, orientation=1), None, 1.0).check
    assert [(bad.index, bad.reason) for bad in check.bad_faces] == [
        (6, "the loops bound an infinite part of the surface")
    ]


def test_dropped_hole():
    model = brep_models.bored_block().model
    broken = with_face(model, 1, loops=model.faces[1].loops[:1])
    assert not make_solid(broken, cloud_of(model), 1.0).check.is_good


@pytest.mark.parametrize("name", NAMES)
def test_edge_far_off_its_surfaces(name):
    model = brep_models.SAMPLES[name]().model
    edge = model.edges[0]
    far = replace(edge, curve=edge.curve.transformed(UP))
    check = make_solid(replace(model, edges=(far, *model.edges[1:])), None, 1.0).check
    assert not check.is_good
    assert {bad.index for bad in check.bad_faces} & {edge.left, edge.right}
    assert any("misses the surface" in bad.reason for bad in check.bad_faces)


def test_shifted_surface():
    model = brep_models.box().model
    moved = model.faces[1].surface.transformed(UP)
    check = make_solid(with_face(model, 1, surface=moved), None, 1.0).check
    assert 1 in {bad.index for bad in check.bad_faces}


def test_gap_in_a_loop():
    model = brep_models.box().model
    check = make_solid(with_face(model, 1, loops=(model.faces[1].loops[0][:3],)), None, 1.0).check
    assert not check.is_good


def test_self_crossing_border_is_named():
    model = brep_models.box().model
    v, loop = model.vertices.copy(), model.faces[1].loops[0]
    a, b = model.edges[loop[0][0]], model.edges[loop[2][0]]
    v[[a.start, a.end]] = v[[a.end, a.start]]
    edges = tuple(replace(e, curve=line_between(v[e.start], v[e.end])) for e in model.edges)
    check = make_solid(replace(model, vertices=v, edges=edges), None, 1.0).check
    assert not check.is_valid
    assert "BRepCheck_SelfIntersectingWire" in {bad.reason for bad in check.bad_faces}
    assert b.start != a.start


def line_between(start, end):
    length = float(np.linalg.norm(end - start))
    return Line(start, (end - start) / length, 0.0, length)


def test_only_the_face_that_cannot_be_filled_is_at_fault(monkeypatch):
    model = brep_models.box().model
    cloud, filled = cloud_of(model), check_module.tessellate

    def tessellate_all_but_one(shape, deflection):
        mesh = filled(shape, deflection)
        kept = mesh.faces != 1
        return replace(mesh, triangles=mesh.triangles[kept], faces=mesh.faces[kept])

    monkeypatch.setattr(check_module, "tessellate", tessellate_all_but_one)
    check = check_shape(build_shape(model).shape, cloud, 1.0)
    assert check.n_uncovered > 100
    assert [(bad.index, bad.reason) for bad in check.bad_faces] == [(1, check_module.UNMESHED)]


def test_face_that_strays_from_the_cloud_is_named():
    model = brep_models.box_cylinder().model
    cloud = cloud_of(model)
    no_roof = cloud[cloud[:, 2] < 49.0]
    check = make_solid(model, no_roof, 1.0).check
    assert not check.is_good
    assert [bad.index for bad in check.bad_faces] == [7]
    assert "spacings from the cloud" in check.bad_faces[0].reason
    assert check.face_distances[7] > check_module.STRAY


def test_uncovered_cloud_counts_but_lone_outliers_do_not():
    model = brep_models.box().model
    cloud = cloud_of(model)
    outliers = np.random.default_rng(0).uniform(-40, 100, (200, 3))
    assert make_solid(model, np.vstack([cloud, outliers]), 1.0).check.is_good
    boss = np.random.default_rng(0).uniform(0, 8, (200, 3)) + np.array([20, 20, 34])
    check = make_solid(model, np.vstack([cloud, boss]), 1.0).check
    assert not check.is_good
    assert check.n_uncovered > 100


def test_inside_out_solid_is_reported():
    shape = build_shape(brep_models.box().model).shape.Reversed()
    check = check_shape(shape)
    assert not check.is_good
    assert "inside out" in check.problems[0]


def test_a_face_that_one_of_two_meshes_does_not_fill_is_found():
    shape = build_shape(brep_models.box().model).shape
    whole = tessellate(shape, 0.01)
    kept = whole.faces != 2
    partial = replace(whole, triangles=whole.triangles[kept], faces=whole.faces[kept])
    assert check_module._vanishes([whole, whole], 6).tolist() == [False] * 6
    assert np.flatnonzero(check_module._vanishes([whole, partial], 6)).tolist() == [2]
