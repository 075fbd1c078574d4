"""The whole chain on small scans of the paper's model, and on scans that it must refuse."""

from functools import cache

import numpy as np
import pytest

from crispline.brep.check import check_file
from crispline.brep.ladder import Attempt, Ladder
from crispline.errors import InputError, ReconstructionError
from crispline.pipeline import detect, reconstruct
from crispline.shapes import SHAPES, sample
from crispline.surface import Similarity

SHAPE = SHAPES["box-cylinder"]()
VOLUME = 70.0**3 + np.pi * 25.0**2 * 29.0
EDGES, CORNERS = 14, 8
VOLUME_ERROR = {0.0: 1e-4, 0.02: 1e-3, 0.05: 2e-3}


@cache
def scan(n_points=8000, **settings):
    return sample(SHAPE, n_points, **{"seed": 1, **settings})


@cache
def reference():
    """The random scan with 1 % noise, reconstructed once for several tests."""
    return reconstruct(scan(noise=0.01).points)


def kinds(result):
    return sorted(face.kind for face in result.faces)


def assert_box_with_cylinder(result, n=1):
    assert result.valid
    assert result.closed
    assert kinds(result) == ["cylinder"] * n + ["plane"] * 7 * n
    assert sum(edge.is_sharp for edge in result.edges) == EDGES * n
    assert len(result.edges) == EDGES * n
    assert len(result.corners) == CORNERS * n


def nearest(points, others):
    """Distance of every point to the nearest of the others."""
    return np.linalg.norm(points[:, None] - others[None], axis=2).min(axis=1)


@pytest.mark.parametrize(
    ("sampling", "noise", "outliers", "corner_error"),
    [
        ("random", 0.0, 0.0, 0.002),
        ("grid", 0.0, 0.0, 0.002),
        ("half-cell", 0.02, 0.0, 0.03),
        ("grid", 0.02, 0.1, 0.04),
        ("random", 0.02, 0.1, 0.04),
        ("half-cell", 0.05, 0.0, 0.06),
        ("random", 0.05, 0.1, 0.08),
    ],
)
def test_box_with_cylinder(tmp_path, sampling, noise, outliers, corner_error):
    cloud = scan(sampling=sampling, noise=noise, outliers=outliers)
    result = reconstruct(cloud.points)
    assert_box_with_cylinder(result)
    assert result.solid.check.volume == pytest.approx(VOLUME, rel=VOLUME_ERROR[noise])
    assert result.spacing == pytest.approx(cloud.spacing, rel=0.06)
    assert nearest(SHAPE.corners, result.corners).max() < corner_error * cloud.spacing
    path = tmp_path / "part.step"
    result.write(path)
    inliers = cloud.points[: len(cloud.clean)]
    check = check_file(path, inliers, cloud.spacing)
    assert check.is_good
    assert (check.n_solids, check.n_faces) == (1, 8)
    assert check.volume == pytest.approx(result.solid.check.volume, rel=1e-6)
    assert max(check.edge_tolerance, check.vertex_tolerance) < 1e-3 * cloud.spacing


def test_features_and_parameters():
    result = reference()
    assert_box_with_cylinder(result)
    (cylinder,) = [face for face in result.faces if face.kind == "cylinder"]
    assert cylinder.parameters["radius"] == pytest.approx(25.0, abs=0.03)
    assert cylinder.area == pytest.approx(2 * np.pi * 25.0 * 29.0, rel=2e-3)
    # A plane that is not quite square to the cylinder meets it in an ellipse.
    assert [edge.kind for edge in result.edges].count("line") == 12
    for edge in result.edges:
        assert edge.angle_deg == pytest.approx(90.0, abs=0.5)
        truth = np.concatenate([true.points for true in SHAPE.edges])
        assert nearest(edge.points, truth).mean() < 1.0  # the truth is sampled, not continuous
    level = 0.01 * SHAPE.length / 8.0 / np.sqrt(3.0)
    assert result.noise == pytest.approx(level, rel=0.25)
    for face in result.faces:
        assert face.rms == pytest.approx(level, rel=0.15)


def test_the_preserved_net_is_sharp_at_the_model():
    result = reference()
    patches = result.patches
    assert nearest(SHAPE.corners, patches.vertices[patches.corners]).max() < 0.05
    assert len(patches.corners) == CORNERS


