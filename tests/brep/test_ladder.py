"""Trimmed faces, patches where a region fails, patches only: every rung is a valid solid."""

import itertools
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from crispline import features, occt
from crispline.brep import ladder as ladder_module
from crispline.brep.check import BadFace, check_shape
from crispline.brep.compose import make_solid
from crispline.brep.ladder import _reasons
from crispline.curve import Line
from crispline.features import located_features
from crispline.model import Face, Model
from crispline.net.halfedge import half_edges
from crispline.net.quads import QuadNet
from crispline.options import Options
from crispline.region.fitting import held_fit
from crispline.region.segment import segment
from crispline.region.topology import border_topology
from crispline.shapes import SHAPES, sample
from crispline.sharp.patched import LabelledNet, has_sides, patched
from crispline.stopwatch import Stopwatch
from crispline.surface import Similarity, Sphere

VOLUME = 70.0**3 + np.pi * 25.0**2 * 29.0
MAX_MOVE = 1.5


@cache
def ladder():
    """What the models of a scan of the box with cylinder are made from."""
    cloud = sample(SHAPES["box-cylinder"](), 3000, noise=0.01, seed=1)
    return located_features(cloud.points, Options(), Stopwatch()).ladder


def away(face):
    """The face with its surface five spacings from its points."""
    _, normal = face.surface.project(face.points[:1])
    shift = Similarity(1.0, np.eye(3), 5.0 * normal[0])
    return replace(face, surface=face.surface.transformed(shift))


def spoiled(regions):
    """The same with the surfaces of some regions far from the points."""
    source = ladder()
    faces = tuple(away(face) if face.region in regions else face for face in source.model.faces)
    return replace(source, model=replace(source.model, faces=faces))


def region_of(kind):
    """Label of a face with the number of loops and edges that tells its kind."""
    sizes = {"square": [4], "ring": [1, 4], "disc": [1], "cylinder": [1, 1]}
    return next(
        face.region
        for face in ladder().model.faces
        if sorted(len(loop) for loop in face.loops) == sizes[kind]
    )


@pytest.mark.parametrize("kind", ["square", "ring", "disc", "cylinder"])
def test_any_region_can_be_patches(kind):
    source = ladder()
    region = region_of(kind)
    model = patched(source.model, source.source, [region], MAX_MOVE)
    assert {face.region for face in model.faces if face.is_patch} == {region}
    assert {face.region for face in model.faces if not face.is_patch} == set(range(8)) - {region}
    solid = make_solid(model.transformed(source.to_user), source.points, source.spacing)
    assert solid.check.is_good, solid.check
    assert solid.attempt == "as built"
    assert solid.check.volume == pytest.approx(VOLUME, rel=3e-3)
    assert solid.check.edge_tolerance < 0.2 * source.spacing


def test_neighbours_keep_the_edge_between_them_as_a_crease():
    source = ladder()
    pair = next((edge.left, edge.right) for edge in source.model.edges if edge.curve.kind == "line")
    regions = [source.model.faces[side].region for side in pair]
    model = patched(source.model, source.source, regions, MAX_MOVE)
    assert any(
        edge.is_sharp and model.faces[edge.left].is_patch and model.faces[edge.right].is_patch
        for edge in model.edges
    )
    solid = make_solid(model.transformed(source.to_user), source.points, source.spacing)
    assert solid.check.is_good
    assert solid.check.volume == pytest.approx(VOLUME, rel=3e-3)


def test_a_good_model_stays_trimmed():
    made = ladder().climb("auto")
    assert made.solid.representation == "trimmed"
    assert made.solid.check.is_good
    assert made.warnings == ()


def test_a_face_that_fails_becomes_patches():
    disc = region_of("disc")
    made = spoiled([disc]).climb("auto")
    assert made.solid.representation == "mixed"
    assert made.solid.check.is_good
    assert any(f"region {disc} near" in warning for warning in made.warnings)
    assert made.solid.check.volume == pytest.approx(VOLUME, rel=3e-3)


