"""Tensor-product B-splines against naive twins, and what must leave a surface unchanged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.errors import InputError
from crispline.spline.tensor import TensorSpline, spline_over_grid

DEGREES = [(3, 3), (1, 3), (2, 1), (5, 4)]


def random_spline(degree_u, degree_v, is_rational=False, is_clamped=True, seed=0):
    rng = np.random.default_rng(seed)
    n_u, n_v = degree_u + 6, degree_v + 4

    def knots(degree, n):
        if is_clamped:
            inner = np.sort(rng.integers(1, 6, n - degree - 1)).astype(float)
            _, counts = np.unique(inner, return_counts=True)
            if len(counts) and counts.max() > degree:
                inner = np.linspace(1.0, 5.0, n - degree - 1)
            return np.concatenate([np.zeros(degree + 1), inner, np.full(degree + 1, 6.0)])
        return np.cumsum(rng.uniform(0.3, 1.5, n + degree + 1)) - 2.0

    weights = rng.uniform(0.4, 2.0, (n_u, n_v)) if is_rational else None
    net = rng.normal(size=(n_u, n_v, 3))
    return TensorSpline(
        degree_u, degree_v, knots(degree_u, n_u), knots(degree_v, n_v), net, weights
    )


def every_kind():
    return [
        pytest.param(random_spline(*d, is_rational=r, is_clamped=c), id=f"{d}-{r}-{c}")
        for d in DEGREES
        for r in (False, True)
        for c in (False, True)
    ]


def places(spline, n=100, seed=3):
    """Paired parameters, the corners of the domain among them."""
    (u0, u1), (v0, v1) = spline.domain
    rng = np.random.default_rng(seed)
    u = np.concatenate([[u0, u0, u1, u1], rng.uniform(u0, u1, n)])
    v = np.concatenate([[v0, v1, v0, v1], rng.uniform(v0, v1, n)])
    return u, v


def cox_de_boor(i, degree, knots, t):
    """The basis function by its recursion, naively."""
    if degree == 0:
        return float(knots[i] <= t < knots[i + 1])
    total = 0.0
    if knots[i + degree] > knots[i]:
        share = (t - knots[i]) / (knots[i + degree] - knots[i])
        total += share * cox_de_boor(i, degree - 1, knots, t)
    if knots[i + degree + 1] > knots[i + 1]:
        share = (knots[i + degree + 1] - t) / (knots[i + degree + 1] - knots[i + 1])
        total += share * cox_de_boor(i + 1, degree - 1, knots, t)
    return total


def naive_point(spline, u, v):
    n_u, n_v = spline.control_points.shape[:2]
    weights = np.ones((n_u, n_v)) if spline.weights is None else spline.weights
    basis = np.outer(
        [cox_de_boor(i, spline.degree_u, spline.knots_u, u) for i in range(n_u)],
        [cox_de_boor(j, spline.degree_v, spline.knots_v, v) for j in range(n_v)],
    )
    basis = basis * weights / np.sum(basis * weights)
    return np.einsum("ij,ijk->k", basis, spline.control_points)


def assert_same_surface(spline, other, atol=1e-12):
    u, v = places(spline)
    np.testing.assert_allclose(other.domain, spline.domain, atol=1e-12)
    np.testing.assert_allclose(other.evaluate(u, v), spline.evaluate(u, v), atol=atol)


@pytest.mark.parametrize("spline", every_kind())
def test_points_are_those_of_the_basis_functions_written_out(spline):
    u, v = (a[4:24] for a in places(spline))
    expected = [naive_point(spline, *uv) for uv in zip(u, v, strict=True)]
    np.testing.assert_allclose(spline.evaluate(u, v), expected, atol=1e-12)


@pytest.mark.parametrize("orders", [(1, 0), (0, 1), (2, 0), (1, 1), (0, 2)])
@pytest.mark.parametrize("is_rational", [False, True])
def test_derivatives_are_the_limits_of_differences(is_rational, orders):
    spline = random_spline(3, 3, is_rational, is_clamped=False, seed=1)
    (u0, u1), (v0, v1) = spline.domain
    rng = np.random.default_rng(2)
    u, v = rng.uniform(u0 + 0.1, u1 - 0.1, 40), rng.uniform(v0 + 0.1, v1 - 0.1, 40)
    # Away from knots, where the third derivative jumps.
    clear_u = np.abs(u[:, None] - spline.knots_u).min(axis=1) > 0.02
    clear_v = np.abs(v[:, None] - spline.knots_v).min(axis=1) > 0.02
    u, v = u[clear_u & clear_v], v[clear_u & clear_v]
    errors = []
    for h in (1e-2, 5e-3):
        axis = 0 if orders[0] else 1
        lower = (orders[0] - 1, orders[1]) if axis == 0 else (orders[0], orders[1] - 1)
        du, dv = (h, 0.0) if axis == 0 else (0.0, h)
        ahead = spline.evaluate(u + du, v + dv, *lower)
        behind = spline.evaluate(u - du, v - dv, *lower)
        difference = (ahead - behind) / (2.0 * h)
        errors.append(np.abs(difference - spline.evaluate(u, v, *orders)).max())
    # Central differences are exact for a parabola, otherwise of second order.
    assert errors[1] < 1e-9 or np.log2(errors[0] / errors[1]) > 1.9


def test_derivatives_above_the_degree_vanish():
    spline = random_spline(2, 1)
    assert not spline.evaluate([1.0, 2.0], [1.0, 2.0], 3, 0).any()
    assert not spline.evaluate([1.0, 2.0], [1.0, 2.0], 0, 2).any()


def test_a_rational_quarter_of_a_cylinder_is_round():
    half = np.sqrt(0.5)
    net = np.array([[[1, 0, 0], [1, 0, 2]], [[1, 1, 0], [1, 1, 2]], [[0, 1, 0], [0, 1, 2]]], float)
    weights = np.array([[1.0, 1.0], [half, half], [1.0, 1.0]])
    arc = TensorSpline(2, 1, np.repeat([0.0, 1.0], 3), np.repeat([0.0, 1.0], 2), net, weights)
    u, v = places(arc)
    for spline in (arc, arc.elevated(), arc.with_knot_u(0.3, 2)):
        points = spline.evaluate(u, v)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 1.0, atol=1e-14)
        np.testing.assert_allclose(points[:, 2], 2.0 * v, atol=1e-14)
    # Curvature 1 across, from the exact derivatives.
    s_u, s_uu = arc.evaluate(u, v, 1, 0), arc.evaluate(u, v, 2, 0)
    curvature = np.linalg.norm(np.cross(s_u, s_uu), axis=1) / np.linalg.norm(s_u, axis=1) ** 3
    np.testing.assert_allclose(curvature, 1.0, atol=1e-12)


@pytest.mark.parametrize("spline", every_kind())
def test_knots_and_degrees_change_and_the_surface_does_not(spline):
    (u0, u1), (v0, v1) = spline.domain
    middle = 0.4 * u0 + 0.6 * u1
    creased = spline.with_knot_u(middle, spline.degree_u)
    assert np.count_nonzero(creased.knots_u == middle) == spline.degree_u
    assert_same_surface(spline, creased)
    assert_same_surface(spline, spline.with_knot_v(v0, spline.degree_v))
    assert_same_surface(spline, spline.with_knot_v(v1, spline.degree_v))
    assert_same_surface(spline, spline.clamped())
    assert_same_surface(spline, spline.elevated(6))
    assert_same_surface(spline.transposed(), spline.elevated(6).transposed())


@pytest.mark.parametrize("spline", every_kind())
def test_clamped_surfaces_begin_and_end_at_control_points(spline):
    clamped = spline.clamped()
    (u0, u1), (v0, v1) = spline.domain
    corners = clamped.control_points[[0, 0, -1, -1], [0, -1, 0, -1]]
    found = spline.evaluate([u0, u0, u1, u1], [v0, v1, v0, v1])
    np.testing.assert_allclose(corners, found, atol=1e-12)
    assert np.all(clamped.knots_u[: spline.degree_u + 1] == u0)
    assert np.all(clamped.knots_v[-spline.degree_v - 1 :] == v1)
    again = clamped.clamped()
    np.testing.assert_array_equal(again.knots_u, clamped.knots_u)
    np.testing.assert_array_equal(again.control_points, clamped.control_points)


@pytest.mark.parametrize("spline", every_kind())
def test_a_part_of_a_surface_is_that_part(spline):
    (u0, u1), (v0, v1) = spline.domain
    u = (0.8 * u0 + 0.2 * u1, 0.3 * u0 + 0.7 * u1)
    part = spline.restricted(u, (v0, v1))
    assert part.domain == (u, (v0, v1))
    s, t = places(part)
    np.testing.assert_allclose(part.evaluate(s, t), spline.evaluate(s, t), atol=1e-12)


def vars_of(spline):
    names = ("degree_u", "degree_v", "knots_u", "knots_v", "control_points", "weights")
    return {name: getattr(spline, name) for name in names}


@pytest.mark.parametrize("spline", every_kind())
def test_reversed_and_transposed_surfaces_are_the_same_points(spline):
    u, v = places(spline)
    (u0, u1), (v0, v1) = spline.domain
    points = spline.evaluate(u, v)
    np.testing.assert_allclose(spline.transposed().evaluate(v, u), points, atol=1e-12)
    np.testing.assert_allclose(spline.reversed_u().evaluate(u0 + u1 - u, v), points, atol=1e-12)
    np.testing.assert_allclose(spline.reversed_v().evaluate(u, v0 + v1 - v), points, atol=1e-12)


def test_an_inserted_knot_leaves_far_control_points_untouched():
    spline = random_spline(3, 3)
    spline = TensorSpline(3, 3, np.arange(20.0), spline.knots_v, np.ones((16, 7, 3)))
    net = np.random.default_rng(0).normal(size=(16, 7, 3))
    spline = TensorSpline(3, 3, spline.knots_u, spline.knots_v, net)
    creased = spline.with_knot_u(8.0, 3)
    assert creased.control_points.shape == (18, 7, 3)
    np.testing.assert_array_equal(creased.control_points[:5], net[:5])
    np.testing.assert_array_equal(creased.control_points[-8:], net[-8:])
    # Where the knot stands three times the surface passes through a row of control points.
    on_crease = creased.evaluate(np.full(7, 8.0), np.linspace(0.0, 6.0, 7))
    row = TensorSpline(
        1, 3, np.array([0.0, 0.0, 1.0, 1.0]), spline.knots_v, creased.control_points[[6, 7]]
    )
    np.testing.assert_allclose(
        on_crease, row.evaluate(np.ones(7), np.linspace(0.0, 6.0, 7)), atol=1e-12
    )


def test_a_knot_that_differs_by_rounding_is_the_same_knot():
    spline = random_spline(3, 3, is_clamped=False)
    knot = spline.knots_u[5]
    creased = spline.with_knot_u(knot * (1.0 + 1e-15), 3)
    assert np.count_nonzero(creased.knots_u == knot) == 3


def test_a_knot_outside_or_too_often_is_refused():
    spline = random_spline(3, 3)
    with pytest.raises(InputError, match=r"inside the surface's domain \[0, 6\], got 7"):
        spline.with_knot_u(7.0, 1)
    with pytest.raises(InputError, match="a multiplicity up to the degree 3, got 4"):
        spline.with_knot_v(1.0, 4)


def test_a_higher_degree_is_not_lowered():
    with pytest.raises(InputError, match="degree 3 or less, got degrees 5 and 4"):
        random_spline(5, 4).elevated()


def test_a_bicubic_surface_is_elevated_to_itself():
    spline = random_spline(3, 3)
    assert spline.elevated() is spline


@given(st.integers(1, 4), st.integers(1, 4), st.booleans(), st.integers(0, 1000))
def test_the_basis_sums_to_one_and_follows_affine_maps(degree_u, degree_v, is_rational, seed):
    spline = random_spline(degree_u, degree_v, is_rational, bool(seed % 2), seed)
    u, v = places(spline, 20, seed)
    ones = TensorSpline(
        **{**vars_of(spline), "control_points": np.ones_like(spline.control_points)}
    )
    np.testing.assert_allclose(ones.evaluate(u, v), 1.0, atol=1e-12)
    rng = np.random.default_rng(seed)
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    image = TensorSpline(
        **{**vars_of(spline), "control_points": spline.control_points @ matrix.T + shift}
    )
    expected = spline.evaluate(u, v) @ matrix.T + shift
    np.testing.assert_allclose(image.evaluate(u, v), expected, atol=1e-11)


def test_a_grid_spans_its_points():
    rng = np.random.default_rng(0)
    grid = rng.normal(size=(6, 9, 3))
    spline = spline_over_grid(grid)
    assert spline.domain == ((0.0, 5.0), (0.0, 8.0))
    np.testing.assert_array_equal(spline.knots_u, np.arange(-3, 9))
    corners = spline.evaluate([0, 0, 5, 5], [0, 8, 0, 8])
    np.testing.assert_allclose(corners, grid[[0, 0, -1, -1], [0, -1, 0, -1]], atol=1e-14)


def test_patch_centres_have_the_weights_of_the_paper():
    grid = np.random.default_rng(1).normal(size=(7, 6, 3))
    spline = spline_over_grid(grid)
    position = np.array([1, 23, 23, 1]) / 48
    first = np.array([-1, -5, 5, 1]) / 8
    second = np.array([1, -1, -1, 1]) / 2
    block = grid[2:6, 1:5]
    for orders, (a, b) in {
        (0, 0): (position, position),
        (1, 0): (first, position),
        (1, 1): (first, first),
        (2, 0): (second, position),
        (0, 2): (position, second),
    }.items():
        expected = np.einsum("i,j,ijk->k", a, b, block)
        np.testing.assert_allclose(spline.evaluate([3.5], [2.5], *orders)[0], expected, atol=1e-13)


def test_a_plane_grid_gives_the_plane_with_its_parameters():
    i, j = np.meshgrid(np.arange(5.0), np.arange(4.0), indexing="ij")
    spline = spline_over_grid(np.stack([i, j, 2.0 * i - j], axis=-1))
    u, v = places(spline)
    np.testing.assert_allclose(spline.evaluate(u, v), np.stack([u, v, 2 * u - v], 1), atol=1e-13)


def test_an_invalid_point_spoils_only_its_own_patches():
    grid = np.random.default_rng(2).normal(size=(12, 12, 3))
    holed = grid.copy()
    holed[6, 6] = np.nan
    u, v = (a.ravel() for a in np.meshgrid(np.arange(11) + 0.5, np.arange(11) + 0.5, indexing="ij"))
    whole, found = spline_over_grid(grid).evaluate(u, v), spline_over_grid(holed).evaluate(u, v)
    is_hole = (np.abs(u - 6) < 2) & (np.abs(v - 6) < 2)
    np.testing.assert_array_equal(np.isnan(found).any(axis=1), is_hole)
    np.testing.assert_array_equal(found[~is_hole], whole[~is_hole])


@pytest.mark.parametrize("shape", [(5, 3), (5, 4, 2), (1, 8, 3), (0, 0, 3)])
def test_what_is_no_grid_is_refused(shape):
    with pytest.raises(InputError, match=r"an array of shape \(m, n, 3\) with m and n at least 2"):
        spline_over_grid(np.zeros(shape))
