"""Located edges and corners, and the surfaces with them: exact without noise, close with."""

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.grid import curvature, detect, locate, preserve, sharpen
from crispline.options import SharpenOptions
from crispline.spline.bezier import bezier_patches
from crispline.spline.creased import PolygonNet, subdivided
from crispline.spline.joins import measure_joins
from crispline.spline.quilt import quilt
from crispline.spline.tensor import TensorSpline, spline_over_grid

PHASES = np.linspace(0.0, 0.5, 6)


def crease_knots(knots):
    return [x for x in np.unique(knots) if (knots == x).sum() == 3]


def off_the_edge(points):
    """Distance from the edge of `folded`."""
    return np.hypot(points[:, 0], points[:, 2])


def on_crease(spline, n=100):
    (level,) = crease_knots(spline.knots_v)
    low, high = spline.domain[0]
    return spline.evaluate(np.linspace(low, high, n), np.full(n, level))


@pytest.mark.parametrize("phase", PHASES)
def test_a_straight_edge_is_exact_without_noise(grids, phase):
    result = sharpen(grids.folded(phase))
    assert isinstance(result.surface, TensorSpline)
    assert off_the_edge(result.located).max() < 1e-9
    assert off_the_edge(on_crease(result.surface)).max() < 1e-9
    vertices, _ = result.mesh(3)
    # The whole surface is on the two planes, not only its crease.
    assert np.minimum(np.abs(vertices[:, 0]), np.abs(vertices[:, 2])).max() < 1e-9


@pytest.mark.parametrize("phase", [0.0, 0.3, 0.5])
def test_a_circle_is_exact_to_two_ten_thousandths(grids, phase):
    crease = on_crease(sharpen(grids.rim(phase)).surface)
    error = np.hypot(np.hypot(crease[:, 0], crease[:, 1]) - 25.0, crease[:, 2])
    assert error.max() < 2e-4
    assert error.mean() < 2e-5


@pytest.mark.parametrize("phase", PHASES)
def test_two_per_cent_of_noise_leave_little_error(grids, phase):
    errors = [
        off_the_edge(on_crease(sharpen(grids.noisy(grids.folded(phase), 0.02, seed)).surface))
        for seed in range(4)
    ]
    assert np.mean(errors) < 0.06


@pytest.mark.parametrize("phase", [0.0, 0.2, 0.5])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_corner_is_exact_without_noise(grids, phase, turn):
    result = sharpen(grids.corner(phase, turn))
    assert isinstance(result.surface, PolygonNet)
    np.testing.assert_allclose(result.corners, np.zeros((1, 3)), atol=1e-9)
    assert len(result.edges) == 3
    for edge in result.edges:
        assert np.sort(np.abs(edge), axis=1)[:, :2].max() < 1e-9


def test_a_corner_in_noise(grids):
    for seed in range(3):
        result = sharpen(grids.noisy(grids.corner(0.2), 0.02, seed))
        assert len(result.corners) == 1
        assert np.linalg.norm(result.corners[0]) < 0.15


@pytest.mark.parametrize("slope", [0.1, 0.6, 1.0, 2.3])
def test_a_diagonal_edge_has_no_gap_and_no_error(grids, slope):
    def roof(i, j):
        return -np.abs(i - slope * (j - 11.4) - 11.7)

    result = sharpen(grids.heights(roof))
    vertices, _ = result.mesh(3)
    np.testing.assert_allclose(vertices[:, 2], roof(*vertices.T[:2]), atol=1e-9)
    net = subdivided(result.surface)
    patches = bezier_patches(net)
    assert np.isfinite(patches).all()
    assert measure_joins(quilt(net)).largest_gap < 1e-9


def test_edges_that_cross_along_the_rows_stay_one_tensor_product(grids):
    def hip(i, j):
        return -np.abs(i - 11.3) - np.abs(j - 8.7)

    result = sharpen(grids.heights(hip))
    assert crease_knots(result.surface.knots_u) == pytest.approx([11.3])
    assert crease_knots(result.surface.knots_v) == pytest.approx([8.7])
    vertices, _ = result.mesh(3)
    np.testing.assert_allclose(vertices[:, 2], hip(*vertices.T[:2]), atol=1e-9)
    np.testing.assert_allclose(result.corners, [[11.3, 8.7, 0.0]], atol=1e-9)