def test_where_most_faces_fail_the_model_is_patches():
    source = spoiled(range(8))
    made = source.climb("auto")
    assert made.solid.representation == "patches"
    assert made.solid.check.is_good
    assert set(made.solid.face_order) == {-1}
    assert made.solid.check.volume == pytest.approx(VOLUME, rel=3e-3)
    assert "patches only" in made.warnings[0]
    checked = check_shape(made.solid.shape, source.points, source.spacing)
    assert checked.is_good
    assert checked.volume == pytest.approx(made.solid.check.volume, rel=1e-6)


@pytest.mark.parametrize(("has_faces", "kind"), [(True, "trimmed"), (False, "patches")])
def test_without_faces_to_trim_patches_come_first(has_faces, kind):
    made = replace(ladder(), has_faces=has_faces).climb("auto")
    assert made.solid.check.is_good
    assert made.solid.representation == kind
    assert any("no surfaces explain" in warning for warning in made.warnings) != has_faces


def test_one_rung_can_be_asked_for():
    failed = spoiled([2]).climb("trimmed")
    assert failed.solid.representation == "trimmed"
    assert not failed.solid.check.is_good
    assert set(_reasons(ladder().model, failed.solid)) >= {2}
    patches = ladder().climb("patches")
    assert patches.solid.representation == "patches"
    assert patches.solid.check.is_good


def test_patches_that_the_edges_spoil_are_smooth():
    source = ladder()
    vertices = source.net.vertices.copy()
    vertices[source.net.creases[0]] += 9.0
    spoilt = replace(source, net=replace(source.net, vertices=vertices))
    attempt = spoilt.climb("patches")
    assert attempt.solid.check.is_good
    assert "smooth everywhere" in attempt.warnings[0]
    assert attempt.solid.check.volume == pytest.approx(VOLUME, rel=0.03)


def test_patches_that_miss_the_cloud_are_no_success():
    source = ladder()
    elsewhere = replace(source, points=source.points + 6.0 * source.spacing)
    assert not elsewhere.climb("patches").solid.check.is_good


def test_a_closed_piece_without_borders_can_be_patches(nets):
    vertices, quads = nets.sphere(6, 5.0)
    label = np.zeros(len(quads), dtype=np.int64)
    topology = border_topology(half_edges(quads, len(vertices)), label)
    sphere = Face(Sphere(np.zeros(3), 5.0), 1, (), np.zeros((0, 3)), np.zeros(0), 0)
    model = Model(np.zeros((0, 3)), np.zeros(0), (), (sphere,))
    source = LabelledNet(QuadNet(vertices, quads), label, topology)
    solid = make_solid(patched(model, source, [0], MAX_MOVE), None, 1.0)
    assert solid.check.is_good
    assert solid.check.volume == pytest.approx(4.0 / 3.0 * np.pi * 125.0, rel=5e-3)


def test_what_occt_refuses_to_build_is_a_rung_that_fails(monkeypatch):
    def refusing(*_, **__):
        occt.curve_to_occt(Line(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0, 1.0))

    monkeypatch.setattr(ladder_module, "make_solid", refusing)
    made = ladder().climb("auto")
    assert made.solid.representation == "patches"
    assert made.solid.check.is_good


def octahedron_points():
    """A scan of an octahedron."""
    rng = np.random.default_rng(0)
    signs = np.array(list(itertools.product((-10.0, 10.0), repeat=3)))
    weights = rng.dirichlet(np.ones(3), 3000)
    return signs[rng.integers(0, 8, 3000)] * weights + rng.normal(0.0, 0.02, (3000, 3))


@cache
def octahedron():
    """What the models of it are made from: four faces meet in a corner."""
    return located_features(octahedron_points(), Options(), Stopwatch())