def test_two_runs_write_the_same_bytes(tmp_path):
    reference().write(tmp_path / "one.step")
    reconstruct(scan(noise=0.01).points).write(tmp_path / "two.step")
    assert (tmp_path / "one.step").read_bytes() == (tmp_path / "two.step").read_bytes()


def turned(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


@pytest.mark.parametrize(
    "motion",
    [
        Similarity(1e-3, np.eye(3), np.zeros(3)),
        Similarity(1.0, turned(5), np.zeros(3)),
        Similarity(1.0, np.eye(3), np.array([1e6, -1e6, 1e6])),
    ],
    ids=["metres", "rotated", "far from the origin"],
)
def test_the_model_does_not_depend_on_unit_place_or_direction(tmp_path, motion):
    one = reference()
    other = reconstruct(motion.points(scan(noise=0.01).points))
    assert_box_with_cylinder(other)
    back = motion.inverse().points(other.corners)
    assert nearest(back, one.corners).max() < 0.02 * one.spacing
    assert nearest(one.corners, back).max() < 0.02 * one.spacing
    assert other.spacing == pytest.approx(motion.scale * one.spacing, rel=1e-6)
    assert other.noise == pytest.approx(motion.scale * one.noise, rel=1e-3)
    other.write(tmp_path / "part.step")
    assert check_file(tmp_path / "part.step").is_valid


def test_rows_that_repeat_or_are_not_finite_are_left_out_and_reported():
    points = scan(noise=0.01).points
    lost = np.full((5, 3), np.nan)
    result = reconstruct(np.concatenate([lost, points, points[:2000]]))
    assert_box_with_cylinder(result)
    assert nearest(result.corners, reference().corners).max() < 1e-6
    assert any(text.startswith("5 points with coordinates") for text in result.warnings)
    assert any(text.startswith("2000 points that repeat") for text in result.warnings)


def test_two_parts_become_two_solids():
    points = scan(3500, noise=0.01).points
    result = reconstruct(np.concatenate([points, points + np.array([150.0, 20.0, 0.0])]))
    assert_box_with_cylinder(result, n=2)
    assert result.solid.check.n_solids == 2
    assert result.solid.check.volume == pytest.approx(2.0 * VOLUME, rel=5e-3)


def test_detection_finds_the_same_features_and_builds_nothing():
    stages = []
    result = detect(scan(noise=0.01).points, progress=lambda name, share: stages.append(name))
    assert result.solid is None
    assert not result.valid
    assert len(result.edges) == EDGES
    np.testing.assert_allclose(result.corners, reference().corners, atol=1e-9)
    assert stages == ["cloud", "normals", "net", "curvature", "regions", "edges", "done"]
    assert list(result.timings) == stages[:-1]
    with pytest.raises(ReconstructionError, match="no valid model to write"):
        result.write("part.step")


def test_progress_runs_forward():
    shares = []
    result = reconstruct(scan(3000).points, progress=lambda name, share: shares.append(share))
    assert shares == sorted(shares)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    assert all(seconds >= 0.0 for seconds in result.timings.values())


def test_half_a_scan_is_an_open_shell_with_its_rim():
    points = scan(6000, noise=0.01).points
    result = reconstruct(points[points[:, 0] > 0.0])
    assert result.valid
    assert not result.closed
    assert any(text.startswith("open shell") for text in result.warnings)
    assert sum(-1 in edge.faces for edge in result.edges) >= 4


def test_a_model_that_fails_tells_what_is_good(monkeypatch):
    def failing(_, kind):
        return Attempt(reference().model, None, ())

    monkeypatch.setattr(Ladder, "climb", failing)
    with pytest.raises(ReconstructionError, match="no solid was built") as caught:
        reconstruct(scan(3000).points)
    assert caught.value.exit_code == 3
    partial = caught.value.partial
    assert partial is not None
    assert not partial.valid
    assert len(partial.edges) == EDGES


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (np.zeros((0, 3)), "found none"),
        (np.zeros((50, 2)), r"shape \(n, 3\)"),
        (np.zeros((50, 3)), "are equal"),
        (np.random.default_rng(0).random((10, 3)), "at least 24 points"),
    ],
)
def test_unusable_clouds_are_refused_before_any_work(points, message):
    with pytest.raises(InputError, match=message):
        reconstruct(points)