def test_parallel_edges(grids):
    def zigzag(i, j):
        return -np.abs(j - 5.2) + np.abs(j - 11.7) - np.abs(j - 18.0)

    result = sharpen(grids.heights(zigzag))
    assert crease_knots(result.surface.knots_v) == pytest.approx([5.2, 11.7, 18.0])
    vertices, _ = result.mesh(2)
    np.testing.assert_allclose(vertices[:, 2], zigzag(*vertices.T[:2]), atol=1e-9)


def test_four_edges_meet_in_one_corner(grids):
    def pyramid(i, j):
        return -np.maximum(np.abs(i - 11.3), np.abs(j - 11.7))

    result = sharpen(grids.heights(pyramid))
    np.testing.assert_allclose(result.corners, [[11.3, 11.7, 0.0]], atol=1e-9)
    assert len(result.edges) == 4
    vertices, _ = result.mesh(3)
    np.testing.assert_allclose(vertices[:, 2], pyramid(*vertices.T[:2]), atol=1e-9)


def test_an_edge_may_end_inside(grids):
    """A fold that fades out: sharp at its beginning, smooth at its end, whole all along."""

    def fading(i, j):
        return -0.5 * (1.0 + np.cos(np.pi * np.clip(i / 28.0, 0.0, 1.0))) * np.abs(j - 8.7)

    result = sharpen(grids.heights(fading, 18, 36))
    (edge,) = result.edges
    assert 10 < len(edge) < 30
    np.testing.assert_allclose(np.abs(edge[:, 1] - 8.7), 0.0, atol=0.02)
    net = subdivided(result.surface)
    assert measure_joins(quilt(net)).largest_gap < 1e-9
    vertices, _ = result.mesh(3)
    assert np.abs(vertices[:, 2] - fading(*vertices.T[:2])).max() < 0.35


def test_nothing_changes_two_spans_away(grids):
    points = grids.noisy(grids.heights(lambda i, j: -np.abs(j - 8.7)), 0.01)
    plain = spline_over_grid(points)
    for surface in (points, plain):
        result = sharpen(surface)
        rng = np.random.default_rng(0)
        u, v = rng.uniform(0, 23, (2, 3000))
        v = v[far := np.abs(v - 8.7) > 2.4]
        np.testing.assert_allclose(
            result.surface.evaluate(u[far], v), plain.evaluate(u[far], v), atol=1e-12
        )


@pytest.fixture
def uneven():
    """A bicubic surface over uneven clamped knots, folded at v = 8.7 but for its roundness."""
    rng = np.random.default_rng(1)
    inner_u = np.sort(rng.uniform(1, 22, 18))
    inner_v = np.linspace(1, 22, 22) + rng.uniform(-0.3, 0.3, 22)
    knots = [np.r_[[0.0] * 4, inner, [23.0] * 4] for inner in (inner_u, inner_v)]
    u, v = np.meshgrid(*((k[1:-3] + k[2:-2] + k[3:-1]) / 3 for k in knots), indexing="ij")
    return TensorSpline(3, 3, *knots, np.stack([u, v, -np.abs(v - 8.7)], axis=2))


@pytest.mark.parametrize("is_rational", [False, True])
def test_a_given_surface_with_any_knots_and_weights(uneven, is_rational):
    net = uneven.control_points
    weights = np.ones(net.shape[:2]) * np.linspace(0.8, 1.25, net.shape[1]) if is_rational else None
    surface = TensorSpline(3, 3, uneven.knots_u, uneven.knots_v, net, weights)
    result = sharpen(surface)
    assert (result.surface.weights is not None) == is_rational
    vertices, _ = result.mesh(3)
    np.testing.assert_allclose(vertices[:, 2], -np.abs(vertices[:, 1] - 8.7), atol=1e-9)
    u, v = np.random.default_rng(0).uniform(0, 23, (2, 3000))
    far = np.abs(v - 8.7) > 4.0
    np.testing.assert_allclose(
        result.surface.evaluate(u[far], v[far]), surface.evaluate(u[far], v[far]), atol=1e-12
    )


