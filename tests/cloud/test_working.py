"""The working frame: same numbers in every unit, and estimates against exact truth."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from crispline.cloud.scale import N_NEIGHBOURS, local_noise, point_spacing
from crispline.cloud.working import working_cloud
from crispline.errors import InputError
from crispline.options import CloudOptions
from crispline.shapes import SHAPES, sample


def working(points):
    return working_cloud(np.asarray(points, dtype=float), CloudOptions())


def rotation(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


def plane(n, rng):
    return np.column_stack([rng.uniform(0.0, np.sqrt(n), (n, 2)), np.zeros(n)])


def sphere(n, rng):
    directions = rng.normal(size=(n, 3))
    return np.sqrt(n / (4 * np.pi)) * directions / np.linalg.norm(directions, axis=1)[:, None]


def lump(n=600, seed=0):
    """A closed surface without any symmetry."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(n, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    x, y, z = directions.T
    radius = 1.0 + 0.1 * x + 0.1 * y * z + 0.1 * z**3
    return radius[:, None] * directions * [1.5, 1.2, 1.0]


def neighbourhoods(points, k=N_NEIGHBOURS):
    return cKDTree(points).query(points, k=k)


# --- the frame ----------------------------------------------------------------------------


@given(exponent=st.floats(-3, 3), shift=st.floats(-1e6, 1e6), seed=st.integers(0, 100))
@example(exponent=-3.0, shift=1e6, seed=0)
@example(exponent=3.0, shift=-1e6, seed=1)
@settings(max_examples=20)
def test_does_not_depend_on_unit_place_or_direction(exponent, shift, seed):
    points, scale = lump(), 10.0**exponent
    moved = scale * points @ rotation(seed).T + shift
    one, other = working(points), working(moved)
    # What a double keeps of a small part far away, in spacings.
    lost = 4.0 * np.spacing(abs(shift)) / other.spacing
    np.testing.assert_allclose(other.points, one.points, atol=1e-6 + lost)
    np.testing.assert_array_equal(other.neighbours[:, :8], one.neighbours[:, :8])
    assert other.spacing == pytest.approx(scale * one.spacing, rel=1e-6)
    assert other.sigma == pytest.approx(one.sigma, rel=1e-5)
    np.testing.assert_allclose(
        other.to_user.points(other.points), moved, atol=1e-6 * other.spacing + np.spacing(2e6)
    )


@pytest.mark.parametrize("sampling", ["grid", "half-cell", "random"])
@pytest.mark.parametrize(("scale", "shift"), [(1e-3, 0.0), (1e3, 0.0), (1.0, 1e6)])
def test_a_symmetric_part_has_the_same_axes_in_every_unit(sampling, scale, shift):
    """Equal moments: the axes must not follow the rounding errors."""
    points = sample(SHAPES["box-cylinder"](), 1500, sampling=sampling).points
    one, other = working(points), working(scale * points + shift)
    np.testing.assert_allclose(other.points, one.points, atol=1e-6)


def test_frame_is_centred_right_handed_and_of_spacing_one():
    cloud = working(lump())
    np.testing.assert_allclose(cloud.points.mean(axis=0), 0.0, atol=1e-6)
    moments = np.cov(cloud.points.T)
    np.testing.assert_allclose(moments, np.diag(np.diag(moments)), atol=1e-3)
    assert (np.diff(np.diag(moments)) < 0.0).all()
    assert np.linalg.det(cloud.to_user.rotation) == pytest.approx(1.0)
    assert point_spacing(cloud.distances) == pytest.approx(1.0)
    np.testing.assert_array_equal(cloud.neighbours[:, 0], np.arange(len(cloud.points)))


# --- what is left out ---------------------------------------------------------------------


def test_duplicates_and_outliers_are_counted_and_gone():
    points = lump()
    stray = np.array([[3.0, 0.0, 0.0], [0.0, -2.5, 0.0], [0.1, 0.0, 0.0]])
    cloud = working(np.concatenate([points[:10], points, stray, points[300:320]]))
    assert (cloud.n_duplicates, cloud.n_outliers) == (30, 3)
    assert len(cloud.points) == len(points)
    np.testing.assert_allclose(cloud.to_user.points(cloud.points), points, atol=1e-6)
    assert cloud.warnings(7) == (
        "7 points with coordinates that are not finite were left out",
        "30 points that repeat another point were left out",
        "3 points far from all others (outliers) were left out",
    )


def test_a_clean_cloud_has_no_warnings():
    assert working(lump()).warnings() == ()


@given(seed=st.integers(0, 1000))
@settings(max_examples=15)
def test_order_of_the_points_does_not_matter(seed):
    points = lump()
    order = np.random.default_rng(seed).permutation(len(points))
    one, other = working(points), working(points[order])
    np.testing.assert_allclose(other.points, one.points[order], atol=1e-6)
    assert other.spacing == pytest.approx(one.spacing, rel=1e-12)
    assert other.sigma == pytest.approx(one.sigma, rel=1e-5)