def test_an_unforeseen_error_names_its_stage(monkeypatch):
    def broken(*_):
        raise ZeroDivisionError("no such luck")

    monkeypatch.setattr("crispline.features.quad_net", broken)
    with pytest.raises(ReconstructionError, match=r"stage 'net' broke down \(ZeroDivisionError"):
        reconstruct(scan(3000).points)


@pytest.mark.parametrize("rise", [0.9, -0.9, 1.5], ids=["pad", "pocket", "higher pad"])
def test_low_pads_and_pockets_keep_their_corners(rise):
    """Walls of one and a half spacings, and of two and a half, round a rectangle."""
    rng = np.random.default_rng(0)
    size, low, high = np.array([36.0, 26.0, 8.0]), np.array([8.0, 6.0]), np.array([28.0, 20.0])
    sheets = [
        ((0, 0, 0), (36, 0, 0), (0, 26, 0)),
        ((0, 0, 0), (36, 0, 0), (0, 0, 8)),
        ((0, 26, 0), (36, 0, 0), (0, 0, 8)),
        ((0, 0, 0), (0, 26, 0), (0, 0, 8)),
        ((36, 0, 0), (0, 26, 0), (0, 0, 8)),
        ((0, 0, 8), (36, 0, 0), (0, 26, 0)),
        ((8, 6, 8 + rise), (20, 0, 0), (0, 14, 0)),
        ((8, 6, 8), (20, 0, 0), (0, 0, rise)),
        ((8, 20, 8), (20, 0, 0), (0, 0, rise)),
        ((8, 6, 8), (0, 14, 0), (0, 0, rise)),
        ((28, 6, 8), (0, 14, 0), (0, 0, rise)),
    ]
    places, first, second = np.moveaxis(np.array(sheets, dtype=float), 1, 0)
    area = np.linalg.norm(np.cross(first, second), axis=1)
    own = rng.choice(len(sheets), 9000, p=area / area.sum())
    u, v = rng.random((2, 9000, 1))
    points = places[own] + u * first[own] + v * second[own]
    is_covered = (own == 5) & ((points[:, :2] > low) & (points[:, :2] < high)).all(axis=1)
    points = points[~is_covered] + rng.normal(0.0, 0.04, ((~is_covered).sum(), 3))
    part = reconstruct(points)
    assert part.solid.representation == "trimmed"
    assert len(part.model.faces) == 11
    assert {face.surface.kind for face in part.model.faces} == {"plane"}
    assert part.solid.check.volume == pytest.approx(size.prod() + rise * 280.0, rel=3e-3)
    assert part.solid.check.edge_tolerance < 0.01


def counterbored(seed):
    """A block with a bore of radius 3 and a counterbore of 5.2, whose floor is 2.2 wide."""
    rng = np.random.default_rng(seed)
    half, height, floor = 20.0, 14.0, 9.0
    parts = []

    def add(points, normal):
        parts.append(points + rng.normal(0.0, 0.13, (len(points), 1)) * normal)

    for z, inner, outer in ((height, 5.2, 99.0), (0.0, 3.0, 99.0), (floor, 3.0, 5.2)):
        points = np.column_stack([rng.uniform(-half, half, (1600, 2)), np.full(1600, z)])
        away = np.hypot(*points[:, :2].T)
        add(points[(inner < away) & (away < outer)], np.array([0.0, 0.0, 1.0]))
    for axis in (0, 1):
        for side in (-half, half):
            points = np.column_stack([rng.uniform(-half, half, (560, 2)), rng.uniform(0, 14, 560)])
            points[:, axis] = side
            add(points, np.eye(3)[axis])
    for radius, low, high in ((3.0, 0.0, floor), (5.2, floor, height)):
        turn = rng.uniform(0.0, 2.0 * np.pi, int(2.0 * np.pi * radius * (high - low)))
        normal = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(len(turn))])
        points = radius * normal
        points[:, 2] = rng.uniform(low, high, len(turn))
        add(points, normal)
    return np.concatenate(parts)


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_a_counterbore_keeps_its_wall_and_its_narrow_floor(seed):
    part = reconstruct(counterbored(seed))
    assert part.solid.representation == "trimmed"
    assert kinds(part) == ["cylinder"] * 2 + ["plane"] * 7
    assert max(part.solid.check.edge_tolerance, part.solid.check.vertex_tolerance) < 0.05
    radii = sorted(face.surface.radius for face in part.model.faces if face.surface.kind != "plane")
    assert radii == pytest.approx([3.0, 5.2], abs=0.1)
