"""Few surfaces, whole borders, no gaps."""

from math import comb

import creased_models as models
import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from crispline.spline.bezier import bezier_patches, corner_points, is_exact
from crispline.spline.creased import CreasedNet, PolygonNet, subdivided
from crispline.spline.joins import measure_joins
from crispline.spline.pieces import spline_controls
from crispline.spline.quilt import quilt
from crispline.spline.rectangles import rectangles
from crispline.spline.sectors import net_sectors, next_corner
from crispline.surface.basis import uniform_knots

NONE, NO_CORNERS = models.NONE, models.NO_CORNERS


def ragged_sphere(nets, n, seed=0):
    vertices, quads = nets.sphere(n)
    noise = 0.02 / n * np.random.default_rng(seed).normal(size=vertices.shape)
    return CreasedNet(vertices + noise, quads, NONE, NO_CORNERS)


def crossed_grid(nets):
    """A grid with a crease that ends inside, and one that runs diagonally by steps."""
    net = models.open_grid(nets, 16, 14, seed=4, noise=0.1)
    index = np.arange(16 * 14).reshape(16, 14)
    straight = np.stack([index[:8, 10], index[1:9, 10]], axis=1)
    i = np.arange(3, 9)
    steps = [[index[i, i], index[i + 1, i]], [index[i + 1, i], index[i + 1, i + 1]]]
    creases = np.concatenate([straight, *(np.stack(pair, axis=1) for pair in steps)])
    return CreasedNet(net.vertices, net.quads, creases, net.corners)


def triangulated_diagonal(nets):
    """A grid whose quads on the diagonal are cut into triangles, creased along it."""
    vertices, quads = nets.plane(6, 6)
    vertices[:, 2] = 0.5 * np.abs(vertices[:, 0] - vertices[:, 1])
    faces = []
    for quad in quads.tolist():
        is_cut = quad[0] % 7 == 0
        faces += [quad[:3], [quad[0], *quad[2:]]] if is_cut else [quad]
    creases = np.stack([np.arange(0, 35, 7), np.arange(7, 36, 7)], axis=1)
    sizes = np.array([len(face) for face in faces])
    corners = np.array([0, 5, 30, 35])
    return subdivided(PolygonNet(vertices, np.concatenate(faces), sizes, creases, corners))


def samples(nets):
    torus = CreasedNet(*nets.torus(12, 7), NONE, NO_CORNERS)
    return {
        "torus": (torus, 0),
        "sphere": (ragged_sphere(nets, 6), 2),
        "cube": (models.sharp_box(nets, 3), 2),
        "grid": (models.open_grid(nets, 6, 5, seed=0), 1),
        "creases": (crossed_grid(nets), 1),
        "diagonal": (triangulated_diagonal(nets), 1),
    }


NAMES = ("torus", "sphere", "cube", "grid", "creases", "diagonal")


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("name", NAMES)
def test_surfaces_meet_without_a_gap_on_the_right_topology(nets, name, depth):
    net, euler = samples(nets)[name]
    covered = quilt(net, depth)
    n_vertices, n_edges, n_faces = (len(covered.vertices), len(covered.edges), len(covered.faces))
    assert n_vertices - n_edges + n_faces == euler
    joins = measure_joins(covered)
    assert joins.largest_gap < 1e-13 * np.abs(net.vertices).max() * 10
    assert covered.is_closed == (euler != 1)


@pytest.mark.parametrize("name", NAMES)
def test_every_border_is_walked_once_round(nets, name):
    covered = quilt(samples(nets)[name][0])
    sides = [[] for _ in covered.faces]
    for edge in covered.edges:
        for side in (edge.left, edge.right):
            if side is not None:
                length = np.abs(np.subtract(side.end, side.start)).sum()
                sides[side.face].append((side.place, length))
    for face, walked in zip(covered.faces, sides, strict=True):
        at = 0
        for place, length in sorted(walked):
            assert place == at
            at += length
        low, high = face.domain
        assert at == 2 * (high - low).sum()


@pytest.mark.parametrize("name", NAMES)
def test_edges_start_and_end_at_their_vertices(nets, name):
    covered = quilt(samples(nets)[name][0])
    for edge in covered.edges:
        ends = edge.curve.evaluate(np.array([edge.curve.start, edge.curve.end]))
        expected = covered.vertices[[edge.start, edge.end]]
        np.testing.assert_allclose(ends, expected, atol=1e-14 * np.abs(expected).max())


def test_few_surfaces_where_the_net_is_regular(nets):
    counts = {name: len(quilt(net).faces) for name, (net, _) in samples(nets).items()}
    assert counts["grid"] == 1
    assert counts["torus"] == 4  # no surface meets itself
    assert counts["cube"] == 6
    assert counts["sphere"] == 6  # eight vertices are not regular: corners of the surfaces


def test_smooth_joins_are_nearly_smooth(nets):
    net = ragged_sphere(nets, 8)
    kinks = [np.degrees(measure_joins(quilt(net, depth)).largest_kink) for depth in (0, 1, 2)]
    assert kinks[0] < 1.5
    assert kinks[1] < 0.6 * kinks[0]
    assert kinks[2] < 0.7 * kinks[1]


