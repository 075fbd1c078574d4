import numpy as np
import pytest

from crispline.paper.measure import deviation, hits, mean_and_p99
from crispline.paper.patches import Patches, spline_patches
from crispline.paper.windows import REACH, windows
from crispline.spline.tensor import spline_over_grid


def truth_patches(window, lift=0.0):
    """The two true faces of a straight window as two planar patches, lifted off the model."""
    corner = window.samples[0], window.samples[-1]
    share = np.arange(4.0) / 3.0
    found = []
    for column in (0, -1):
        face = window.points[0, column] - corner[0]
        along = corner[1] - corner[0]
        normal = np.cross(along, face)
        normal /= np.linalg.norm(normal)
        normal *= np.sign(normal @ corner[0])
        net = share[:, None, None] * along + share[None, :, None] * face
        found.append(corner[0] + net + lift * normal)
    return Patches(np.stack(found))


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5])
def test_the_truth_has_no_error(phase):
    window = windows("straight", phase)[4]
    found = deviation(truth_patches(window), window)
    assert found.error < 1e-12
    assert found.reverse_p99 < 1e-12


def test_a_lifted_truth_has_its_lift_as_error():
    """Two planes moved outward by d both pass the edge at the distance d; their ends do too."""
    window = windows("straight", 0.25)[7]
    found = deviation(truth_patches(window, lift=0.03), window)
    assert found.error == pytest.approx(0.03, abs=1e-12)
    assert found.reverse_mean == pytest.approx(0.03, abs=1e-12)
    assert found.reverse_p99 == pytest.approx(0.03, abs=1e-12)


def test_plain_surface_at_a_straight_edge():
    """With a row on the edge the surface passes at (p[-1] + 4 p[0] + p[1]) / 6: sqrt(2)/6 off."""
    window = windows("straight", 0.0)[0]
    found = deviation(spline_patches(spline_over_grid(window.points)), window)
    assert found.error == pytest.approx(np.sqrt(2.0) / 6.0, abs=1e-9)
    # Midway the nearest point is the patch centre, weights (1, 23, 23, 1)/48 a direction.
    window = windows("straight", 0.5)[0]
    found = deviation(spline_patches(spline_over_grid(window.points)), window)
    off = (23.0 * 0.5 + 1.0 * 1.5) / 48.0
    assert found.error == pytest.approx(np.sqrt(2.0) * off, abs=1e-9)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_the_measure_does_not_depend_on_the_unit(factor):
    window = windows("upper circle", 0.25)[2].noisy(0.01, np.random.default_rng(0))
    scaled = window.scaled(factor)
    here = deviation(spline_patches(spline_over_grid(window.points)), window)
    there = deviation(spline_patches(spline_over_grid(scaled.points)), scaled)
    for name in ("error", "reverse_mean", "reverse_p99"):
        assert getattr(there, name) == pytest.approx(getattr(here, name), rel=1e-6)


def test_quantile_is_by_area():
    away = np.array([3.0, 1.0, 2.0])
    assert mean_and_p99(away, np.array([1.0, 1.0, 2.0])) == (2.0, 3.0)
    assert mean_and_p99(away, np.array([0.001, 0.5, 0.499]))[1] == 2.0


# --- detection ----------------------------------------------------------------------------


def band(window, *columns):
    is_sharp = np.zeros_like(window.is_patch)
    is_sharp[:, list(columns)] = True
    return is_sharp


def shares(found):
    precision = found.n_true / found.n_sharp if found.n_sharp else None
    return precision, found.n_found / found.n_pieces


def test_the_band_that_the_feature_runs_through_is_all_right():
    window = windows("straight", 0.25)[0]
    column = int(window.course[0, 1])
    assert shares(hits(band(window, column), window, 0.0)) == (1.0, 1.0)
    assert shares(hits(band(window, column, column + 1), window, 0.0)) == (0.5, 1.0)
    assert shares(hits(band(window, column + 1), window, 0.0)) == (0.0, 0.0)
    assert shares(hits(band(window), window, 0.0)) == (None, 0.0)


def test_a_feature_on_a_border_counts_for_either_side():
    window = windows("lower circle", 0.0)[0]
    column = round(window.course[0, 1])
    for columns in ((column - 1,), (column,), (column - 1, column)):
        assert shares(hits(band(window, *columns), window, 0.0)) == (1.0, 1.0)
    assert shares(hits(band(window, column + 1), window, 0.0)) == (0.0, 0.0)


def test_a_missing_patch_costs_its_share_of_the_recall():
    window = windows("straight", 0.5)[0]
    is_sharp = band(window, int(window.course[0, 1]))
    is_sharp[3] = False
    precision, recall = shares(hits(is_sharp, window, 0.0))
    assert precision == 1.0
    assert recall == pytest.approx(7.0 / 8.0, abs=1e-3)


def test_noise_blurs_the_border_of_a_cell_by_its_step():
    window = windows("straight", 0.125)[0]
    beside = band(window, int(window.course[0, 1]) - 1)
    assert shares(hits(beside, window, 0.125 / REACH * 0.99)) == (0.0, 0.0)
    assert shares(hits(beside, window, 0.125 / REACH * 1.01)) == (1.0, 1.0)
    midway = windows("straight", 0.375)[0]
    beside = band(midway, int(midway.course[0, 1]) - 1)
    assert shares(hits(beside, midway, 0.1)) == (0.0, 0.0)  # never more than a quarter


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5])
def test_a_corner_has_three_bands(phase):
    for window in windows("corner", phase):
        everything = hits(window.is_patch, window, 0.0)
        assert everything.n_found == everything.n_pieces
        assert 20 <= everything.n_true <= 50
        inside = window.course[(window.course >= 0.0).all(axis=1)]
        cells = np.floor(inside).astype(int)
        shape = window.is_patch.shape
        cells = cells[(cells < shape).all(axis=1)]
        is_sharp = np.zeros(shape, dtype=bool)
        is_sharp[tuple(cells.T)] = True
        is_sharp &= window.is_patch
        found = hits(is_sharp, window, 0.0)
        assert found.n_true == found.n_sharp
        assert found.n_found == found.n_pieces
