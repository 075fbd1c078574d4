import itertools

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.errors import InputError
from crispline.shapes import (
    SAMPLINGS,
    SHAPES,
    Shape,
    box_cylinder,
    bracket,
    distance_to_box_cylinder,
    sample,
    write_truth,
)

BOX = box_cylinder()
BRACKET = bracket()
both = pytest.mark.parametrize("shape", [BOX, BRACKET], ids=lambda shape: shape.name)


def kinds(items) -> dict[str, int]:
    names = [item.kind for item in items]
    return {name: names.count(name) for name in names}


def test_the_papers_model():
    assert kinds(BOX.faces) == {"plane": 7, "cylinder": 1}
    assert kinds(BOX.edges) == {"straight": 12, "lower circle": 1, "upper circle": 1}
    assert sorted(map(tuple, BOX.corners)) == sorted(itertools.product((-35.0, 35.0), repeat=3))
    assert BOX.area == pytest.approx(6 * 70**2 + 2 * np.pi * 25 * 29, rel=1e-5)
    clean = sample(BOX, 20000, seed=1).clean
    np.testing.assert_allclose(clean.max(axis=0), (35, 35, 64), atol=0.05)
    np.testing.assert_allclose(clean.min(axis=0), (-35, -35, -35), atol=0.05)


def test_the_example_part():
    assert kinds(BRACKET.faces) == {"plane": 7, "cylinder": 3, "free-form": 1}
    assert kinds(BRACKET.edges) == {"straight": 13, "curve": 5, "circle": 5}
    assert len(BRACKET.corners) == 10


def test_the_example_parts_features_are_large():
    spacing = np.sqrt(BRACKET.area / 40000)
    assert 12.0 / spacing > 6.0  # fillet radius
    assert 10.0 / spacing > 8.0  # smaller bore radius


@both
def test_normals_point_outward_by_the_divergence_theorem(shape: Shape):
    # A closed surface: the integral of n is 0, and that of x n_x, y n_y, z n_z is the volume.
    scan = sample(shape, 400_000, seed=2)
    cell = shape.area / len(scan.clean)
    np.testing.assert_allclose(scan.normals.sum(axis=0) * cell / shape.area, 0.0, atol=5e-3)
    volumes = (scan.clean * scan.normals).sum(axis=0) * cell
    assert volumes.min() > 0.0
    np.testing.assert_allclose(volumes, volumes.mean(), rtol=0.02)
    np.testing.assert_allclose(np.linalg.norm(scan.normals, axis=1), 1.0)
    if shape is BOX:
        assert volumes.mean() == pytest.approx(70**3 + np.pi * 25**2 * 29, rel=0.01)


@both
def test_normals_and_area_elements_agree_with_finite_differences(shape: Shape):
    h = 1e-5
    for face in shape.faces:
        u, v = face.midpoints(7, 7)
        by_u = (face.evaluate(u + h, v)[0] - face.evaluate(u - h, v)[0]) / (2 * h)
        by_v = (face.evaluate(u, v + h)[0] - face.evaluate(u, v - h)[0]) / (2 * h)
        cross = np.cross(by_u, by_v)
        np.testing.assert_allclose(np.linalg.norm(cross, axis=1), face.stretch(u, v), rtol=1e-7)
        normals = face.evaluate(u, v)[1]
        alignment = (cross * normals).sum(axis=1) / np.linalg.norm(cross, axis=1)
        np.testing.assert_allclose(np.abs(alignment), 1.0, atol=1e-9)


@both
def test_edges_lie_where_two_faces_meet_at_an_angle(shape: Shape):
    scan = sample(shape, 100_000, seed=3)
    tree = cKDTree(scan.clean)
    for edge in shape.edges:
        assert edge.points.shape == (100, 3)
        distance, near = tree.query(edge.points[1:-1], k=40)
        assert distance[:, 0].max() < 4.0 * scan.spacing
        normals = scan.normals[near]
        cosine = np.einsum("ijk,ilk->ijl", normals, normals).min(axis=(1, 2))
        assert np.median(cosine) < np.cos(np.radians(60.0))


@both
def test_edge_points_have_equal_steps(shape: Shape):
    for edge in shape.edges:
        steps = np.linalg.norm(np.diff(edge.points, axis=0), axis=1)
        np.testing.assert_allclose(steps, steps.mean(), rtol=1e-3)


@both
def test_corners_end_three_edges(shape: Shape):
    ends = np.concatenate(
        [edge.points[[0, -1]] for edge in shape.edges if "circle" not in edge.kind]
    )
    for corner in shape.corners:
        assert np.count_nonzero(np.linalg.norm(ends - corner, axis=1) < 1e-9) == 3


