"""The indicator of a solid: level at the points, sides, symmetry, units of the jump."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.net import poisson
from crispline.net.poisson import Indicator, point_areas, poisson_indicator


def ball(radius=8.0, seed=0):
    """About one random point per unit of area."""
    normals = np.random.default_rng(seed).normal(size=(round(4 * np.pi * radius**2), 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = radius * normals
    distances, _ = cKDTree(points).query(points, k=10)
    return points, normals, point_areas(distances)


def test_trilinear_values_of_a_trilinear_function():
    def f(p):
        x, y, z = p.T
        return 1.0 + 2.0 * x - y + 0.5 * z + x * y - 0.25 * x * y * z

    grid = np.stack(np.meshgrid(*3 * [np.arange(5.0)], indexing="ij"), axis=-1)
    origin, cell = np.array([10.0, -3.0, 2.0]), 0.5
    indicator = Indicator(f(grid.reshape(-1, 3)).reshape(5, 5, 5).astype(np.float32), origin, cell)
    places = np.random.default_rng(0).uniform(0.0, 4.0, (50, 3))
    np.testing.assert_allclose(indicator.at(origin + cell * places), f(places), rtol=1e-5)


def test_weights_put_every_point_back_in_its_place():
    """The eight weights sum to one and average the corners to the point."""
    position = np.random.default_rng(0).uniform(1.0, 6.0, (40, 3))
    corner = np.floor(position).astype(np.int64)
    flat, weights = poisson._trilinear(corner, position - corner, (8, 9, 10))
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)
    assert (weights >= 0.0).all()
    corners = np.stack(np.unravel_index(flat, (8, 9, 10)), axis=-1)
    np.testing.assert_allclose(np.einsum("cn,cnk->nk", weights, corners), position)


@pytest.mark.parametrize("cell", [1.0, 1.5])
def test_indicator_of_a_ball(cell):
    radius = 8.0
    points, normals, areas = ball(radius)
    indicator = poisson_indicator(points, normals, areas, cell)
    reach = 3.0 * cell * normals
    inside, outside = indicator.at(points - reach).mean(), indicator.at(points + reach).mean()
    jump = inside - outside
    # Larger inside, by one: the gradient integrates the areas, up to their sampling error.
    assert jump == pytest.approx(1.0, abs=0.06)
    at_points = indicator.at(points)
    assert at_points.mean() == pytest.approx((inside + outside) / 2.0, abs=0.12)
    assert at_points.std() < 0.12 * jump
    assert (indicator.at(points - reach) > at_points.mean()).all()
    assert (indicator.at(points + reach) < at_points.mean()).all()


def test_turning_the_normals_over_turns_the_indicator_over():
    points, normals, areas = ball(5.0)
    one = poisson_indicator(points, normals, areas)
    other = poisson_indicator(points, -normals, areas)
    np.testing.assert_allclose(other.values, -one.values, atol=1e-5)


def test_the_indicators_of_two_parts_add_up_on_the_grid_of_the_whole():
    points, normals, areas = ball(5.0)
    is_upper = points[:, :1] > 2.0
    whole = poisson_indicator(points, normals, areas)
    parts = [poisson_indicator(points, part * normals, areas) for part in (is_upper, ~is_upper)]
    np.testing.assert_array_equal(parts[0].origin, whole.origin)
    np.testing.assert_allclose(parts[0].values + parts[1].values, whole.values, atol=1e-5)


def test_points_without_a_normal_cost_nothing(monkeypatch):
    points, normals, areas = ball(5.0)
    spread = []
    known = poisson._trilinear
    monkeypatch.setattr(
        poisson,
        "_trilinear",
        lambda corner, *rest: spread.append(len(corner)) or known(corner, *rest),
    )
    poisson_indicator(points, (np.arange(len(points)) < 7)[:, None] * normals, areas)
    assert spread == [7]


def test_threads_do_not_change_it():
    points, normals, areas = ball(5.0)
    one = poisson_indicator(points, normals, areas, threads=1)
    two = poisson_indicator(points, normals, areas, threads=2)
    np.testing.assert_array_equal(one.values, two.values)


def test_the_grid_is_coarsened_rather_than_filling_the_memory(monkeypatch):
    points, normals, areas = ball(5.0)
    monkeypatch.setattr(poisson, "MAX_CELLS", 5000)
    indicator = poisson_indicator(points, normals, areas, 1.0)
    assert indicator.cell > 1.2
    assert indicator.values.size < 4 * 5000


def test_areas_of_points_sum_to_the_area():
    _, _, areas = ball(10.0)
    assert areas.sum() == pytest.approx(4 * np.pi * 100.0, rel=0.15)


def test_the_indicator_of_a_ball_falls_along_its_radius():
    points, normals, areas = ball()
    indicator = poisson_indicator(points, normals, areas)
    outward = -indicator.gradient(points)
    np.testing.assert_allclose(np.linalg.norm(outward, axis=1), 1.0)
    assert np.einsum("ni,ni->n", outward, normals).min() > 0.97