# --- spacing and noise --------------------------------------------------------------------


@pytest.mark.parametrize("surface", [plane, sphere])
@pytest.mark.parametrize("seed", range(3))
def test_spacing_of_random_points_within_three_per_cent(surface, seed):
    points = surface(5000, np.random.default_rng(seed))
    assert point_spacing(neighbourhoods(points)[0]) == pytest.approx(1.0, rel=0.03)


@pytest.mark.parametrize(
    "basis",
    [[[1, 0], [0, 1]], [[1, 0], [0.5, 0.75**0.5]], [[1, 0], [0, 1.5]]],
    ids=["square", "triangular", "oblong"],
)
def test_spacing_of_grids_within_six_per_cent(basis):
    basis = np.array(basis) / np.sqrt(abs(np.linalg.det(basis)))  # one point per unit of area
    i, j = np.mgrid[:70, :70]
    flat = np.column_stack([i.ravel(), j.ravel()]) @ basis
    points = np.column_stack([flat, np.zeros(len(flat))])
    assert point_spacing(neighbourhoods(points)[0]) == pytest.approx(1.0, rel=0.06)


@pytest.mark.parametrize("surface", [plane, sphere])
@pytest.mark.parametrize("sigma", [0.05, 0.1, 0.2, 0.3])
def test_noise_within_five_per_cent(surface, sigma):
    rng = np.random.default_rng(0)
    points = surface(5000, rng)
    normals = np.tile([0.0, 0.0, 1.0], (5000, 1))
    if surface is sphere:
        normals = points / np.linalg.norm(points, axis=1, keepdims=True)
    points = points + sigma * rng.normal(size=(5000, 1)) * normals
    assert local_noise(points, neighbourhoods(points)[1]) == pytest.approx(sigma, rel=0.05)


def test_noise_has_no_bias():
    """Many neighbourhoods that share no point."""
    rng = np.random.default_rng(0)
    flat = rng.uniform(0.0, 5.0, (20_000, 24, 2))
    points = np.concatenate([flat, 0.1 * rng.normal(size=(20_000, 24, 1))], axis=2).reshape(-1, 3)
    neighbours = np.repeat(np.arange(20_000 * 24).reshape(-1, 24), 24, axis=0)
    noise = local_noise(points, neighbours, n_samples=20_000)
    assert noise == pytest.approx(0.1, rel=0.01)


def test_noise_of_a_quadric_without_noise_is_zero():
    rng = np.random.default_rng(0)
    x, y = rng.uniform(-10.0, 10.0, (2, 500))
    points = np.column_stack([x, y, 0.05 * x**2 - 0.02 * x * y])
    assert local_noise(points, neighbourhoods(points)[1]) < 0.02


def test_noise_drawn_from_a_part_of_the_points_is_nearly_that_of_all():
    rng = np.random.default_rng(0)
    points = plane(5000, rng) + [0.0, 0.0, 0.1] * rng.normal(size=(5000, 3))
    neighbours = neighbourhoods(points)[1]
    whole = local_noise(points, neighbours, n_samples=5000)
    assert local_noise(points, neighbours, n_samples=1000) == pytest.approx(whole, rel=0.05)


# --- refusals -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("points", "message"),
    [
        (lump()[:23], "at least 24 points, the cloud has 23"),
        (np.repeat(lump()[:23], 10, axis=0), "at least 24 points, the cloud has 23"),
        (np.full((100, 3), 1e6 / 3.0), "all points of the cloud are equal"),
        (np.linspace(0, 1, 100)[:, None] * [1.0, 2.0, 3.0] + 1e3, "on one line"),
        (plane(100, np.random.default_rng(0)), "in one plane"),
        (plane(100, np.random.default_rng(0)) @ rotation(0).T + 1e3, "in one plane"),
    ],
    ids=["too few", "too few distinct", "equal", "line", "plane", "tilted plane"],
)
def test_refuses_clouds_that_span_no_volume(points, message):
    with pytest.raises(InputError, match=message) as caught:
        working(points)
    assert caught.value.exit_code == 2


def test_a_plane_with_a_few_outliers_is_still_a_plane():
    flat = plane(400, np.random.default_rng(0))
    with pytest.raises(InputError, match="in one plane"):
        working(np.concatenate([flat, [[10.0, 10.0, 100.0]]]))


@pytest.mark.parametrize("wall", [2.0, 2.5, 3.0])
def test_the_other_side_of_a_thin_wall_is_no_noise(wall):
    rng = np.random.default_rng(0)
    rise = np.array([0.0, 0.0, wall])
    sheets = [plane(4000, rng), plane(4000, rng) + rise]
    points = np.concatenate(sheets) + [0.0, 0.0, 0.1] * rng.normal(size=(8000, 3))
    assert local_noise(points, neighbourhoods(points)[1]) == pytest.approx(0.1, rel=0.3)
