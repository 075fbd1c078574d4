"""``locate`` on ragged borders of exact surfaces."""

import numpy as np
import pytest
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from crispline.options import LocateOptions
from crispline.surface import Plane, Similarity

RAGGED = [(0.0, 0), (1.0, 1), (2.0, 2)]


def euler(model):
    return len(model.vertices) - len(model.edges) + len(model.faces)


def assert_consistent(model):
    """Loops close, every edge is used once by each of its faces, curves end at their vertices."""
    used = set()
    for index, face in enumerate(model.faces):
        for loop in face.loops:
            ends = []
            for edge_index, side in loop:
                edge = model.edges[edge_index]
                assert (edge.left if side > 0 else edge.right) == index
                assert (edge_index, side) not in used
                used.add((edge_index, side))
                ends.append((edge.start, edge.end)[::side])
            assert all(a[1] == b[0] for a, b in zip(ends, ends[1:] + ends[:1], strict=True))
    assert len(used) == 2 * len(model.edges)
    for edge in model.edges:
        tips = edge.curve.samples(2)
        for tip, vertex in zip(tips, (edge.start, edge.end), strict=True):
            distance = np.linalg.norm(tip - model.vertices[vertex])
            assert distance <= model.vertex_gaps[vertex] + 1e-12


@pytest.mark.parametrize(("raggedness", "seed"), [*RAGGED, (3.0, 3)])
@pytest.mark.parametrize("size", [(40.0, 30.0, 20.0), (6.0, 6.0, 4.0)])
def test_box_is_recovered_exactly(shapes, size, raggedness, seed):
    network = shapes["box"](raggedness, seed, size)
    model, warnings = network.located()
    assert warnings == ()
    assert_consistent(model)
    assert euler(model) == 2
    for edge, truth in zip(model.edges, network.truth, strict=True):
        assert edge.curve.kind == "line"
        assert edge.is_sharp
        assert edge.angle == pytest.approx(np.pi / 2, abs=1e-12)
        np.testing.assert_allclose(edge.curve.samples(2), truth[[0, -1]], atol=1e-9)
    assert model.vertex_gaps.max() < 1e-9


@pytest.mark.parametrize(("raggedness", "seed"), RAGGED)
@pytest.mark.parametrize("radius", [3.0, 5.0])
def test_tangent_fillet_is_recovered_exactly(shapes, radius, raggedness, seed):
    network = shapes["box_with_fillet"](raggedness, seed, radius)
    model, warnings = network.located()
    assert warnings == ()
    assert_consistent(model)
    kinds = sorted(edge.curve.kind for edge in model.edges)
    assert kinds == ["circle"] * 2 + ["line"] * 13
    assert sum(not edge.is_sharp for edge in model.edges) == 2
    for edge, truth in zip(model.edges, network.truth, strict=True):
        np.testing.assert_allclose(edge.curve.samples(2), truth[[0, -1]], atol=1e-8)
        assert edge.gap < 1e-9


def test_borders_of_a_sculpture_are_drawn_between_corners(shapes):
    network = shapes["box_with_fillet"](1.0, 1, 3.0)
    full, _ = network.located()
    model, warnings = network.located(is_sculpture=True)
    assert warnings == ()
    assert_consistent(model)
    assert [edge.is_sharp for edge in model.edges] == [edge.is_sharp for edge in full.edges]
    for edge, truth, exact in zip(model.edges, network.truth, full.edges, strict=True):
        if not edge.is_sharp:
            assert edge.curve.kind != exact.curve.kind
            assert np.linalg.norm(edge.curve.samples(9) - exact.curve.samples(9), axis=1).max() < 2
        elif exact.start in sharp_only(full) and exact.end in sharp_only(full):
            np.testing.assert_allclose(edge.curve.samples(2), truth[[0, -1]], atol=1e-9)


def sharp_only(model):
    """Vertices at which only sharp edges end."""
    smooth = {v for edge in model.edges if not edge.is_sharp for v in (edge.start, edge.end)}
    return set(range(len(model.vertices))) - smooth


@pytest.mark.parametrize("lift", [0.1, -0.1])
def test_a_fillet_that_misses_its_plane_keeps_a_clean_border(shapes, lift):
    model, warnings = shapes["box_with_fillet"](1.0, 1, 5.0, lift).located()
    assert warnings == ()
    assert_consistent(model)
    between = {(edge.left, edge.right): edge for edge in model.edges}
    smooth = between[6, 5]
    assert not smooth.is_sharp
    # Half way between the two surfaces, above the fillet's highest line, which is straight.
    assert smooth.gap == pytest.approx(0.05, abs=1e-6)
    np.testing.assert_allclose(smooth.curve.samples(9)[:, 1], 25.0, atol=1e-6)
    # The arc on the end plane stays exact; the vertices own up to the gap.
    assert between[1, 6].gap < 1e-9
    assert model.vertex_gaps.max() == pytest.approx(0.05, abs=1e-6)


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (1.0, 1)])
@pytest.mark.parametrize("mismatch", [0.0, 0.1, -0.1])
def test_a_ridge_without_room_collapses(shapes, mismatch, raggedness, seed):
    model, warnings = shapes["hip_roof"](raggedness, seed, mismatch).located()
    assert_consistent(model)
    assert len(warnings) == 1
    assert "regions 0, 2" in warnings[0]
    assert (len(model.vertices), len(model.edges), len(model.faces)) == (5, 8, 5)
    assert model.vertex_gaps.max() < 0.15
    assert all(edge.gap < 1e-9 for edge in model.edges)


