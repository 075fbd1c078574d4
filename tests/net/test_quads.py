"""Quad nets over clouds: closed, right genus, outward, on the surface, repeatable."""

import numpy as np
import pytest

from crispline.cloud.working import working_cloud
from crispline.errors import ReconstructionError
from crispline.net import quads
from crispline.net.halfedge import half_edges
from crispline.net.quads import QuadNet, quad_net
from crispline.options import CloudOptions, NetOptions


def ball(n=1500, seed=0):
    normals = np.random.default_rng(seed).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals, normals


def doughnut(n=2500, seed=0, major=3.0, minor=1.0):
    rng = np.random.default_rng(seed)
    u, v, level = rng.uniform(0.0, 1.0, (3, 3 * n))
    u, v = 2 * np.pi * u, 2 * np.pi * v
    keep = level * (major + minor) < major + minor * np.cos(v)
    u, v = u[keep][:n], v[keep][:n]
    normals = np.stack([np.cos(v) * np.cos(u), np.cos(v) * np.sin(u), np.sin(v)], axis=1)
    return major * np.stack([np.cos(u), np.sin(u), 0 * u], axis=1) + minor * normals, normals


def net_over(points, normals, threads=-1):
    cloud = working_cloud(points, CloudOptions())
    back = cloud.to_user.inverse()
    # The clouds here have neither duplicates nor outliers, so the rows correspond.
    assert len(cloud.points) == len(points)
    net = quad_net(cloud, back.directions(normals), NetOptions(), threads)
    return cloud, net


def euler(net):
    connected = half_edges(net.quads, len(net.vertices))
    assert connected.is_closed
    return len(net.vertices) - len(connected.pairs()) + len(net.quads)


@pytest.mark.parametrize(("shape", "expected"), [(ball, 2), (doughnut, 0)])
def test_closed_with_the_right_euler_number(shape, expected):
    cloud, net = net_over(*shape())
    assert euler(net) == expected
    assert 0.8 < net.edge_length < 1.2
    valence = np.bincount(net.quads.ravel())
    assert valence.min() >= 3
    assert np.mean(valence == 4) > 0.9
    distance, _ = cloud.tree.query(net.vertices)
    assert distance.max() < 2.5


def test_lies_on_the_sphere_and_looks_outward():
    cloud, net = net_over(*ball())
    radius = 1.0 / cloud.spacing
    middle = cloud.to_user.inverse().points(np.zeros(3))
    spoke = net.vertices - middle
    # The zero of a mean of tangent planes lies outside a ball by <d^2> / 2r; the
    # weights of the projection have <d^2> = 4^2 / 6.
    height = np.linalg.norm(spoke, axis=1) - radius
    assert height.mean() == pytest.approx(16.0 / 6.0 / (2.0 * radius), abs=0.03)
    assert height.std() < 0.05
    a, b, c, d = (net.vertices[net.quads[:, k]] for k in range(4))
    cross = np.cross(c - a, d - b)
    assert (np.einsum("ij,ij->i", cross, spoke[net.quads].mean(axis=1)) > 0.0).all()


def test_two_runs_and_any_threads_give_the_same_net():
    points, normals = ball(800)
    _, one = net_over(points, normals, threads=1)
    _, two = net_over(points, normals, threads=2)
    np.testing.assert_array_equal(one.quads, two.quads)
    np.testing.assert_array_equal(one.vertices, two.vertices)


def test_the_mesher_says_nothing(capfd):
    net_over(*ball(400))
    assert capfd.readouterr().out == ""


def test_a_cloud_without_an_inside_is_refused(monkeypatch):
    """Normals that cancel leave no level set to follow."""
    points, normals = ball(400)
    with pytest.raises(ReconstructionError, match="do not enclose a part"):
        net_over(points, 0.0 * normals)


def test_edge_length_is_the_median_side():
    vertices = np.array([[0.0, 0, 0], [3.0, 0, 0], [3.0, 1.0, 0], [0.0, 1.0, 0]])
    assert QuadNet(vertices, np.array([[0, 1, 2, 3]])).edge_length == 2.0


def test_an_open_net_is_laid_anew(monkeypatch):
    """The mesher leaves a hole at the first edge length; the second is closed."""
    lengths = []

    def with_a_hole(vertices, triangles, edge_length):
        lengths.append(edge_length)
        net = quads_over(vertices, triangles, edge_length)
        return net if len(lengths) > 1 else QuadNet(net.vertices, net.quads[1:])

    quads_over = quads._quads_over
    monkeypatch.setattr(quads, "_quads_over", with_a_hole)
    _, net = net_over(*ball(800))
    assert euler(net) == 2
    assert tuple(lengths) == NetOptions().edge_lengths[:2]


def test_the_least_open_net_stands_if_none_is_closed(monkeypatch):
    n_missing = iter([3, 1, 2, 2])

    def with_a_hole(vertices, triangles, edge_length):
        net = quads_over(vertices, triangles, edge_length)
        return QuadNet(net.vertices, net.quads[: len(net.quads) - next(n_missing)])

    quads_over = quads._quads_over
    monkeypatch.setattr(quads, "_quads_over", with_a_hole)
    _, net = net_over(*ball(800))
    assert np.sum(half_edges(net.quads, len(net.vertices)).twin < 0) == 4
