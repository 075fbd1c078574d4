"""Limit positions and normals do not change when the net is subdivided, and are where it goes."""

import creased_models as models
import numpy as np
import pytest

from crispline.errors import InputError
from crispline.spline.creased import CreasedNet, subdivided
from crispline.spline.limit import limit_points

KINDS = [
    *(("smooth", k) for k in (3, 4, 5, 6, 7)),
    *(("dart", k) for k in (3, 4, 5, 6)),
    *(("crease", k) for k in (1, 2, 3, 4, 5)),
    *(("corner", k) for k in (1, 2, 3)),
]


@pytest.mark.parametrize(("kind", "k"), KINDS)
def test_subdivision_leaves_the_limit_where_it_is(kind, k):
    net = models.fan(kind, k, seed=k, noise=0.05, n_steps=1)
    coarse, fine = limit_points(net), limit_points(subdivided(net))
    n = len(net.vertices)
    np.testing.assert_allclose(fine.position[:n], coarse.position, atol=1e-12)


@pytest.mark.parametrize(("kind", "k"), KINDS)
def test_the_net_goes_there(kind, k):
    net = models.fan(kind, k, seed=k, noise=0.05, n_steps=0)
    n, expected = len(net.vertices), limit_points(net).position
    for _ in range(6):
        net = subdivided(net)
    # The sides are 4 long.
    assert np.linalg.norm(net.vertices[:n] - expected, axis=1).max() < 1e-2
    error = np.linalg.norm(net.vertices[0] - expected[0])
    finer = np.linalg.norm(subdivided(net).vertices[0] - expected[0])
    assert finer <= 0.7 * error + 1e-12


# A corner with several quads in a sector has no tangent plane, and one quad alone beside a
# crease gets its plane only in the limit.
PLANE = [kind for kind in KINDS if kind not in (("crease", 1), ("corner", 2), ("corner", 3))]


@pytest.mark.parametrize(("kind", "k"), PLANE)
def test_subdivision_leaves_the_normals(kind, k):
    """Quad corner ``i`` of a quad becomes corner 0 of its child ``i``."""
    net = models.fan(kind, k, seed=k, noise=0.05, n_steps=1)
    coarse = limit_points(net).normals
    fine = limit_points(subdivided(net)).normals[:, 0].reshape(-1, 4, 3)
    is_first = net.quads == 0
    np.testing.assert_allclose(fine[is_first], coarse[is_first], atol=1e-10)


@pytest.mark.parametrize("k", [3, 4, 5, 8])
def test_normals_round_a_smooth_vertex_are_one(k):
    net = models.fan("smooth", k, seed=k, noise=0.1)
    normals = limit_points(net).normals[net.quads == 0]
    np.testing.assert_allclose(normals, np.broadcast_to(normals[0], normals.shape), atol=1e-12)
    assert normals[0, 2] > 0.8


@pytest.mark.parametrize("k", [2, 3])
def test_a_corner_has_one_normal_between_its_sharp_sides(k):
    net = models.fan("corner", k)
    # Flat but for the vertices round the corner that are not on a sharp side.
    vertices = net.vertices * [1.0, 1.0, 0.0]
    near = (np.linalg.norm(vertices, axis=1) < 2.0) & (vertices[:, 1] > 1e-9)
    vertices[near, 2] = 0.3 * np.random.default_rng(k).normal(size=near.sum())
    limit = limit_points(CreasedNet(vertices, net.quads, net.creases, net.corners))
    is_above = limit.position[net.quads].mean(axis=1)[:, 1:2] > 0.0
    normals = limit.normals[(net.quads == 0) & is_above]
    assert len(normals) == k
    np.testing.assert_allclose(normals, np.broadcast_to(normals[0], normals.shape), atol=2e-3)


def test_normals_of_a_cube_are_those_of_its_sides(nets):
    net = models.sharp_box(nets, 3)
    _, _, side = nets.box(3)
    outward = np.zeros((len(side), 4, 3))
    outward[np.arange(len(side)), :, side // 2] = (2.0 * (side % 2) - 1.0)[:, None]
    np.testing.assert_allclose(limit_points(net).normals, outward, atol=1e-12)


def test_tangents_of_a_plane_grid_are_its_steps(nets):
    net = models.open_grid(nets, 5, 4, seed=0, noise=0.0)
    limit = limit_points(net)
    np.testing.assert_allclose(limit.position, net.vertices, atol=1e-13)
    x, y = np.eye(3)[:2]
    corners = [(x, y), (y, -x), (-x, -y), (-y, x)]
    np.testing.assert_allclose(
        limit.tangents, np.broadcast_to(corners, limit.tangents.shape), atol=1e-13
    )
    np.testing.assert_allclose(limit.normals[..., 2], 1.0)


def test_a_vertex_without_quads_has_no_limit(nets):
    vertices, quads, _ = nets.box(1)
    net = CreasedNet(np.vstack([vertices, np.zeros(3)]), quads, models.NONE, models.NO_CORNERS)
    assert np.isnan(limit_points(net).position[-1]).all()


QUAD = [[0, 1, 2, 3]]
BAD = {
    "other faces": ([[0, 1, 2]], [], r"expected quads of shape \(m, 4\), got \(1, 3\)"),
    "no quads": (np.zeros((0, 4), int), [], r"expected quads of shape"),
    "out of range": ([[0, 1, 2, 9]], [], r"vertices 0 to 9, but the net has 9 vertices"),
    "twice": ([[0, 1, 2, 0]], [], r"quad 0 names a vertex twice"),
    "no side": (QUAD, [[0, 2]], r"crease between vertices 0 and 2 is no side"),
    "turned": ([*QUAD, [0, 1, 5, 4]], [], r"opposite sides up near .*vertex 0 and 1"),
    "three sheets": ([*QUAD, [1, 0, 4, 5], [1, 0, 7, 6]], [], r"3 quads meet at one side"),
    "touching": ([*QUAD, [2, 5, 6, 7]], [], r"touch in one vertex near .*vertex 2"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_surface_is_refused(case):
    quads, creases, message = BAD[case]
    vertices = np.random.default_rng(0).normal(size=(9, 3))
    pairs = np.array(creases, dtype=int).reshape(-1, 2)
    with pytest.raises(InputError, match=message):
        limit_points(CreasedNet(vertices, np.array(quads), pairs, models.NO_CORNERS))


def test_a_vertex_that_is_not_finite_is_named():
    vertices = np.zeros((9, 3))
    vertices[4, 1] = np.nan
    net = CreasedNet(vertices, np.array(QUAD), models.NONE, models.NO_CORNERS)
    with pytest.raises(InputError, match="vertex 4 of the net is not finite"):
        limit_points(net)
