"""Patch centres against the paper's patch, written out, and against plain subdivision."""

import numpy as np
import pytest

from crispline.spline.catmull_clark import patch_centres
from crispline.spline.creased import CreasedNet, subdivided

# Uniform cubic B-spline basis: p(u) = (1, u, u^2, u^3) @ M @ controls.
M = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6.0
AT_CENTRE = [
    np.array([1.0, 0.5, 0.25, 0.125]),
    np.array([0.0, 1.0, 1.0, 0.75]),
    np.array([0.0, 0.0, 2.0, 3.0]),
]


def wavy(nets, n_u=7, n_v=8, seed=0):
    vertices, quads = nets.plane(n_u, n_v)
    return vertices + 0.3 * np.random.default_rng(seed).normal(size=vertices.shape), quads


def paper_patch(vertices, n_v, i, j, order_u, order_v):
    """``u^T M P M^T v`` at the centre, differentiated; the patch of cell ``(i, j)``."""
    block = np.array(
        [[vertices[a * n_v + b] for b in range(j - 1, j + 3)] for a in range(i - 1, i + 3)]
    )
    along_u, along_v = AT_CENTRE[order_u] @ M, AT_CENTRE[order_v] @ M
    return sum(along_u[a] * along_v[b] * block[a, b] for a in range(4) for b in range(4))


def test_the_basis_gives_the_weights_of_the_paper():
    weights = [monomials @ M for monomials in AT_CENTRE]
    np.testing.assert_allclose(weights[0], np.array([1, 23, 23, 1]) / 48)
    np.testing.assert_allclose(weights[1], np.array([-1, -5, 5, 1]) / 8)
    np.testing.assert_allclose(weights[2], np.array([1, -1, -1, 1]) / 2)


def test_a_regular_net_gives_the_patch_of_the_paper(nets):
    n_u, n_v = 7, 8
    vertices, quads = wavy(nets, n_u, n_v)
    centres = patch_centres(vertices, quads)
    orders = {
        "point": (0, 0), "du": (1, 0), "dv": (0, 1), "duu": (2, 0), "duv": (1, 1), "dvv": (0, 2),
    }  # fmt: skip
    for i in range(1, n_u - 2):
        for j in range(1, n_v - 2):
            patch = i * (n_v - 1) + j
            for name, (order_u, order_v) in orders.items():
                # Derivatives are per half patch.
                expected = paper_patch(vertices, n_v, i, j, order_u, order_v) * 0.5 ** (
                    order_u + order_v
                )
                np.testing.assert_allclose(getattr(centres, name)[patch], expected, atol=1e-12)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_an_extraordinary_patch_is_the_limit_of_subdivision(nets, n):
    vertices, quads, _ = nets.box(n)
    vertices = vertices + 0.2 * np.random.default_rng(n).normal(size=vertices.shape)
    centres = patch_centres(vertices, quads)
    net = CreasedNet(vertices, quads, np.zeros((0, 2), dtype=int), np.zeros(0, dtype=int))
    net = subdivided(net)
    tracked = np.arange(len(net.vertices) - len(quads), len(net.vertices))  # the face points
    errors = []
    for _ in range(4):
        errors.append(np.abs(net.vertices[tracked] - centres.point).max())
        net = subdivided(net)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, atol=0.15)


def test_centres_move_with_the_net(nets):
    vertices, quads, _ = nets.box(3)
    rotation, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    rotation *= np.linalg.det(rotation)
    still = patch_centres(vertices, quads)
    moved = patch_centres(3.0 * vertices @ rotation.T + [1.0, 2.0, 3.0], quads)
    np.testing.assert_allclose(moved.point, 3.0 * still.point @ rotation.T + [1.0, 2.0, 3.0])
    np.testing.assert_allclose(moved.normal, still.normal @ rotation.T, atol=1e-12)


def test_normals_point_outward(nets):
    vertices, quads = nets.sphere(6)
    centres = patch_centres(vertices, quads)
    assert (np.einsum("ij,ij->i", centres.normal, centres.point) > 0.9).all()


def test_a_degenerate_patch_has_no_normal():
    quads = np.array([[0, 1, 2, 3]])
    np.testing.assert_array_equal(patch_centres(np.ones((4, 3)), quads).normal, np.zeros((1, 3)))
