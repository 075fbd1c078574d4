"""Patches against B-splines where they are exact, and against the limit surface elsewhere."""

import creased_models as models
import numpy as np
import pytest
from scipy.interpolate import NdBSpline
from scipy.spatial import cKDTree

from crispline.spline.bezier import bezier_patches, is_exact
from crispline.spline.creased import CreasedNet, subdivided
from crispline.spline.limit import limit_points
from crispline.spline.sectors import net_sectors


def bernstein(t, n_derivatives=0):
    """Cubic Bernstein polynomials at ``t``, shape ``(k, 4)``."""
    if n_derivatives:
        return 3.0 * np.stack([-((1 - t) ** 2), (1 - t) * (1 - 3 * t), t * (2 - 3 * t), t**2], -1)
    return np.stack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3], -1)


def evaluated(patches, u, v, du=0, dv=0):
    """Points of all patches on the grid ``u x v``, shape ``(m, len(u), len(v), 3)``."""
    return np.einsum("ai,bj,mijx->mabx", bernstein(u, du), bernstein(v, dv), patches)


def phantom_spline(points):
    """The uniform bicubic spline over a grid with one extrapolated row on each side."""
    for _ in range(2):
        ends = 2.0 * points[:1] - points[1:2], 2.0 * points[-1:] - points[-2:-1]
        points = np.concatenate([ends[0], points, ends[1]]).swapaxes(0, 1)
    n_u, n_v = points.shape[:2]
    return NdBSpline((np.arange(-3.0, n_u + 1), np.arange(-3.0, n_v + 1)), points, 3)


T = np.linspace(0.0, 1.0, 6)


def assert_spline(patches, points):
    spline = phantom_spline(points)
    n_u, n_v = points.shape[:2]
    for patch, (i, j) in zip(patches, np.ndindex(n_u - 1, n_v - 1), strict=True):
        u, v = np.meshgrid(i + T, j + T, indexing="ij")
        expected = spline(np.stack([u, v], axis=-1))
        np.testing.assert_allclose(evaluated(patch[None], T, T)[0], expected, atol=1e-12)


def test_an_open_grid_is_the_uniform_bicubic_spline_with_phantom_rows(nets):
    net = models.open_grid(nets, 6, 5, seed=0, noise=1.0)
    assert is_exact(net_sectors(net)).all()
    assert_spline(bezier_patches(net), net.vertices.reshape(6, 5, 3))


def test_a_crease_parts_two_splines_each_with_its_own_phantom_row(nets):
    net = models.open_grid(nets, 7, 5, seed=1, noise=1.0)
    row = np.arange(15, 20)  # i = 3
    creases = np.stack([row[:-1], row[1:]], axis=1)
    patches = bezier_patches(CreasedNet(net.vertices, net.quads, creases, net.corners))
    grid = net.vertices.reshape(7, 5, 3)
    assert_spline(patches[:12], grid[:4])
    assert_spline(patches[12:], grid[3:])


def test_patches_between_creases_and_corners_are_exact(nets):
    patches = bezier_patches(models.sharp_box(nets, 1))
    points = evaluated(patches, T, T)
    assert np.abs(points).max(axis=-1) == pytest.approx(1.0)
    net = models.sharp_box(nets, 4)
    assert is_exact(net_sectors(net)).all()
    assert np.abs(evaluated(bezier_patches(net), T, T)).max(axis=-1) == pytest.approx(1.0)


KINDS = {"smooth": (3, 5, 6), "dart": (3, 4, 5), "crease": (1, 2, 3), "corner": (1, 2, 3)}


@pytest.fixture(params=[(kind, k) for kind, sizes in KINDS.items() for k in sizes])
def net(request):
    kind, k = request.param
    return models.fan(kind, k, seed=k, noise=0.05)


def borders(patches):
    """Points along the four sides of each patch, in its own direction, shape ``(4 m, 4, 3)``."""
    sides = [patches[:, :, 0], patches[:, 3, :], patches[:, ::-1, 3], patches[:, 0, ::-1]]
    return np.stack(sides, axis=1).reshape(-1, 4, 3)


