"""Runs on windows, with stand-ins for sharpening so that what is measured is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.paper import grids
from crispline.paper.grids import GridRun, surface_patches
from crispline.paper.windows import FEATURES, windows
from crispline.spline.creased import CreasedNet
from crispline.spline.tensor import spline_over_grid


def grid_net(points):
    """The grid as a net of quads whose limit is the plain surface."""
    m, n = points.shape[:2]
    number = np.arange(m * n).reshape(m, n)
    quads = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    none = np.zeros((0, 2), dtype=np.int64)
    corners = number[[0, 0, -1, -1], [0, -1, 0, -1]]
    return CreasedNet(points.reshape(-1, 3), np.stack(quads, axis=2).reshape(-1, 4), none, corners)


def leave_plain(points, options):
    """Sharpening that finds everything sharp and changes nothing."""
    is_sharp = np.ones((points.shape[0] - 1, points.shape[1] - 1), dtype=bool)
    return SimpleNamespace(surface=spline_over_grid(points), is_sharp=is_sharp)


def test_a_net_and_a_spline_of_the_same_surface_measure_alike():
    window = windows("upper circle", 0.25)[0]
    spline = surface_patches(spline_over_grid(window.points))
    net = surface_patches(grid_net(window.points))
    assert len(spline.control_points) == len(net.control_points) == window.is_patch.size
    np.testing.assert_allclose(
        net.distances(window.samples), spline.distances(window.samples), atol=1e-9
    )


def test_what_changes_nothing_reduces_nothing(monkeypatch):
    monkeypatch.setattr(grids, "sharpen", leave_plain)
    (trial,) = GridRun("lower circle", 0.25, 0.01, 3, ("paper",)).trials(threads=1)
    assert trial.method == "paper"
    assert trial.sampling == "grid 0.25"
    assert trial.before == trial.after
    assert trial.found.n_found == trial.found.n_pieces
    assert trial.found.n_true * 17 == trial.found.n_sharp
    assert (trial.n_windows, trial.n_failed) == (8, 0)


def test_a_refused_window_stays_as_it_is(monkeypatch):
    def refuse(points, options):
        raise InputError("expected a larger grid")

    monkeypatch.setattr(grids, "sharpen", refuse)
    (trial,) = GridRun("straight", 0.0, 0.01, 0, ("robust",)).trials(threads=1)
    assert trial.n_failed == 12
    assert trial.before == trial.after
    assert trial.found.n_found == trial.found.n_sharp == 0


def test_rules_see_the_same_points_and_seeds_differ(monkeypatch):
    seen = []

    def remember(points, options):
        seen.append((options.rule, points))
        return leave_plain(points, options)

    monkeypatch.setattr(grids, "sharpen", remember)
    for seed in (0, 0, 1):
        GridRun("corner", 0.5, 0.02, seed, ("paper", "robust")).trials(threads=1)
    assert [rule for rule, _ in seen[:16]] == ["paper"] * 8 + ["robust"] * 8
    points = [grid for _, grid in seen]
    for index in range(8):
        np.testing.assert_array_equal(points[index], points[index + 8])
        np.testing.assert_array_equal(points[index], points[index + 16])
    assert not np.array_equal(points[0], points[32], equal_nan=True)
    assert not np.array_equal(points[0], points[1], equal_nan=True)


@pytest.mark.parametrize("feature", FEATURES)
def test_the_robust_rule_beats_the_plain_surface(feature, monkeypatch):
    monkeypatch.setattr(grids, "windows", lambda feature, phase: windows(feature, phase)[:2])
    (trial,) = GridRun(feature, 0.25, 0.005, 0, ("robust",)).trials(threads=1)
    assert trial.n_failed == 0
    assert trial.after.error < 0.15 * trial.before.error


@pytest.mark.parametrize("feature", FEATURES)
@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_detection_does_not_depend_on_the_unit(feature, factor):
    window = windows(feature, 0.375)[1].noisy(0.01, np.random.default_rng(2))
    _, here = grids.sharpened(window.points, "robust")
    _, there = grids.sharpened(window.scaled(factor).points, "robust")
    assert here.any()
    np.testing.assert_array_equal(here, there)
