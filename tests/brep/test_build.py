"""Analytic models become valid solids of the right volume, exact or with gaps."""

from dataclasses import replace

import brep_models
import numpy as np
import pytest
from brep_models import SAMPLES

from crispline import occt
from crispline.brep.build import build_shape
from crispline.brep.check import check_file, check_shape
from crispline.cadfile.step import write_step
from crispline.occt.measure import face_areas
from crispline.surface import Similarity


@pytest.mark.parametrize("name", SAMPLES)
def test_shape_is_good_and_has_the_exact_volume(name, tmp_path):
    sample = SAMPLES[name]()
    built = build_shape(sample.model)
    write_step(built.shape, tmp_path / "part.step")
    for check in (check_shape(built.shape), check_file(tmp_path / "part.step")):
        assert check.is_good
        assert check.n_solids == sample.n_solids
        assert check.n_faces == len(sample.model.faces)
        assert check.volume == pytest.approx(sample.volume, rel=5e-7)
        assert check.vertex_tolerance < 1e-4
    assert built.failures == ()
    assert sorted(built.face_order) == list(range(len(sample.model.faces)))


@pytest.mark.parametrize("amount", [0.1, 0.3])
@pytest.mark.parametrize("name", SAMPLES)
def test_tolerances_cover_the_gaps_of_a_noisy_model(name, amount):
    sample = SAMPLES[name]()
    check = check_shape(build_shape(brep_models.shaken(sample.model, amount, seed=1)).shape)
    assert check.is_good
    assert check.vertex_tolerance < 4 * amount
    assert check.volume == pytest.approx(sample.volume, rel=0.4 * amount)


def test_paper_model_gains_only_a_seam():
    sample = brep_models.box_cylinder()
    check = check_shape(build_shape(sample.model).shape)
    assert (check.n_faces, check.n_edges, check.n_vertices) == (8, 14 + 1, 8 + 2)
    assert check.vertex_tolerance < 2e-7


@pytest.mark.parametrize(
    ("name", "n_extra_edges", "n_extra_vertices"),
    [
        ("fillet", 0, 0),  # the seam of a partial cylinder lies outside the face
        ("rounded_box", 0, 0),
        ("half_elbow", 0, 0),
        ("stepped_shaft", 3, 0),  # three seams, all on one line down the shaft
        ("vase", 2, 0),
        ("half_vase", 0, 0),
        ("notched_cylinder", 2, 1),  # rulings leave all corners, so an arc is cut
        ("conical_hole", 2, 1),  # a seam to the apex, and the apex itself
        ("cone_sector", 1, 0),  # the apex is a corner already; only the edge round it
        ("sphere_topped_cylinder", 3, 1),
        ("whole_torus", 2, 1),
    ],
)
def test_seams_add_no_more_than_they_must(name, n_extra_edges, n_extra_vertices):
    model = SAMPLES[name]().model
    check = check_shape(build_shape(model).shape)
    assert check.n_edges - len(model.edges) == n_extra_edges
    assert check.n_vertices - len(model.vertices) == n_extra_vertices


def test_open_model_becomes_a_shell():
    built = build_shape(brep_models.open_box().model)
    check = check_shape(built.shape)
    assert built.shape.ShapeType() == occt.SHELL
    assert check.is_valid
    assert not check.is_closed
    assert not check.is_good
    assert check.n_solids == 0


def test_faces_are_in_the_order_that_is_told():
    model = brep_models.matryoshka().model
    built = build_shape(model)
    corners = [model.vertices[[model.edges[e].start for e, _ in f.loops[0]]] for f in model.faces]
    expected = [np.prod(np.sort(np.ptp(c, axis=0))[1:]) for c in corners]
    np.testing.assert_allclose(face_areas(built.shape), np.array(expected)[list(built.face_order)])


def test_building_twice_gives_the_same_shape():
    model = brep_models.perforated_ring().model
    texts = [occt.to_text(build_shape(model).shape) for _ in range(2)]
    assert texts[0] == texts[1]


def test_edges_that_pass_beside_their_vertex_do_not_cross():
    model = brep_models.box().model
    roof = model.faces[1]
    before, after = (model.edges[e] for e, _ in roof.loops[0][:2])
    middle = model.vertices[4:8].mean(axis=0)
    edges = list(model.edges)
    for e, _ in roof.loops[0][:2]:
        curve = edges[e].curve
        inward = middle - curve.origin
        inward -= (inward @ curve.direction) * curve.direction
        shift = Similarity(1.0, np.eye(3), 0.07 * inward / np.linalg.norm(inward))
        edges[e] = replace(edges[e], curve=curve.transformed(shift))
    check = check_shape(build_shape(replace(model, edges=tuple(edges))).shape)
    assert before.end == after.start
    assert check.is_good
    assert check.vertex_tolerance < 0.12
