"""What an inspection tells of clouds whose answers are known."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.cloud.inspection import inspect
from crispline.cloud.layout import is_in_scan_order, plane_noise, rim_share, wall_gaps
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.units import guess_unit
from crispline.errors import InputError
from crispline.shapes import SHAPES, sample


def sheet(n, size=50.0, seed=0, height=0.0):
    stream = np.random.default_rng(seed)
    return np.column_stack([stream.uniform(0.0, size, (n, 2)), np.full(n, height)])


def test_the_numbers_of_a_closed_part():
    scan = sample(SHAPES["bracket"](), 10000, noise=0.005, outliers=0.05, seed=1)
    rows = np.vstack([scan.points, scan.points[:7], np.full((3, 3), np.nan)])
    found = inspect(PointCloud.from_arrays(rows))
    assert (found.n_points, found.n_dropped, found.n_duplicates) == (len(scan.points) + 7, 3, 7)
    assert 0.025 < found.outlier_share < 0.05  # some strays lie too near to be told
    assert found.spacing == pytest.approx(scan.spacing, rel=0.05)
    assert (found.unit, found.has_normals, found.has_viewpoints) == ("mm", False, False)
    assert found.lost_below == pytest.approx(3.0 * found.spacing)
    assert found.uncertain_below == pytest.approx(5.0 * found.spacing)
    assert found.wall_below == pytest.approx(2.0 * found.spacing)
    assert not found.is_in_scan_order
    assert found.rim_share < found.rim_share_of_open
    assert not any("open" in warning or "sheet" in warning for warning in found.warnings)


def test_it_follows_the_unit_and_the_place():
    points = sample(SHAPES["bracket"](), 5000, noise=0.01, seed=2).points
    one = inspect(PointCloud.from_arrays(points))
    other = inspect(PointCloud.from_arrays(1e-3 * points + 5.0))
    assert other.spacing == pytest.approx(1e-3 * one.spacing, rel=1e-6)
    assert other.noise == pytest.approx(1e-3 * one.noise, rel=1e-4)
    assert other.rim_share == pytest.approx(one.rim_share, abs=1e-3)


def test_rims_of_a_sheet_are_counted():
    n, size = 10000, 50.0
    points = sheet(n, size)
    share = rim_share(points[:4000], points, cKDTree(points))
    # A row of points all round is 4 size / spacing of n points, 4 / sqrt(n).
    assert 0.4 * 4.0 / np.sqrt(n) < share < 1.5 * 4.0 / np.sqrt(n)
    found = inspect(PointCloud.from_arrays(points + np.array([0.0, 0.0, 1e-3])))
    assert any("rims or holes" in warning for warning in found.warnings)


def test_a_closed_surface_has_no_rim():
    stream = np.random.default_rng(4)
    ball = stream.normal(size=(8000, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    assert rim_share(ball[:4000], ball, cKDTree(ball)) < 0.002


@pytest.mark.parametrize("gap", [2.0, 2.6])
def test_two_sheets_see_each_other(gap):
    n, size = 4000, 50.0
    spacing = size / np.sqrt(n)
    points = np.vstack([sheet(n, size, 1), sheet(n, size, 2, gap * spacing)])
    points[:, 2] += 0.05 * spacing * np.random.default_rng(3).normal(size=len(points))
    found = wall_gaps(points[::4], points, cKDTree(points), spacing, 0.05 * spacing)
    is_seen = np.isfinite(found)
    assert is_seen.mean() > 0.6
    assert np.median(found[is_seen]) == pytest.approx(gap * spacing, rel=0.1)
    warnings = inspect(PointCloud.from_arrays(points)).warnings
    assert any("face another sheet" in warning for warning in warnings)


def test_sheets_farther_apart_and_single_ones_do_not():
    n, size = 4000, 50.0
    spacing = size / np.sqrt(n)
    apart = np.vstack([sheet(n, size, 1), sheet(n, size, 2, 4.0 * spacing)])
    for points in (apart, sheet(n, size)):
        found = wall_gaps(points[::4], points, cKDTree(points), spacing, 0.0)
        assert not np.isfinite(found).any()


def test_noise_from_planes_is_that_of_a_sheet():
    points = sheet(4000)
    points[:, 2] += 0.1 * np.random.default_rng(5).normal(size=4000)
    neighbours = cKDTree(points).query(points, k=8)[1]
    assert plane_noise(points, neighbours) == pytest.approx(0.1, rel=0.1)


def test_rows_of_a_scanner_are_recognised():
    x, y = np.meshgrid(np.arange(100.0), np.arange(50.0))
    rows = np.column_stack([x.ravel(), y.ravel(), np.zeros(5000)])
    assert is_in_scan_order(rows, 1.0)
    assert not is_in_scan_order(np.random.default_rng(0).permutation(rows), 1.0)


def test_uneven_density_is_told():
    points = np.vstack([sheet(12000, 20.0), sheet(300, 20.0, 1) + np.array([20.0, 0.0, 0.0])])
    points[:, 2] = 0.1 * np.sin(points[:, 0])
    found = inspect(PointCloud.from_arrays(points))
    assert found.density[1] / found.density[0] > 5.0
    assert any("density varies" in warning for warning in found.warnings)


@pytest.mark.parametrize(
    ("low", "high", "unit"),
    [
        ((0, 0, 0), (0.2, 0.1, 0.05), "m"),
        ((-60, -40, 0), (60, 40, 30), "mm"),
        ((612000.0, 5.1e6, 400.0), (612080.0, 5.10005e6, 430.0), "m"),
        ((-1, -0.5, -0.3), (1, 0.5, 0.3), "unknown"),
        ((0, 0, 0), (90000, 10, 10), "unknown"),
    ],
)
def test_units_are_guessed_from_sizes(low, high, unit):
    found, reason = guess_unit(np.array(low, float), np.array(high, float), 0.01)
    assert found == unit
    assert reason


def test_too_few_points_are_refused():
    with pytest.raises(InputError, match="at least 24 distinct points, the cloud has 5"):
        inspect(PointCloud.from_arrays(np.repeat(np.random.default_rng(0).random((5, 3)), 9, 0)))
