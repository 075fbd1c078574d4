import numpy as np
import pytest

from crispline.paper.patches import Patches, spline_patches
from crispline.paper.windows import FEATURES, windows
from crispline.spline.tensor import TensorSpline, spline_over_grid


def wavy_spline():
    stream = np.random.default_rng(3)
    x, y = np.meshgrid(np.arange(7.0), np.arange(9.0), indexing="ij")
    return spline_over_grid(np.stack([x, y, stream.normal(scale=0.4, size=x.shape)], axis=2))


def plane_patch(origin, u_axis, v_axis):
    share = np.arange(4.0) / 3.0
    along = share[:, None, None] * np.asarray(u_axis) + share[None, :, None] * np.asarray(v_axis)
    return np.asarray(origin, dtype=float) + along


@pytest.mark.parametrize("has_crease", [False, True])
def test_patches_are_the_spline(has_crease):
    spline = wavy_spline()
    if has_crease:
        spline = spline.with_knot_u(2.4, 3).with_knot_v(3.0, 3)
        moved = spline.control_points.copy()
        moved[4] += (0.0, 0.0, 0.7)
        spline = TensorSpline(3, 3, spline.knots_u, spline.knots_v, moved)
    patches = spline_patches(spline)
    spans_u, spans_v = 6 + has_crease, 8
    assert len(patches.control_points) == spans_u * spans_v
    knots_u = np.unique(spline.knots_u.clip(0.0, 6.0))
    knots_v = np.unique(spline.knots_v.clip(0.0, 8.0))
    index, u, v = patches.lattice(3, with_borders=False)
    i, j = np.divmod(index, spans_v)
    at_u = knots_u[i] + u * np.diff(knots_u)[i]
    at_v = knots_v[j] + v * np.diff(knots_v)[j]
    expected = spline.evaluate(at_u, at_v)
    np.testing.assert_allclose(patches.evaluate(index, u, v), expected, atol=1e-12)


def test_patches_over_missing_points_are_left_out():
    window = windows("corner", 0.25)[0]
    patches = spline_patches(spline_over_grid(window.points))
    assert np.isfinite(patches.control_points).all()
    assert 0 < len(patches.control_points) < window.is_patch.sum()


@pytest.mark.parametrize(("du", "dv"), [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
def test_derivatives_agree_with_differences(du, dv):
    patches = spline_patches(wavy_spline())
    index, u, v = patches.lattice(3, with_borders=False)
    step = 1e-5
    lower = (du - (du > 0), dv - (du == 0))
    shift = (step, 0.0) if du > 0 else (0.0, step)
    ahead = patches.evaluate(index, u + shift[0], v + shift[1], *lower)
    behind = patches.evaluate(index, u - shift[0], v - shift[1], *lower)
    expected = (ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(patches.evaluate(index, u, v, du, dv), expected, atol=1e-8)


def test_samples_add_up_to_the_area():
    patch = plane_patch((1.0, 2.0, 3.0), (2.0, 0.0, 0.0), (0.0, 0.0, 3.0))
    points, areas = Patches(patch[None]).samples(4)
    assert areas.sum() == pytest.approx(6.0)
    np.testing.assert_allclose(np.average(points, axis=0, weights=areas), (2.0, 2.0, 4.5))


def test_distance_to_a_square_from_all_around():
    """Feet inside, on the sides and at the corners, where the parameters meet their bounds."""
    patches = Patches(plane_patch((0.0, 0.0, 0.0), (2.0, 0.0, 0.0), (0.5, 1.0, 0.0))[None])
    stream = np.random.default_rng(0)
    points = stream.uniform(-3.0, 5.0, size=(500, 3))
    sheared = np.column_stack([points[:, 0] - 0.5 * points[:, 1], points[:, 1]])
    inside = ((sheared >= 0.0) & (sheared <= (2.0, 1.0))).all(axis=1)
    corners = np.array([(0.0, 0.0), (2.0, 0.0), (2.5, 1.0), (0.5, 1.0)])
    flat = np.full(len(points), np.inf)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = end - start
        share = np.clip((points[:, :2] - start) @ along / (along @ along), 0.0, 1.0)
        foot = start + share[:, None] * along
        flat = np.minimum(flat, np.linalg.norm(points[:, :2] - foot, axis=1))
    expected = np.hypot(np.where(inside, 0.0, flat), points[:, 2])
    np.testing.assert_allclose(patches.distances(points), expected, atol=1e-9)


@pytest.mark.parametrize("feature", FEATURES)
def test_distance_agrees_with_dense_sampling(feature):
    """A naive twin: the nearest of very many samples, which is never nearer than the foot."""
    stream = np.random.default_rng(5)
    window = windows(feature, 0.25)[1].noisy(0.05, stream)
    patches = spline_patches(spline_over_grid(window.points))
    points = window.samples[::20] + stream.normal(scale=0.5, size=(len(window.samples[::20]), 3))
    samples = patches.evaluate(*patches.lattice(60, with_borders=True))
    dense = np.array([np.linalg.norm(samples - point, axis=1).min() for point in points])
    excess = dense - patches.distances(points)
    assert excess.min() > -1e-12
    assert excess.max() < 5e-3


def test_points_of_the_surface_have_distance_zero():
    patches = spline_patches(wavy_spline().with_knot_u(2.4, 3))
    on_it = patches.evaluate(*patches.lattice(7, with_borders=True))
    assert patches.distances(on_it).max() < 1e-9


def test_the_foot_on_a_crease_is_found_from_both_sides():
    """A roof: beneath its ridge the two sides are equally near, above it the ridge is."""
    left = plane_patch((-1.0, 0.0, 0.0), (1.0, 0.0, 1.0), (0.0, 3.0, 0.0))
    right = plane_patch((0.0, 0.0, 1.0), (1.0, 0.0, -1.0), (0.0, 3.0, 0.0))
    patches = Patches(np.stack([left, right]))
    above = np.array([(0.0, 1.3, 1.5), (0.1, 0.4, 1.4), (0.0, 1.0, 1.0)])
    ridge = np.hypot(above[:, 0], above[:, 2] - 1.0)
    np.testing.assert_allclose(patches.distances(above), ridge, atol=1e-12)
    beneath = patches.distances(np.array([[0.0, 1.5, 0.5]]))
    np.testing.assert_allclose(beneath, 0.5 / np.sqrt(2.0), atol=1e-12)


def test_thin_patches_beside_a_crease_do_not_hide_the_nearest_one():
    """A knot close to another leaves a sliver whose samples all crowd round its points."""
    spline = wavy_spline()
    stream = np.random.default_rng(7)
    points = np.column_stack([stream.uniform(0.5, 5.5, 60), stream.uniform(0.5, 7.5, 60)])
    points = np.column_stack([points, stream.normal(scale=0.5, size=60)])
    split = spline.with_knot_u(2.0 + 1e-4, 3).with_knot_v(3.0 - 1e-3, 3)
    expected = spline_patches(spline).distances(points)
    np.testing.assert_allclose(spline_patches(split).distances(points), expected, atol=1e-9)


def test_a_patch_that_is_a_line_or_a_point_does_no_harm():
    line = plane_patch((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    point = plane_patch((5.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    distances = Patches(np.stack([line, point])).distances(
        np.array([(0.5, 2.0, 0.0), (6.0, 0.0, 0.0)])
    )
    np.testing.assert_allclose(distances, (2.0, 1.0), atol=1e-9)
