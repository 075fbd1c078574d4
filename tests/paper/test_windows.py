import numpy as np
import pytest

from crispline.errors import InputError
from crispline.paper.windows import FEATURES, REACH, windows
from crispline.shapes import box_cylinder, distance_to_box_cylinder

PHASES = (0.0, 0.1, 0.25, 0.375, 0.5)
N_WINDOWS = {"straight": 12, "lower circle": 8, "upper circle": 8, "corner": 8}


def valid_points(window):
    return window.points[np.isfinite(window.points).all(axis=2)]


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("feature", FEATURES)
def test_points_and_samples_lie_on_the_model(feature, phase):
    found = windows(feature, phase)
    assert len(found) == N_WINDOWS[feature]
    for window in found:
        assert distance_to_box_cylinder(valid_points(window)).max() < 1e-12
        assert distance_to_box_cylinder(window.samples).max() < 1e-12


@pytest.mark.parametrize("feature", ["straight", "lower circle", "upper circle"])
def test_samples_are_a_stretch_of_the_models_edges(feature):
    edges = [edge.points for edge in box_cylinder().edges if edge.kind == feature]
    truth = np.concatenate(edges)
    for window in windows(feature, 0.25):
        assert window.samples.shape == (100, 3)
        steps = np.linalg.norm(np.diff(window.samples, axis=0), axis=1)
        np.testing.assert_allclose(steps, steps[0], rtol=1e-9)
        assert abs(steps.sum() - 8.0) < 0.02  # eight cells along
        gap = np.linalg.norm(truth[:, None] - window.samples[None], axis=2).min(axis=0)
        assert gap.max() < 1.0  # the edge's own points stand 0.7 or 1.6 apart


@pytest.mark.parametrize("phase", PHASES)
@pytest.mark.parametrize("feature", ["straight", "lower circle", "upper circle"])
def test_the_feature_runs_at_the_phase(feature, phase):
    for window in windows(feature, phase):
        column = window.course[0, 1]
        assert column % 1.0 == pytest.approx(phase)
        away = np.abs(np.arange(window.points.shape[1]) - column)
        middle_row = window.points.shape[0] // 2
        edge = window.samples[[49, 50]].mean(axis=0)
        found = np.linalg.norm(window.points[middle_row] - edge, axis=1)
        np.testing.assert_allclose(found, away, atol=3e-3)  # samples straddle the middle row


@pytest.mark.parametrize("feature", ["straight", "lower circle", "upper circle"])
def test_a_window_reaches_an_eighth_on_either_face(feature):
    for phase in PHASES:
        window = windows(feature, phase)[0]
        column = window.course[0, 1]
        for reach in (column, window.points.shape[1] - 1 - column):
            assert REACH - 1.0 < reach <= REACH


def test_neighbours_are_a_spacing_apart():
    for window in windows("straight", 0.25):
        along = np.linalg.norm(np.diff(window.points, axis=0), axis=2)
        across = np.linalg.norm(np.diff(window.points, axis=1), axis=2)
        np.testing.assert_allclose(along, 1.0)
        folded = int(window.course[0, 1])
        np.testing.assert_allclose(np.delete(across, folded, axis=1), 1.0)
        np.testing.assert_allclose(across[:, folded], np.hypot(0.25, 0.75))


@pytest.mark.parametrize("phase", PHASES)
def test_a_corners_image_has_one_point_per_unit_of_area(phase):
    area = 3.0 * REACH**2
    for window in windows("corner", phase):
        points = valid_points(window)
        assert np.sqrt(area / len(points)) == pytest.approx(1.0, abs=0.03)
        assert np.abs(points - window.samples[0]).max() <= REACH


@pytest.mark.parametrize("phase", PHASES)
def test_a_corner_lies_at_the_phase_in_both_directions(phase):
    found = windows("corner", phase)
    assert len({tuple(window.samples[0]) for window in found}) == 8
    for window in found:
        row, column = window.course[0]  # every edge starts in the corner
        assert column % 1.0 == pytest.approx(phase)
        assert min(row % 1.0, 1.0 - row % 1.0) == pytest.approx(phase, abs=1e-9)


@pytest.mark.parametrize("phase", [0.1, 0.25, 0.5])
def test_a_corners_edges_run_through_the_cells_whose_points_lie_on_several_faces(phase):
    for window in windows("corner", phase):
        on_face = np.abs(window.points - window.samples[0]) < 1e-12  # one column a face
        cells = [on_face[i : i - 1 or None, j : j - 1 or None] for i in (0, 1) for j in (0, 1)]
        is_mixed = window.is_patch & ~np.logical_and.reduce(cells).any(axis=2)
        inside = window.course[(np.abs(window.course - np.round(window.course)) > 1e-6).all(axis=1)]
        crossed = np.floor(inside).astype(int)
        crossed = crossed[((crossed >= 0) & (crossed < is_mixed.shape)).all(axis=1)]
        is_crossed = np.zeros_like(is_mixed)
        is_crossed[tuple(crossed.T)] = True
        np.testing.assert_array_equal(is_crossed & window.is_patch, is_mixed)


def test_noise_moves_every_point_by_the_level():
    stream = np.random.default_rng(0)
    for feature in FEATURES:
        window = windows(feature, 0.25)[0]
        moved = np.linalg.norm(window.noisy(0.02, stream).points - window.points, axis=2)
        is_there = np.isfinite(window.points).all(axis=2)
        np.testing.assert_allclose(moved[is_there], 0.02 * 70.0 / 8.0)
        assert np.isnan(moved[~is_there]).all()


def test_scaling_keeps_everything_in_proportion():
    window = windows("corner", 0.25)[3].noisy(0.01, np.random.default_rng(1))
    for factor in (1e-3, 1e3):
        scaled = window.scaled(factor)
        np.testing.assert_allclose(scaled.points / scaled.spacing, window.points)
        np.testing.assert_allclose(scaled.samples / scaled.spacing, window.samples)
        np.testing.assert_array_equal(scaled.course, window.course)


def test_cells_with_a_missing_point_are_no_patches():
    assert windows("straight", 0.0)[0].is_patch.all()
    window = windows("corner", 0.25)[0]
    for i, j in np.ndindex(window.is_patch.shape):
        cell = window.points[i : i + 2, j : j + 2]
        assert window.is_patch[i, j] == np.isfinite(cell).all()


def test_bad_input_is_told():
    with pytest.raises(InputError, match="feature: expected one of straight"):
        windows("edge", 0.0)
    for phase in (-0.1, 0.6, np.nan):
        with pytest.raises(InputError, match="phase: expected a position of 0"):
            windows("straight", phase)
