"""Flat, curved and sharp patches of grids, at every position and noise level."""

import numpy as np
import pytest

from crispline.grid import curvature, detect, sharpen
from crispline.grid.band import curvature_noise, paper_rule, smoothed
from crispline.grid.lattice import lattice_of_points
from crispline.grid.noise import estimate_noise
from crispline.options import SharpenOptions

PHASES = np.linspace(0.0, 0.5, 6)
PAPER = SharpenOptions(rule="paper")


def crossed_columns(grids, phase):
    """Columns of cells with the edge in them or on their border."""
    s = grids.steps(phase)
    return np.flatnonzero((s[:-1] <= 1e-9) & (s[1:] >= -1e-9))


@pytest.mark.parametrize("level", [0.0, 0.005, 0.01, 0.02])
@pytest.mark.parametrize("phase", PHASES)
def test_exactly_the_crossed_patches_are_sharp(grids, phase, level):
    columns = crossed_columns(grids, phase)
    for seed in range(2):
        is_sharp = sharpen(grids.noisy(grids.folded(phase), level, seed)).is_sharp
        assert is_sharp[:, columns].any(axis=1).all()
        beside = np.ones(is_sharp.shape[1], dtype=bool)
        # Noise leaves open on which side of a row an edge within a tenth of it passes.
        beside[columns] = False
        if level and 0.0 < phase <= 0.1:
            beside[columns + 1] = beside[columns - 1] = False
        assert not is_sharp[:, beside].any()


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_is_the_same_in_every_unit(grids, scale):
    points = grids.noisy(grids.corner(0.2), 0.01)
    one, other = sharpen(points), sharpen(scale * points)
    np.testing.assert_array_equal(one.is_sharp, other.is_sharp)
    np.testing.assert_allclose(other.corners, scale * one.corners, rtol=1e-5, atol=1e-5 * scale)


@pytest.mark.parametrize("level", [0.0, 0.02, 0.05])
def test_nothing_is_sharp_on_a_plane_or_a_cylinder(grids, level):
    plane = grids.heights(lambda i, j: 0.2 * i + 0.1 * j, 40)
    angle, height = np.meshgrid(np.arange(60) / 25.0, np.arange(30.0), indexing="ij")
    cylinder = np.stack([25 * np.cos(angle), 25 * np.sin(angle), height], axis=2)
    for points in (plane, cylinder):
        assert not sharpen(grids.noisy(points, level)).is_sharp.any()


@pytest.mark.parametrize("radius", [3.0, 5.0, 12.0])
def test_a_thin_cylinder_is_not_sharp(radius):
    turn, height = np.meshgrid(np.arange(int(6 * radius)) / radius, np.arange(20.0), indexing="ij")
    points = np.stack([radius * np.cos(turn), radius * np.sin(turn), height], axis=2)
    assert not sharpen(points).is_sharp.any()


@pytest.mark.parametrize("radius", [3.0, 4.0])
def test_a_rounding_is_not_an_edge(grids, radius):
    def rounded(_, j):
        x = np.abs(j - 11.3)
        arc = np.sqrt(np.maximum(radius**2 - x**2, 0.0)) - np.sqrt(2.0) * radius
        return np.where(x < radius / np.sqrt(2.0), arc, -x)

    assert not sharpen(grids.heights(rounded)).is_sharp.any()


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5])
def test_detection_alone_finds_the_band(grids, phase):
    points = grids.folded(phase)
    found = detect(points, curvature(points))
    columns = crossed_columns(grids, phase)
    assert found.is_sharp[:, columns].any(axis=1).all()
    assert not np.delete(found.is_sharp, columns, axis=1).any()


def test_the_rule_of_the_paper_by_brute_force():
    rng = np.random.default_rng(0)
    bend = rng.normal(size=(7, 9))
    is_curved, is_sharp = paper_rule(bend, np.ones((7, 9), dtype=bool), 0.6)
    padded = np.pad(np.abs(bend) < 0.6, 1, mode="edge")
    for i in range(7):
        for j in range(9):
            around = padded[i : i + 3, j : j + 3].sum() - padded[i + 1, j + 1]
            assert is_curved[i, j] == (abs(bend[i, j]) >= 0.6)
            assert is_sharp[i, j] == (is_curved[i, j] and around >= 4)


def test_the_rule_of_the_paper_misses_some_positions(grids):
    """Which is why there is the robust rule."""
    found = [sharpen(grids.folded(phase), PAPER).is_sharp.any() for phase in (0.0, 0.1, 0.4, 0.5)]
    assert found == [False, False, True, True]


def test_noise_is_estimated_across_edges(grids):
    for level in (0.01, 0.02, 0.05):
        lattice = lattice_of_points(grids.noisy(grids.folded(0.3, 60), level))
        noise = estimate_noise(lattice)
        expected = level * 8.75 / np.sqrt(3.0)
        assert noise.normal * lattice.spacing == pytest.approx(expected, rel=0.15)
        assert noise.tangential * lattice.spacing == pytest.approx(expected, rel=0.15)


def test_predicted_noise_of_curvature_is_what_noise_gives(grids):
    flat = grids.heights(lambda i, j: 0.0 * i, 200)
    points = flat + 1e-4 * np.random.default_rng(0).normal(size=flat.shape)
    bend = curvature(points).mean
    for n_passes in (0, 2, 4):
        smooth = smoothed(bend, np.ones(bend.shape, dtype=bool), n_passes)[20:-20] / 1e-4
        gain = curvature_noise(n_passes)
        assert smooth[:, 50:-50].std() == pytest.approx(gain[-1], rel=0.1)
        assert smooth[:, 0].std() == pytest.approx(gain[0], rel=0.25)
