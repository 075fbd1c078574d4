"""What a result reports: a box built by hand, in the user's units."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

from crispline.brep.check import BadFace
from crispline.brep.compose import make_solid
from crispline.curve import Circle, Line
from crispline.errors import ReconstructionError
from crispline.model import Edge, Face, Model
from crispline.net.halfedge import half_edges
from crispline.region.topology import border_topology
from crispline.result import Reconstruction, failure
from crispline.spline.creased import CreasedNet
from crispline.stopwatch import Stopwatch
from crispline.surface import Plane

HALF = 10.0


def box_model(nets):
    """A cube of side 20 with 50 points on every face, 0.1 off by turns."""
    vertices, quads, side = nets.box(2, half=HALF)
    topology = border_topology(half_edges(quads, len(vertices)), side)
    used = sorted({int(chain.vertices[end]) for chain in topology.chains for end in (0, -1)})
    edges = []
    for chain in topology.chains:
        a, b = vertices[chain.vertices[0]], vertices[chain.vertices[-1]]
        line = Line(a, (b - a) / (2 * HALF), 0.0, 2 * HALF)
        ends = used.index(chain.vertices[0]), used.index(chain.vertices[-1])
        edges.append(Edge(line, *ends, chain.left, chain.right, 1e-9, np.pi / 2, True))
    faces = []
    for k in range(6):
        normal = np.eye(3)[k // 2] * (1.0 if k % 2 else -1.0)
        surface, off = Plane(HALF * normal, normal), 0.1 * (-1.0) ** np.arange(50)
        points = np.random.default_rng(k).uniform(-HALF, HALF, (50, 3))
        points = surface.project(points)[0] + off[:, None] * normal
        faces.append(Face(surface, 1, topology.loops[k], points, off, k))
    return Model(vertices[used], np.zeros(8), tuple(edges), tuple(faces))


@pytest.fixture
def result(nets):
    model = box_model(nets)
    empty = np.zeros((0, 2), dtype=np.int64)
    patches = CreasedNet(np.zeros((0, 3)), np.zeros((0, 4), dtype=np.int64), empty, empty[:, 0])
    cloud = np.concatenate([face.points for face in model.faces])
    return Reconstruction(model, patches, 2.0, 0.1, make_solid(model, cloud, 2.0))


def test_faces_have_residuals_and_areas(result):
    assert result.valid
    assert result.closed
    for face in result.faces:
        assert (face.kind, face.n_points) == ("plane", 50)
        assert face.area == pytest.approx(400.0)
        assert (face.rms, face.p95, face.max) == pytest.approx((0.1, 0.1, 0.1))
        assert face.mean == pytest.approx(0.0, abs=1e-12)


def test_edges_have_lengths_and_angles(result):
    assert len(result.edges) == 12
    for edge in result.edges:
        assert (edge.kind, edge.is_sharp) == ("line", True)
        assert edge.length == pytest.approx(20.0)
        assert edge.angle_deg == pytest.approx(90.0)
        assert edge.points.shape == (2, 3)
    np.testing.assert_allclose(np.abs(result.corners), HALF)
    assert result.corners.shape == (8, 3)


def test_a_closed_edge_ends_where_it_starts(result):
    circle = Circle(np.zeros(3), np.eye(3)[2], np.eye(3)[0], 5.0, 0.0, 2 * np.pi)
    model = Model(
        np.array([[5.0, 0.0, 0.0]]), np.zeros(1),
        (Edge(circle, 0, 0, 0, 1, 0.0, 1.0, True),), (),
    )  # fmt: skip
    (edge,) = replace(result, model=model, solid=None).edges
    np.testing.assert_array_equal(edge.points[0], edge.points[-1])
    assert edge.length == pytest.approx(10 * np.pi, rel=1e-3)
    # Its seam vertex is not a corner: the edge runs through it without a turn.
    assert replace(result, model=model, solid=None).corners.shape == (0, 3)


def test_a_corner_needs_three_sharp_edges_or_two_that_turn(result):
    edges = list(result.model.edges)
    at_first = [k for k, e in enumerate(edges) if 0 in (e.start, e.end)]
    assert len(at_first) == 3
    for n_smooth, is_corner in ((1, True), (2, False), (3, False)):
        changed = [replace(e, is_sharp=k not in at_first[:n_smooth]) for k, e in enumerate(edges)]
        corners = replace(result, model=replace(result.model, edges=tuple(changed))).corners
        hit = (np.abs(corners - result.model.vertices[0]).max(axis=1) < 1e-9).any()
        assert hit == is_corner


def test_summary_is_json_with_the_promised_fields(result):
    content = json.loads(json.dumps(result.summary(), allow_nan=False))
    promised = "valid closed n_faces faces edges corners noise spacing timings warnings"
    assert set(promised.split()) <= set(content)
    assert (content["n_faces"], content["n_sharp_edges"]) == (6, 12)
    assert content["volume"] == pytest.approx(8000.0)
    assert content["largest_tolerance"] < 1e-4


def test_without_a_solid_the_rest_is_still_there(tmp_path, result):
    bare = replace(result, solid=None)
    assert not bare.valid
    assert not bare.closed
    content = json.loads(json.dumps(bare.summary(), allow_nan=False))
    assert content["faces"][0]["area"] is None
    assert content["volume"] is None
    with pytest.raises(ReconstructionError, match="no valid model to write") as caught:
        bare.write(tmp_path / "part.step")
    assert caught.value.partial is bare
    assert list(tmp_path.iterdir()) == []
    assert failure(bare) == "no solid was built"


def test_failure_names_the_faces_their_places_and_the_reasons(result):
    faults = (BadFace(1, "it cannot be triangulated"), BadFace(1, "7.0 spacings from the cloud"))
    faults += tuple(BadFace(k, "a fault") for k in (2, 3, 4, 5))
    check = replace(
        result.solid.check, bad_faces=faults, is_closed=False, n_uncovered=12, problems=("a leak",)
    )
    bad = replace(result, solid=replace(result.solid, check=check))
    message = failure(bad)
    assert "face 1 near (10, " in message
    assert "it cannot be triangulated, 7.0 spacings from the cloud" in message
    assert "2 more faces; a leak; the shell has free edges; 12 points lie off" in message
    assert message.endswith("scan these places more densely")
    assert not bad.valid
    stray = replace(check, is_closed=True, problems=())
    content = replace(result, solid=replace(result.solid, check=stray)).summary()
    assert (content["valid"], content["closed"]) == (False, True)


def test_a_certificate_holds_the_whole_cloud_against_the_shape_as_written(result):
    stream = np.random.default_rng(0)
    on_top = np.column_stack([stream.uniform(-9.0, 9.0, (300, 2)), np.full(300, HALF)])
    on_side = on_top[:, [2, 0, 1]] + [0.3, 0.0, 0.0]
    sunk = on_top[:5, [1, 2, 0]] * [0.5, 0.8, 0.5]  # too few to be held against their face
    certified = result.certified(np.vstack([on_top, on_side, sunk]), noise=0.05)
    by_face = {tuple(np.round(f.parameters["normal"])): f for f in certified.faces}
    top, side, back = (by_face[normal] for normal in ((0, 0, 1), (1, 0, 0), (0, 1, 0)))
    assert (top.n_points, side.n_points, back.n_points) == (300, 300, 5)
    assert (top.rms, top.explained) == (pytest.approx(0.0, abs=1e-9), 1.0)
    assert [side.rms, side.p95, side.max, side.mean] == pytest.approx([0.3] * 4)
    assert (back.mean, side.explained) == (pytest.approx(-2.0), 0.0)
    assert by_face[(-1, 0, 0)].n_points == 0
    content = json.loads(json.dumps(certified.summary(), allow_nan=False))
    assert content["residuals"]["explained"] == pytest.approx(300 / 605)
    assert sorted(face["n_points"] for face in content["faces"]) == [0, 0, 0, 5, 300, 300]
    name = f"face {certified.faces.index(side)} (plane)"
    assert certified.verdict.startswith("explains 49.6 % of the points within 3 sigma (0.15); p95")
    assert f"worst {name}: p95 0.3 (" in certified.verdict
    certified.require(0.31)
    with pytest.raises(ReconstructionError, match=re.escape(f"points of {name} lie within 0.3 ")):
        certified.require(0.29)


def test_nothing_is_certified_without_a_model(result):
    bare = replace(result, solid=None)
    assert bare.verdict == "not measured: no valid model was built"
    with pytest.raises(ReconstructionError, match="no valid model"):
        bare.require(1.0)
    with pytest.raises(ReconstructionError, match="no solid was built"):
        bare.deviations(np.zeros((1, 3)))


def test_deviations_and_mesh_are_in_the_unit_of_the_user(result):
    found = result.deviations(np.array([[0.0, 0.0, HALF + 1.0], [HALF - 0.5, 0.0, 0.0]]))
    assert found.distance == pytest.approx([1.0, -0.5])
    mesh = result.to_mesh(0.1)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(8000.0)
    assert np.unique(mesh.face_attributes["face"]).tolist() == list(range(6))


def test_stopwatch_times_stages_and_tells_progress():
    told = []
    watch = Stopwatch(lambda name, share: told.append((name, share)))
    watch.stage("one", 0.0)
    watch.stage("two", 0.5)
    timings = watch.stop()
    assert told == [("one", 0.0), ("two", 0.5), ("done", 1.0)]
    assert list(timings) == ["one", "two"]
    assert all(seconds >= 0.0 for seconds in timings.values())
    assert Stopwatch().stop() == {}
