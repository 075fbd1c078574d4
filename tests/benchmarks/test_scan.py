"""Simulated scans: on the surface, uniform by area, noise as asked; their file."""

import numpy as np
import pytest

from parts.modelling import box, torus
from parts.scan import scan
from parts.truth import read_truth, write_truth


@pytest.fixture(scope="module")
def scanned():
    return scan(box((60, 40, 30)), 20_000, noise=0.002, seed=3)


def test_clean_points_lie_on_the_box_with_its_normals(scanned):
    truth, area = scanned
    assert area == pytest.approx(2 * (60 * 40 + 60 * 30 + 40 * 30))
    size = np.array([60.0, 40, 30])
    low, high = np.isclose(truth.clean, 0), np.isclose(truth.clean, size)
    assert (low | high).any(axis=1).all()
    np.testing.assert_allclose(truth.normals, high * 1.0 - low, atol=1e-9)
    assert len(np.unique(truth.face_ids)) == truth.n_faces == 6


def test_density_is_uniform_by_area(scanned):
    truth, area = scanned
    top = np.isclose(truth.clean[:, 2], 30)
    assert top.mean() == pytest.approx(60 * 40 / area, abs=0.012)
    assert truth.clean[top].mean(axis=0) == pytest.approx([30, 20, 30], abs=0.7)
    assert truth.spacing == pytest.approx(np.sqrt(area / 20_000))


def test_noise_has_the_size_asked_for_and_leaves_the_places(scanned):
    truth, _ = scanned
    offsets = truth.points - truth.clean
    assert truth.diagonal == pytest.approx(np.linalg.norm([60, 40, 30]))
    assert offsets.std(axis=0) == pytest.approx(0.002 * truth.diagonal, rel=0.02)
    again, _ = scan(box((60, 40, 30)), 20_000, noise=0.0, seed=3)
    np.testing.assert_array_equal(again.points, truth.clean)


def test_points_on_a_torus_are_exact_and_denser_by_area_outside():
    truth, area = scan(torus(20, 5), 20_000)
    axis_distance = np.hypot(truth.clean[:, 0], truth.clean[:, 1])
    tube = np.hypot(axis_distance - 20, truth.clean[:, 2])
    np.testing.assert_allclose(tube, 5, atol=1e-9)
    assert area == pytest.approx(4 * np.pi**2 * 20 * 5, rel=2e-3)
    # Outer half: int (R + r cos v) dv over a half turn = pi R + 2 r of 2 pi R.
    outer = (axis_distance > 20).mean()
    assert outer == pytest.approx((np.pi * 20 + 2 * 5) / (2 * np.pi * 20), abs=0.01)


def test_the_file_gives_the_truth_again(tmp_path, scanned):
    truth, area = scanned
    write_truth(tmp_path / "truth.npz", truth, area)
    copy = read_truth(tmp_path / "truth.npz")
    for name in ("points", "clean", "normals", "face_ids"):
        np.testing.assert_array_equal(getattr(copy, name), getattr(truth, name))
    for name in ("n_faces", "diagonal", "noise", "is_open"):
        assert getattr(copy, name) == getattr(truth, name)
    assert copy.spacing == pytest.approx(truth.spacing)
    assert copy.features.kinds == truth.features.kinds
    assert copy.features.corner_kinds == truth.features.corner_kinds
    for line, other in zip(copy.features.polylines, truth.features.polylines, strict=True):
        np.testing.assert_array_equal(line, other)