@pytest.mark.parametrize("ridge", [7.0, 11.0])
def test_a_ridge_without_room_collapses_however_long_it_is_in_the_net(shapes, ridge):
    model, warnings = shapes["hip_roof"](0.0, 0, 0.1, ridge).located()
    assert "became one corner" in warnings[0]
    assert len(model.edges) == 8


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (0.5, 1)])
def test_a_ridge_that_runs_the_other_way_is_found(shapes, raggedness, seed):
    """Labels may join the wrong two of four slopes."""
    model, warnings = shapes["hip_roof"](raggedness, seed, -0.6).located()
    assert_consistent(model)
    assert warnings == ()
    assert (len(model.vertices), len(model.edges), len(model.faces)) == (6, 9, 5)
    assert euler(model) == 2
    assert model.vertex_gaps.max() < 1e-9
    assert all(edge.gap < 1e-9 for edge in model.edges)
    assert {1, 3} in [{edge.left, edge.right} for edge in model.edges]
    assert {0, 2} not in [{edge.left, edge.right} for edge in model.edges]


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (0.5, 1)])
@pytest.mark.parametrize(("mismatch", "ridge"), [(-0.6, {1, 3}), (0.6, {0, 2})])
def test_one_corner_of_four_faces_is_two_of_three(shapes, mismatch, ridge, raggedness, seed):
    model, warnings = shapes["hip_roof"](raggedness, seed, mismatch, 0.0).located()
    assert_consistent(model)
    assert warnings == ()
    assert (len(model.vertices), len(model.edges), euler(model)) == (6, 9, 2)
    assert model.vertex_gaps.max() < 1e-9
    assert all(edge.gap < 1e-9 for edge in model.edges)
    assert ridge in [{edge.left, edge.right} for edge in model.edges]


@pytest.mark.parametrize("mismatch", [0.0, 0.1, -0.1])
def test_a_corner_of_four_faces_that_nearly_meet_stays_one(shapes, mismatch):
    model, _ = shapes["hip_roof"](0.0, 0, mismatch, 0.0).located()
    assert_consistent(model)
    assert (len(model.vertices), len(model.edges)) == (5, 8)


@pytest.mark.parametrize("side", [0, 1])
def test_beside_patches_no_ridge_collapses(shapes, side):
    """The net has the ridge, and patches have the net's sides; the other faces hold its ends."""
    model, warnings = shapes["hip_roof"](0.0, 0).located(patched=[side])
    assert_consistent(model)
    if side == 1:  # no side of the ridge
        assert (len(model.vertices), len(model.edges)) == (5, 8)
        return
    assert warnings == ()
    assert (len(model.vertices), len(model.edges)) == (6, 9)
    hips = [edge for edge in model.edges if 2 in (edge.left, edge.right) and edge.angle > 0.1]
    trimmed = [edge for edge in hips if 0 not in (edge.left, edge.right)]
    assert all(edge.gap < 1e-9 for edge in trimmed)
    tops = [v for v in range(6) if model.vertices[v, 2] > 5.0]
    assert np.linalg.norm(np.diff(model.vertices[tops], axis=0)) > 0.5


def test_a_ridge_with_room_stays(shapes):
    model, warnings = shapes["hip_roof"](1.0, 1, 0.5).located()
    assert warnings == ()
    assert_consistent(model)
    assert euler(model) == 2
    assert len(model.edges) == 9


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (1.5, 1)])
@pytest.mark.parametrize("difference", [0.0, 0.02, -0.02])
def test_equal_cylinders_get_their_missing_corners(shapes, difference, raggedness, seed):
    network = shapes["equal_cylinders"](raggedness, seed, difference)
    model, warnings = network.located()
    assert warnings == ()
    assert len(model.edges) == 2
    np.testing.assert_allclose(
        np.abs(model.vertices), [[0, 10, 0]] * 2, atol=abs(difference) + 1e-6
    )
    for edge in model.edges:
        assert edge.gap <= abs(difference) + 1e-5
        assert shapes["length"](edge.curve.samples(1000)) == pytest.approx(
            shapes["length"](network.truth[0]) / 2, rel=2e-3
        )