def test_distance_to_the_papers_model():
    assert distance_to_box_cylinder(sample(BOX, 5000, seed=4).clean).max() < 1e-12
    scan = sample(BOX, 60_000, seed=5)
    points = np.random.default_rng(6).uniform(-50.0, 80.0, size=(3000, 3))
    nearest = cKDTree(scan.clean).query(points)[0]
    exact = distance_to_box_cylinder(points)
    assert (exact <= nearest + 1e-12).all()
    np.testing.assert_allclose(exact, nearest, atol=1.5)
    inside_the_cylinder = np.array([[0.0, 0.0, 35.0], [3.0, 4.0, 35.0]])
    np.testing.assert_allclose(distance_to_box_cylinder(inside_the_cylinder), [25.0, 20.0])


@both
@pytest.mark.parametrize("sampling", SAMPLINGS)
def test_samplings_lie_on_the_shape_with_the_wanted_density(shape: Shape, sampling):
    scan = sample(shape, 8000, sampling=sampling)
    assert len(scan.clean) == pytest.approx(8000, rel=0.05)
    assert scan.spacing == pytest.approx(np.sqrt(shape.area / len(scan.clean)))
    share = np.bincount(scan.face_ids, minlength=len(shape.faces)) / len(scan.clean)
    areas = np.array([face.area_and_stretch[0] for face in shape.faces])
    np.testing.assert_allclose(share, areas / areas.sum(), atol=0.02)


def test_grid_rows_lie_on_the_edges_and_half_cell_rows_beside_them():
    # 34,000 points have a spacing of 1, so 70 cells along every side of the box.
    straight = [edge for edge in BOX.edges if edge.kind == "straight"]
    for sampling, expected in (("grid", 0.0), ("half-cell", 0.5)):
        side = sample(BOX, 34000, sampling=sampling).clean
        side = side[(side[:, 2] == -35.0)]
        assert np.abs(np.abs(side[:, 0]).max() - 35.0) == pytest.approx(expected, abs=1e-9)
        assert np.abs(np.diff(np.unique(side[:, 0].round(9)))).max() == pytest.approx(1.0)
    on_grid = cKDTree(sample(BOX, 34000, sampling="grid").clean)
    for edge in straight:
        assert on_grid.query(edge.points[[0, -1]])[0].max() == pytest.approx(0.0, abs=1e-9)


def test_a_grid_has_no_point_twice():
    clean = sample(BOX, 5000, sampling="grid").clean
    assert cKDTree(clean).query(clean, k=2)[0][:, 1].min() > 1e-3


@pytest.mark.parametrize(("shape", "length"), [(BOX, 70.0), (BRACKET, 80.0)])
def test_noise_is_the_papers(shape: Shape, length):
    scan = sample(shape, 4000, noise=0.02, seed=8)
    offset = scan.points - scan.clean
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), 0.02 * length / 8.0)
    np.testing.assert_allclose(offset.mean(axis=0), 0.0, atol=0.01)


def test_outliers_fill_the_grown_box_and_come_last():
    scan = sample(BOX, 20000, outliers=0.1, seed=9)
    stray = scan.points[len(scan.clean) :]
    assert len(stray) == 2000
    low, high = np.array([-38.5, -38.5, -39.95]), np.array([38.5, 38.5, 68.95])
    assert (stray >= low).all()
    assert (stray <= high).all()
    np.testing.assert_allclose(stray.mean(axis=0), (low + high) / 2.0, atol=2.5)
    np.testing.assert_array_equal(scan.points[: len(scan.clean)], scan.clean)


def test_the_seed_decides_everything():
    first = sample(BRACKET, 3000, noise=0.01, outliers=0.05, seed=1)
    again = sample(BRACKET, 3000, noise=0.01, outliers=0.05, seed=1)
    other = sample(BRACKET, 3000, noise=0.01, outliers=0.05, seed=2)
    np.testing.assert_array_equal(first.points, again.points)
    assert not np.isin(first.clean, other.clean).any(axis=1).all()
    quiet = sample(BRACKET, 3000, seed=1)
    np.testing.assert_array_equal(first.clean, quiet.clean)


def test_truth_is_saved_whole_and_alike(tmp_path):
    scan = sample(BOX, 500, noise=0.01, outliers=0.1)
    for name in ("a.npz", "b.npz"):
        write_truth(tmp_path / name, scan)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    with np.load(tmp_path / "a.npz") as truth:
        np.testing.assert_array_equal(truth["points"], scan.clean)
        assert truth["edges"].shape == (14, 100, 3)
        assert truth["edge_kinds"].tolist() == [edge.kind for edge in BOX.edges]
        assert truth["face_kinds"][truth["face_ids"]].shape == (500,)
        assert truth["corners"].shape == (8, 3)


@pytest.mark.parametrize(
    "fault", [{"n_points": 0}, {"noise": -0.1}, {"noise": np.nan}, {"outliers": np.inf}]
)
def test_impossible_scans_are_refused(fault):
    with pytest.raises(InputError, match="expected"):
        sample(BOX, **{"n_points": 10, **fault})


def test_shapes_are_known_by_their_names():
    assert {name: make().name for name, make in SHAPES.items()} == {name: name for name in SHAPES}