def test_creases_keep_their_angle(nets):
    joins = measure_joins(quilt(models.sharp_box(nets, 2)))
    assert joins.is_sharp.all()
    assert joins.angle == pytest.approx(np.pi / 2)


def bezier_values(patches, ticks):
    """Points of Bezier patches at all pairs of some parameters."""
    basis = np.stack([comb(3, k) * ticks**k * (1 - ticks) ** (3 - k) for k in range(4)], axis=1)
    return np.einsum("ai,bj,mijx->mabx", basis, basis, patches).reshape(-1, 3)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("depth", [0, 1])
def test_surfaces_hold_the_patches_of_their_quads(nets, name, depth):
    net = samples(nets)[name][0]
    covered, finer = quilt(net, depth), subdivided(net) if depth else net
    exact = np.repeat(is_exact(net_sectors(net)), 4**depth)
    # Parameters of the pieces and of their quads that stay the same under turns.
    piece_ticks = np.array([0.125, 0.5, 0.875])
    ticks = np.concatenate([(piece_ticks + k) / 2**depth for k in range(2**depth)])
    expected = bezier_values(bezier_patches(finer), piece_ticks)
    if depth:  # an exact quad is one polynomial
        plain = bezier_values(bezier_patches(net)[exact[::4]], ticks)
        expected = np.concatenate([expected[~np.repeat(exact, 9)], plain])
    found = []
    for face in covered.faces:
        n_u, n_v = (int(high) for high in face.domain[1])
        u, v = (np.add.outer(np.arange(n), ticks).ravel() for n in (n_u, n_v))
        found.append(face.evaluate(*(grid.ravel() for grid in np.meshgrid(u, v))))
    found = np.concatenate(found)
    assert len(found) == len(expected)
    size = np.abs(expected).max()
    assert cKDTree(found).query(expected)[0].max() < 1e-13 * size
    assert cKDTree(expected).query(found)[0].max() < 1e-13 * size
    assert np.bincount(covered.face_of_quad, minlength=len(covered.faces)).tolist() == [
        int(np.prod(face.domain[1])) for face in covered.faces
    ]
    quads = np.bincount(covered.face_of_quad, ~exact[:: 4**depth])
    assert (quads[: covered.n_exact] == 0).all()
    assert (quads[covered.n_exact :] > 0).all()


@pytest.mark.parametrize("name", NAMES)
def test_vertices_that_are_not_regular_are_corners_of_surfaces(nets, name):
    net = samples(nets)[name][0]
    sectors = net_sectors(net)
    covered = quilt(net)
    used = {tuple(point) for point in covered.vertices}
    odd = np.unique(sectors.vertex[~sectors.is_regular])
    positions = corner_points(net).position[odd]
    assert all(tuple(point) in used for point in positions)


@pytest.mark.parametrize("name", NAMES)
def test_rectangles_part_the_net(nets, name):
    net = samples(nets)[name][0]
    sectors = net_sectors(net)
    is_smooth = ~sectors.sides.is_sharp[sectors.sides.of_half_edge]
    regular = sectors.is_regular[sectors.of_corner]
    corner = np.arange(len(regular))
    may_merge = is_smooth & regular & regular[next_corner(corner)]
    blocks = rectangles(sectors.twin, may_merge)
    members = np.concatenate([block.ravel() for block in blocks]) // 4
    np.testing.assert_array_equal(np.sort(members), np.arange(len(net.quads)))
    for block in blocks:
        across = sectors.twin[block]  # below each quad: the one under it in the block
        np.testing.assert_array_equal(across[:, 1:] // 4, block[:, :-1] // 4)
        beside = next_corner(block[:-1])  # to the right of each
        np.testing.assert_array_equal(sectors.twin[beside] // 4, block[1:] // 4)
        assert may_merge[beside].all()
        assert may_merge[block[:, 1:]].all()
        outside = across[:, 0]
        assert not np.isin(outside[outside >= 0] // 4, block // 4).any()


def test_the_same_net_gives_the_same_quilt(nets):
    net = crossed_grid(nets)
    one, other = quilt(net), quilt(net)
    for a, b in zip(one.faces, other.faces, strict=True):
        np.testing.assert_array_equal(a.control_points, b.control_points)
    assert [e.left for e in one.edges] == [e.left for e in other.edges]


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_controls_of_a_uniform_spline_come_back_from_its_pieces(n):
    controls = np.random.default_rng(n).normal(size=(n + 3, 2))
    spline = BSpline(uniform_knots(0.0, n, n), controls, 3)
    pieces = np.empty((3 * n + 1, 2))
    at, slope = spline(np.arange(n + 1.0)), spline(np.arange(n + 1.0), 1)
    pieces[::3] = at
    pieces[1::3], pieces[2::3] = (at + slope / 3)[:-1], (at - slope / 3)[1:]
    np.testing.assert_allclose(
        spline_controls(pieces, uniform_knots(0.0, n, n)), controls, atol=1e-12
    )
