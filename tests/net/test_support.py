"""Where points end and where they have gaps, against half planes and discs."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.net.mesh import TriangleMesh
from crispline.net.support import coverage, local_spacings, support

UP = np.array([0.0, 0.0, 1.0])


def square(n_side, seed=0):
    """Random points of spacing 1 on a square about the origin."""
    half = 0.5 * n_side
    xy = np.random.default_rng(seed).uniform(-half, half, (n_side**2, 2))
    return np.column_stack([xy, np.zeros(len(xy))])


def test_local_spacing_of_a_random_sampling():
    points = square(80)
    distances, _ = cKDTree(points).query(points, k=24)
    inner = np.abs(points).max(axis=1) < 35.0
    assert local_spacings(distances)[inner].mean() == pytest.approx(1.0, abs=0.03)


@pytest.mark.parametrize("scale", [1.0, 2.5])
def test_inset_is_the_distance_to_the_border(scale):
    points = scale * square(60)
    along = np.linspace(-20.0, 20.0, 81) * scale
    tree, spacing = cKDTree(points), np.full(len(points), scale)
    for inset in (-2.0, -1.0, 0.0, 1.0):
        x = np.full(len(along), (30.0 - inset) * scale)
        places = np.column_stack([x, along, 0.0 * x])
        found = support(places, np.broadcast_to(UP, places.shape), tree, spacing)
        assert np.mean(found.inset) / scale == pytest.approx(inset, abs=0.25)
        assert np.std(found.inset) / scale < 0.8
        assert np.mean(found.inward[:, 0]) < -0.8


def mesh_over(half, step=1.0):
    side = np.arange(-half, half + 0.5 * step, step)
    x, y = np.meshgrid(side, side, indexing="ij")
    n = len(side)
    vertices = np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()])
    i = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate(
        [np.stack([i, i + n, i + n + 1], axis=1), np.stack([i, i + n + 1, i + 1], axis=1)]
    )
    return TriangleMesh(vertices, triangles)


def covered(points, mesh, fill_holes):
    tree = cKDTree(points)
    found = support(mesh.vertices, mesh.normals(), tree, np.ones(len(points)))
    on_border = np.zeros(len(mesh.vertices), dtype=bool)
    on_border[mesh.borders().ravel()] = True
    return coverage(mesh.vertices, mesh.links(), on_border, found, fill_holes)


@pytest.mark.parametrize(("radius", "is_filled"), [(2.0, True), (6.0, False)])
def test_a_hole_is_filled_if_it_is_narrow(radius, is_filled):
    points = square(40)
    points = points[np.linalg.norm(points, axis=1) > radius]
    mesh = mesh_over(25.0)
    cover = covered(points, mesh, 6.0)
    away = np.linalg.norm(mesh.vertices, axis=1)
    assert (cover.value[away < 0.5] > 0.0).all() == is_filled
    outside = np.abs(mesh.vertices).max(axis=1)
    assert (cover.value[outside > 21.5] <= 0.0).all()
    ring = (outside < 18.0) & (away > radius + 2.0)
    assert (cover.value[ring] > 0.0).mean() > 0.99
    widths = sorted(cover.widths)
    assert len(widths) == 1 + (not is_filled)  # beyond the square, and the hole
    if not is_filled:
        assert min(widths, key=lambda w: abs(w - 2.0 * radius)) == pytest.approx(12.0, abs=1.5)


def test_a_closed_surface_without_gaps_stays_whole(nets):
    vertices, quads = nets.sphere(24, radius=15.0)
    mesh = TriangleMesh(vertices, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))
    points = np.random.default_rng(1).normal(size=(2827, 3))
    points *= 15.0 / np.linalg.norm(points, axis=1, keepdims=True)
    cover = covered(points, mesh, 6.0)
    assert (cover.value > 0.0).all()
    assert len(cover.widths) == 0


def test_far_places_are_outside_by_their_gap_alone():
    points = square(30)
    tree, spacing = cKDTree(points), np.ones(len(points))
    heights = np.array([0.0, 4.0, 5.0, 40.0])
    places = np.column_stack([np.zeros((4, 2)), heights])
    found = support(places, np.tile(UP, (4, 1)), tree, spacing)
    np.testing.assert_allclose(found.gap, tree.query(places)[0])
    np.testing.assert_allclose(found.value[2:], -3.0)
    np.testing.assert_allclose(found.inset[2:], -12.0)
    np.testing.assert_array_equal(found.inward[2:], 0.0)
    alone = support(places[:2], np.tile(UP, (2, 1)), tree, spacing)
    np.testing.assert_array_equal(found.inset[:2], alone.inset)


def test_far_places_know_about_how_far_they_are():
    """A lid over a bowl; the points nearest to its middle are all about as near."""
    points = square(120)
    away = np.linalg.norm(points[:, :2], axis=1)
    tree = cKDTree(points[away > 40.0])
    x, y = (a.ravel() for a in np.meshgrid(np.arange(-40.0, 41.0), np.arange(-40.0, 41.0)))
    lid = np.column_stack([x, y, 0.0 * x])
    found = support(lid, np.tile(UP, (len(lid), 1)), tree, np.full(tree.n, 2.0))
    exact = tree.query(lid)[0] / 2.0
    is_near = exact <= 8.0
    np.testing.assert_array_equal(found.gap[is_near], exact[is_near])
    assert np.abs(found.gap - exact).max() < 2.0
    assert np.abs(found.gap - exact)[~is_near].mean() < 0.6
    assert found.gap.min() >= 0.0