def test_a_region_beside_a_collapsed_border_can_be_patches():
    found = octahedron()
    collapsed = [text for text in found.ladder.doubts if "became one corner" in text]
    assert collapsed
    regions = [int(name) for name in re.search(r"regions (\d+), (\d+)", collapsed[0]).groups()]
    source = found.ladder
    assert len(source.model.vertices) == 6
    for region in regions:
        assert not has_sides(source.source, [region])
        model = patched(*source._beside([region]), [region], MAX_MOVE)
        assert {face.region for face in model.faces if face.is_patch} == {region}
        solid = make_solid(model.transformed(source.to_user), source.points, source.spacing)
        assert solid.check.is_good, solid.check
        assert solid.check.volume == pytest.approx(4000.0 / 3.0, rel=0.01)
        assert solid.check.edge_tolerance < 0.3 * source.spacing


def ladder_with_failing_crumb(monkeypatch, crumb):
    """Of the octahedron with a crumb in its first face, which no model has a valid face for."""

    def with_crumb(evidence, *rest):
        found = segment(evidence, *rest)
        assert len(found.fits) == crumb
        middle = np.median(evidence.graph.points[found.label == 0], axis=0)
        is_crumb = np.linalg.norm(evidence.graph.points - middle, axis=1) < 3.0
        fit = held_fit(found.fits[0].surface, np.flatnonzero(is_crumb), evidence)
        label = np.where(is_crumb, crumb, found.label)
        return replace(found, label=label, fits={**found.fits, crumb: fit})

    def failing(model, *rest, **limits):
        solid = make_solid(model, *rest, **limits)
        bad = [BadFace(i, "it fails") for i, face in enumerate(model.faces) if face.region == crumb]
        return replace(solid, check=replace(solid.check, bad_faces=tuple(bad)))

    monkeypatch.setattr(features, "segment", with_crumb)
    monkeypatch.setattr(ladder_module, "make_solid", failing)
    source = located_features(octahedron_points(), Options(), Stopwatch()).ladder
    assert crumb in source.source.label
    return source


def test_a_crumb_that_fails_goes_to_its_neighbours(monkeypatch):
    crumb = 8
    source = ladder_with_failing_crumb(monkeypatch, crumb)
    made = source.climb("trimmed")
    assert made.solid.check.is_good
    assert sorted(face.region for face in made.model.faces) == list(range(crumb))
    assert [text for text in made.warnings if "region 8" in text and "its neighbours" in text]
    # No neighbour explains a face of the part.
    assert source.without([0, 1, 2]) is None


def test_a_crumb_that_spoils_the_face_round_it_goes_to_its_neighbours(monkeypatch):
    crumb = 8
    source = ladder_with_failing_crumb(monkeypatch, crumb)

    def failing(model, *rest, **limits):
        """Not the crumb, but the face round it."""
        solid = make_solid(model, *rest, **limits)
        names = [face.region for face in model.faces]
        bad = [BadFace(names.index(0), "it fails")] if crumb in names else []
        return replace(solid, check=replace(solid.check, bad_faces=tuple(bad)))

    monkeypatch.setattr(ladder_module, "make_solid", failing)
    made = source.climb("auto")
    assert made.solid.check.is_good
    assert made.solid.representation == "trimmed"
    assert sorted(face.region for face in made.model.faces) == list(range(crumb))
    assert [text for text in made.warnings if "region 8" in text and "a face beside it" in text]


def test_a_narrow_region_that_fails_goes_even_if_it_is_of_use(monkeypatch):
    crumb = 8
    monkeypatch.setattr(features, "without_regions", lambda *_: None)
    made = ladder_with_failing_crumb(monkeypatch, crumb).climb("auto")
    assert made.solid.check.is_good
    assert made.solid.representation == "trimmed"
    assert sorted(face.region for face in made.model.faces) == list(range(crumb))
    assert [text for text in made.warnings if "region 8" in text and "spacings wide" in text]


