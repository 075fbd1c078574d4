"""Mean curvature of the patches: the paper's formula, invariances, convergence."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.sharp.curvature import curvature
from crispline.spline.catmull_clark import patch_centres

POSITION = np.array([1, 23, 23, 1]) / 48
FIRST = np.array([-1, -5, 5, 1]) / 8
SECOND = np.array([1, -1, -1, 1]) / 2


def of(net):
    return curvature(patch_centres(*net))


def rotation(seed):
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.linalg.det(q)


def rough(net, size, seed):
    return net[0] + size * np.random.default_rng(seed).normal(size=net[0].shape), net[1]


def inner(n_u, n_v, values):
    """Values of the cells that have a full 4 x 4 block around them."""
    return values.reshape(n_u - 1, n_v - 1)[1:-1, 1:-1].ravel()


def test_equals_the_formula_of_the_paper_written_out(nets):
    n_u, n_v = 6, 7
    vertices, quads = rough(nets.plane(n_u, n_v), 0.2, 3)
    expected = []
    for i in range(1, n_u - 2):
        for j in range(1, n_v - 2):
            block = vertices.reshape(n_u, n_v, 3)[i - 1 : i + 3, j - 1 : j + 3]

            def sum_of(a, b, block=block):
                return sum(a[k] * b[m] * block[k, m] for k in range(4) for m in range(4))

            su, sv = sum_of(FIRST, POSITION), sum_of(POSITION, FIRST)
            normal = np.cross(su, sv) / np.linalg.norm(np.cross(su, sv))
            e, f, g = su @ su, su @ sv, sv @ sv
            second = [(SECOND, POSITION), (FIRST, FIRST), (POSITION, SECOND)]
            ll, mm, nn = (sum_of(a, b) @ normal for a, b in second)
            expected.append((e * nn - 2 * f * mm + g * ll) / (2 * (e * g - f * f)))
    np.testing.assert_allclose(inner(n_u, n_v, of((vertices, quads))), expected, rtol=1e-10)


@given(
    seed=st.integers(0, 1000),
    exponent=st.floats(-3, 3),
    shift=st.floats(-100, 100),
)
def test_scales_with_one_over_length_and_ignores_rigid_motion(nets, seed, exponent, shift):
    vertices, quads = rough(nets.box(3)[:2], 0.1, seed)
    scale = 10.0**exponent
    moved = scale * (vertices @ rotation(seed).T + shift)
    still = of((vertices, quads))
    np.testing.assert_allclose(scale * of((moved, quads)), still, atol=1e-8 * np.abs(still).max())


def test_turning_the_quads_over_changes_the_sign(nets):
    vertices, quads = nets.sphere(4)
    np.testing.assert_allclose(of((vertices, quads[:, ::-1])), -of((vertices, quads)))
    # Starting a quad at another corner changes nothing.
    np.testing.assert_allclose(of((vertices, np.roll(quads, 1, axis=1))), of((vertices, quads)))


def test_is_negative_where_the_surface_bends_away_from_its_outward_normal(nets):
    assert (of(nets.sphere(6)) < 0.0).all()


def test_a_plane_is_flat(nets):
    np.testing.assert_allclose(of(nets.plane(5, 6)), 0.0, atol=1e-14)


def spherical_patch(nets, n, radius):
    """A square degree patch about the equator."""
    u, v = np.meshgrid(*2 * [np.linspace(-0.4, 0.4, n)], indexing="ij")
    vertices = radius * np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=2)
    return vertices.reshape(-1, 3), nets.grid(n, n)


@pytest.mark.parametrize("radius", [0.5, 20.0])
def test_of_a_sphere_converges_with_second_order(nets, radius):
    errors = []
    for n in (9, 17, 33):
        h = inner(n, n, of(spherical_patch(nets, n, radius)))
        errors.append(np.abs(np.abs(h) * radius - 1.0).max())
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.2)
    assert errors[-1] < 1e-3


def test_of_a_torus_converges_to_the_known_field(nets):
    major, minor = 10.0, 4.0
    errors = []
    for n in (24, 48):
        vertices, quads = nets.torus(3 * n, n, major, minor)
        centres = patch_centres(vertices, quads)
        rho = np.hypot(centres.point[:, 0], centres.point[:, 1])
        cosine = (rho - major) / np.hypot(rho - major, centres.point[:, 2])
        expected = -(major + 2 * minor * cosine) / (2 * minor * (major + minor * cosine))
        errors.append(np.abs(curvature(centres) - expected).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize(
    "corners",
    [np.zeros((4, 3)), [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0]]],
    ids=["point", "line"],
)
def test_a_degenerate_patch_gets_zero(corners):
    np.testing.assert_array_equal(of((np.array(corners, float), np.array([[0, 1, 2, 3]]))), [0.0])