def test_neighbours_share_their_border_bit_by_bit(net):
    along = borders(bezier_patches(net))
    twin = net_sectors(net).twin
    paired = np.flatnonzero(twin >= 0)
    assert len(paired)
    np.testing.assert_array_equal(along[paired], along[twin[paired], ::-1])


def test_patches_pass_through_the_limit_positions_with_the_limit_normals(net):
    patches, limit = bezier_patches(net), limit_points(net)
    corners = patches[:, [0, 3, 3, 0], [0, 0, 3, 3]]
    np.testing.assert_array_equal(corners, limit.position[net.quads])
    ends = np.array([0.0, 1.0])
    normal = np.cross(evaluated(patches, ends, ends, 1, 0), evaluated(patches, ends, ends, 0, 1))
    normal = normal[:, [0, 1, 1, 0], [0, 0, 1, 1]]
    length = np.linalg.norm(normal, axis=2)
    is_plane = length > 1e-9  # one quad alone beside a crease is opened flat
    unit_normal = normal[is_plane] / length[is_plane][:, None]
    np.testing.assert_allclose(unit_normal, limit.normals[is_plane], atol=1e-9)


def test_the_first_derivatives_agree_across_sides_between_regular_vertices(net):
    patches, sectors = bezier_patches(net), net_sectors(net)
    turned = [np.rot90(patches, -i, axes=(1, 2)) for i in range(4)]
    by_side = np.stack(turned, axis=1).reshape(-1, 4, 4, 3)
    regular = sectors.is_regular[sectors.of_corner]
    following = np.arange(len(regular)).reshape(-1, 4)[:, [1, 2, 3, 0]].ravel()
    is_smooth = ~sectors.sides.is_sharp[sectors.sides.of_half_edge]
    side = np.flatnonzero(is_smooth & regular & regular[following])
    own, other = by_side[side], by_side[sectors.twin[side]]
    inward, outward = own[:, :, 1] - own[:, :, 0], other[:, ::-1, 0] - other[:, ::-1, 1]
    np.testing.assert_allclose(inward, outward, atol=1e-13)


def limit_deviation(net, depth):
    """Distance of the limit surface from the patches round vertex 0, in sides of the net."""
    dense, finer = net, net
    for _ in range(4):
        dense = subdivided(dense)
    for _ in range(depth):
        finer = subdivided(finer)
    limit = limit_points(dense).position
    patches = bezier_patches(finer)
    t = np.linspace(0.0, 1.0, 13 if depth == 0 else 7)
    points = evaluated(patches, t, t).reshape(-1, 3)
    normals = np.cross(evaluated(patches, t, t, 1, 0), evaluated(patches, t, t, 0, 1)).reshape(
        -1, 3
    )
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    limit = limit[np.linalg.norm(limit - limit[0], axis=1) < 1.2]
    _, nearest = cKDTree(points).query(limit)
    return np.abs(np.einsum("ij,ij->i", limit - points[nearest], normals[nearest])).max()


@pytest.mark.parametrize(
    ("kind", "k", "bounds"),
    [
        ("smooth", 4, (0.001, 0.001)),
        ("smooth", 3, (0.002, 0.001)),
        ("smooth", 5, (0.005, 0.0025)),
        ("smooth", 6, (0.012, 0.006)),
        ("dart", 4, (0.015, 0.006)),
        ("crease", 3, (0.01, 0.004)),
    ],
)
def test_other_patches_stay_near_the_limit_surface(kind, k, bounds):
    for depth, bound in enumerate(bounds):
        assert limit_deviation(models.fan(kind, k, seed=k), depth) < bound


def test_patches_move_with_the_net_and_scale_with_it():
    net = models.fan("dart", 5, seed=1, noise=0.1)
    rotation = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    plain = bezier_patches(net)
    for scale in (1e-3, 1.0, 1e3):
        moved = scale * net.vertices @ rotation.T + scale * np.array([3.0, -2.0, 5.0])
        image = bezier_patches(CreasedNet(moved, net.quads, net.creases, net.corners))
        expected = scale * (plain @ rotation.T + [3.0, -2.0, 5.0])
        np.testing.assert_allclose(image, expected, rtol=0.0, atol=1e-13 * scale * 20)