def test_a_diagonal_edge_of_a_given_surface(grids):
    def roof(i, j):
        return -np.abs(i - 0.6 * j - 4.3)

    result = sharpen(spline_over_grid(grids.heights(roof)))
    assert result.resampling_error < 1e-9
    vertices, _ = result.mesh(3)
    np.testing.assert_allclose(vertices[:, 2], roof(*vertices.T[:2]), atol=1e-9)


@pytest.mark.parametrize("phase", [0.3, 0.4, 0.5])
def test_the_planes_of_the_paper(grids, phase):
    result = sharpen(grids.folded(phase), SharpenOptions(rule="paper"))
    assert off_the_edge(result.located).max() < 1e-9
    assert off_the_edge(on_crease(result.surface)).max() < 1e-9


@pytest.mark.parametrize("repeat", [1, 2])
def test_fewer_repetitions_stay_smooth(grids, repeat):
    result = sharpen(grids.folded(0.4), SharpenOptions(repeat=repeat))
    knots = result.surface.knots_v
    assert max((knots == x).sum() for x in knots) == repeat
    plain = spline_over_grid(grids.folded(0.4))
    v = np.linspace(0, plain.domain[1][1], 400)
    edge = [off_the_edge(s.evaluate(np.full(400, 4.0), v)).min() for s in (plain, result.surface)]
    assert edge[1] < edge[0]


def test_the_steps_one_by_one_are_what_sharpen_does(grids):
    points = grids.noisy(grids.corner(0.2), 0.01)
    found = detect(points, curvature(points))
    located = locate(points, found)
    net = preserve(points, located)
    np.testing.assert_array_equal(net.vertices, sharpen(points).surface.vertices)


def test_invalid_pixels_leave_a_hole(grids):
    points = grids.heights(lambda i, j: -np.abs(j - 8.7))
    points[10:13, 15:18] = np.nan
    points[4, 8] = np.inf
    result = sharpen(points)
    vertices, _ = result.mesh(2)
    np.testing.assert_allclose(vertices[:, 2], -np.abs(vertices[:, 1] - 8.7), atol=1e-9)
    inside = (np.abs(vertices[:, 0] - 11) < 1.4) & (np.abs(vertices[:, 1] - 16) < 1.4)
    assert not inside.any()


def test_diagonal_holes_touch_nowhere(grids):
    points = grids.heights(lambda i, j: 0.0 * i, 12)
    points[3, 4] = points[5, 6] = points[8, 2] = points[6, 4] = np.nan
    net = subdivided(sharpen(points).surface)
    assert measure_joins(quilt(net)).largest_gap < 1e-9


@pytest.mark.parametrize(
    ("points", "text"),
    [
        (np.zeros((5, 3)), "shape (m, n, 3)"),
        (np.zeros((3, 9, 3)), "at least 4 x 4"),
        (np.ones((6, 6, 3)), "all points at one place"),
        (np.full((6, 6, 3), np.nan), "without a single finite one"),
        (np.arange(6.0)[:, None, None] * np.ones((6, 6, 3)), "on a line"),
        ([["a", "b"], ["c", "d"]], "array of numbers"),
        ([[1.0, 2.0], [3.0]], "array of numbers"),
    ],
)
def test_bad_grids_are_told_in_one_sentence(points, text):
    with pytest.raises(InputError) as told:
        sharpen(points)
    assert text in str(told.value)
    assert "\n" not in str(told.value)


def test_scattered_pixels_and_tiny_surfaces_are_told(grids):
    points = np.full((9, 9, 3), np.nan)
    points[::2, ::2] = 1.0
    with pytest.raises(InputError, match="no four valid points"):
        sharpen(points)
    tiny = spline_over_grid(grids.heights(lambda i, j: 0 * i, 3))
    with pytest.raises(InputError, match="knot spans"):
        sharpen(tiny)