@pytest.mark.parametrize("seed", range(3))
def test_a_moved_part_gives_the_moved_model(shapes, seed):
    motion = Similarity(
        1.0,
        Rotation.random(rng=np.random.default_rng(seed)).as_matrix(),
        np.array([3.0, -40.0, 9.0]),
    )
    for name in ("box_with_fillet", "equal_cylinders", "hip_roof"):
        network = shapes[name](1.0, seed)
        model, warnings = network.located()
        moved, moved_warnings = network.located(motion)
        assert len(moved_warnings) == len(warnings)
        np.testing.assert_allclose(moved.vertices, motion.points(model.vertices), atol=1e-6)
        for edge, moved_edge in zip(model.edges, moved.edges, strict=True):
            assert moved_edge.curve.kind == edge.curve.kind
            image = motion.points(edge.curve.samples(50))
            dense = moved_edge.curve.samples(5000)
            assert cKDTree(dense).query(image)[0].max() < 0.02


def test_two_runs_are_equal(shapes):
    first, _ = shapes["equal_cylinders"](1.0, 0).located()
    second, _ = shapes["equal_cylinders"](1.0, 0).located()
    np.testing.assert_array_equal(
        first.edges[0].curve.control_points, second.edges[0].curve.control_points
    )


def test_an_open_shell_keeps_its_rim(shapes):
    network = shapes["Network"](0.5, 0)
    network.region(0, Plane(np.zeros(3), np.array([0.0, 0.0, 1.0])))
    network.chain(0, -1, curve=shapes["ring"](10.0, 0.0))
    model, warnings = network.located()
    assert warnings == ()
    assert not model.is_closed
    assert not model.edges[0].is_sharp
    assert model.edges[0].gap < 1e-9


def test_surfaces_that_do_not_meet_end_in_an_honest_fallback(shapes):
    network = shapes["box"](1.0, 0)
    far = network.regions[5].surface
    network.region(5, Plane(far.origin + np.array([0.0, 0.0, 30.0]), far.normal))
    model, warnings = network.located()
    assert_consistent(model)
    assert euler(model) == 2
    assert sum("no common curve" in warning for warning in warnings) == 4
    assert sum("no common point" in warning for warning in warnings) == 4
    assert all("5" in warning and "near (" in warning for warning in warnings)
    for edge in model.edges:
        surfaces = [model.faces[side].surface for side in (edge.left, edge.right)]
        samples = edge.curve.samples(777)
        for surface in surfaces:
            distance = np.abs(surface.signed_distance(samples)).max()
            assert distance <= 1.01 * edge.gap + 1e-9


@pytest.mark.parametrize("width", [1.2, 2.4])
def test_the_narrow_face_between_two_sides_of_a_plate_is_named(shapes, width):
    network = shapes["Network"](0.0, 0)
    for label, side in ((0, -1.0), (1, 1.0)):
        network.region(
            label, Plane(np.array([0.0, 0.0, side * width / 2]), np.array([0.0, 0.0, side]))
        )
    network.chain(0, 1, curve=shapes["ring"](10.0, 0.0))
    _, (warning,) = network.located()
    assert "a face between regions 0, 1 near (" in warning
    assert f"is lost, as it is only {width:g} spacings wide" in warning


@pytest.mark.parametrize("seed", range(4))
def test_bad_fits_never_raise(shapes, seed):
    rng = np.random.default_rng(seed)
    for name in ("box", "box_with_fillet", "hip_roof", "equal_cylinders"):
        network = shapes[name](2.0, seed)
        for label, fit in network.regions.items():
            tilt = Rotation.from_rotvec(rng.normal(size=3) * rng.choice([0.02, 0.5])).as_matrix()
            motion = Similarity(1.0, tilt, rng.normal(size=3) * rng.choice([0.1, 3.0]))
            network.region(label, fit.surface.transformed(motion), rng.choice([-1, 1]))
        model, _ = network.located()
        assert_consistent(model)
        assert np.isfinite(model.vertices).all()
        assert np.isfinite([edge.gap for edge in model.edges]).all()


def test_options_are_obeyed(shapes):
    strict = LocateOptions(collapse_distance=0.0, collapse_length=0.0)
    model, _ = shapes["hip_roof"](0.0, 0, 0.1).located(options=strict)
    assert len(model.edges) == 9


@pytest.mark.parametrize("away", [0.5, 3.0, 5.0])
def test_corners_that_are_one_point_are_so_wherever_the_net_has_them(shapes, away):
    """Labels along a shallow hip may be so ragged that both corners are far down it in the net."""
    network = shapes["hip_roof"](0.0, 0, ridge=1.0, mismatch=0.05)
    hip = np.array([-10.0, -10.0, -8.0]) / np.linalg.norm([10.0, 10.0, 8.0])
    for vertex, more in ((4, 1.0), (5, 0.0)):
        network.vertices[vertex] = [0.0, 0.0, 8.0] + (away + more) * hip
    network.vertices[-1] = 0.5 * (network.vertices[4] + network.vertices[5])
    model, warnings = network.located()
    assert "became one corner" in warnings[0]
    assert len(model.edges) == 8
    assert model.vertex_gaps.max() < 0.1
    assert np.linalg.norm(model.vertices - [0.0, 0.0, 8.0], axis=1).min() < 0.1