def test_a_narrow_region_is_not_given_up_for_nothing(monkeypatch):
    crumb = 8
    monkeypatch.setattr(features, "without_regions", lambda *_: None)
    source = ladder_with_failing_crumb(monkeypatch, crumb)

    def failing(model, *rest, **limits):
        """The crumb while it is trimmed; without it the face round it."""
        solid = make_solid(model, *rest, **limits)
        faces = [(i, face.region) for i, face in enumerate(model.faces) if not face.is_patch]
        is_whole = len(faces) == len(model.faces)
        wanted = crumb if crumb in dict(faces).values() else 0 if is_whole else None
        bad = [BadFace(i, "it fails") for i, region in faces if region == wanted]
        return replace(solid, check=replace(solid.check, bad_faces=tuple(bad)))

    monkeypatch.setattr(ladder_module, "make_solid", failing)
    made = source.climb("auto")
    assert made.solid.representation == "mixed"
    assert {face.region for face in made.model.faces if face.is_patch} == {crumb}
    assert not [text for text in made.warnings if "given to its neighbours" in text]


def test_a_narrow_region_stays_where_a_gap_would_open_without_it(monkeypatch):
    crumb = 8
    monkeypatch.setattr(features, "without_regions", lambda *_: None)
    source = ladder_with_failing_crumb(monkeypatch, crumb)

    def without_narrow(labels):
        fewer = source.without_narrow(labels)
        gaps = np.full(len(fewer.model.vertices), 0.5)
        return replace(fewer, model=replace(fewer.model, vertex_gaps=gaps))

    made = replace(source, without_narrow=without_narrow).climb("auto")
    assert made.solid.representation != "trimmed"
    assert not [text for text in made.warnings if "given to its neighbours" in text]


def around_a_corner():
    """A corner of the box and the regions that meet there."""
    model = ladder().model
    corner = next(edge.start for edge in model.edges if edge.curve.kind == "line")
    sides = {
        side
        for edge in model.edges
        if corner in (edge.start, edge.end)
        for side in (edge.left, edge.right)
    }
    return corner, sorted(model.faces[side].region for side in sides)


def test_patches_leave_the_gap_of_a_corner_behind():
    source = ladder()
    corner, regions = around_a_corner()
    gaps = np.full(len(source.model.vertices), 5.0)
    model = replace(source.model, vertex_gaps=gaps)
    assert patched(model, source.source, regions, MAX_MOVE).vertex_gaps[corner] == 0.0
    # A trimmed face that is left there has the gap that it really has.
    assert patched(model, source.source, regions[:1], MAX_MOVE).vertex_gaps[corner] < 0.01


def test_a_corner_located_badly_does_not_bend_patches():
    source = ladder()
    corner, regions = around_a_corner()
    vertices = source.model.vertices.copy()
    place = vertices[corner].copy()
    vertices[corner] += 6.0
    model = replace(source.model, vertices=vertices)
    mixed = patched(model, source.source, regions, MAX_MOVE)
    assert np.linalg.norm(mixed.vertices[corner] - place) < MAX_MOVE
    # Where two trimmed faces meet there, all go to where their edge ends.
    held = patched(model, source.source, regions[:1], MAX_MOVE)
    assert np.array_equal(held.vertices[corner], vertices[corner])


def test_faces_that_fail_one_after_the_other_become_patches(monkeypatch):
    failing = [region_of(kind) for kind in ("disc", "cylinder", "ring")]

    def make(model, *args, **kwargs):
        solid = make_solid(model, *args, **kwargs)
        left = {face.region: i for i, face in enumerate(model.faces) if not face.is_patch}
        still = [left[region] for region in failing if region in left][:1]
        bad = tuple(BadFace(index, "as told") for index in still)
        return replace(solid, check=replace(solid.check, bad_faces=bad))

    monkeypatch.setattr(ladder_module, "make_solid", make)
    made = ladder().climb("auto")
    assert made.solid.representation == "mixed"
    assert sum("as told" in warning for warning in made.warnings) == len(failing)
