"""Contours of known lines and arcs, cut into these."""

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from crispline.fit.swept import Translation, fit_circle, fit_line
from crispline.region.grow import Ground
from crispline.region.narrow.contour import sides
from crispline.surface import Cylinder, Plane

UP = Translation(np.array([0.0, 0.0, 1.0]))
MIN_PATCHES = 6


def swept(profile):
    def fit(points, _normals, sigma, _start=None, _draft=False):
        curve = profile(UP.flattened(points), sigma)
        return None if curve is None else UP.surface(curve)

    return fit


KINDS = [swept(fit_line), swept(fit_circle)]


def ground(distance, size, seed=0):
    """The patches within half a side of a contour, given by the distance from it."""
    x, y = (
        grid.ravel()
        for grid in np.meshgrid(np.arange(-size, size + 1.0), np.arange(-size, size + 1.0))
    )
    rng = np.random.default_rng(seed)
    flat = np.column_stack([x, y]) + rng.uniform(-0.2, 0.2, (len(x), 2))
    flat = flat[np.abs(distance(flat)) < 0.8]
    points = np.column_stack([flat, np.zeros(len(flat))])
    pairs = cKDTree(np.rint(flat)).query_pairs(1.01, output_type="ndarray")
    n = len(points)
    adjacency = csr_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    adjacency = csr_array(adjacency + adjacency.T)
    normals = np.tile(UP.direction, (n, 1))
    return Ground(points, normals, adjacency, np.ones(n, dtype=bool), 0.35, -2.0, 0.8, 6)


def rectangle(flat, half=(20.0, 12.0)):
    off = np.abs(flat) - half
    return np.where(off.max(axis=1) < 0.0, off.max(axis=1), np.hypot(*np.maximum(off, 0.0).T))


@pytest.mark.parametrize("seed", range(4))
def test_a_rectangle_has_four_straight_sides(seed):
    contour = ground(rectangle, 24, seed)
    found = sides(contour, KINDS, MIN_PATCHES)
    assert [type(side.surface) for side in found] == [Plane] * 4
    assert [side.kind for side in found] == [0] * 4
    normals = np.abs([side.surface.normal[:2] for side in found])
    np.testing.assert_allclose(np.sort(normals, axis=1), [[0.0, 1.0]] * 4, atol=0.03)
    assert sorted(np.concatenate([side.patches for side in found])) == list(
        range(len(contour.points))
    )
    for side in found:
        own = np.abs(side.surface.signed_distance(contour.points[side.patches]))
        assert own.max() < 1.5


def test_a_circle_is_one_side():
    contour = ground(lambda flat: np.hypot(*flat.T) - 15.0, 18)
    (side,) = sides(contour, KINDS, MIN_PATCHES)
    assert isinstance(side.surface, Cylinder)
    assert side.surface.radius == pytest.approx(15.0, abs=0.2)
    assert len(side.patches) == len(contour.points)


def test_half_a_circle_and_its_chord_are_two():
    def half_disc(flat):
        round_off = np.hypot(*flat.T) - 16.0
        straight = -flat[:, 1]
        return np.maximum(round_off, straight)

    found = sides(ground(half_disc, 20), KINDS, MIN_PATCHES)
    assert sorted(type(side.surface).__name__ for side in found) == ["Cylinder", "Plane"]
    (arc,) = [side.surface for side in found if isinstance(side.surface, Cylinder)]
    assert arc.radius == pytest.approx(16.0, abs=0.4)


def test_a_band_too_wide_to_be_a_contour_has_no_sides():
    assert sides(ground(lambda flat: rectangle(flat) / 4.0, 24), KINDS, MIN_PATCHES) == []


def test_too_few_patches_have_none():
    contour = ground(rectangle, 24)
    assert sides(contour, KINDS, len(contour.points)) == []
