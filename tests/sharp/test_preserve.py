"""Located features put into the net: the surface becomes sharp exactly there."""

from dataclasses import replace

import numpy as np
import pytest

from crispline.curve import Line
from crispline.model import Edge, Face, Model
from crispline.net.halfedge import half_edges
from crispline.net.quads import QuadNet
from crispline.region.topology import border_topology
from crispline.sharp.preserve import preserve
from crispline.spline.creased import subdivided
from crispline.surface import Plane

N = 6


@pytest.fixture
def cube(nets):
    """A ragged net of a cube of half side 1, its topology, and the exact edges."""
    exact, quads, side = nets.box(N)
    vertices = exact + 0.05 * np.random.default_rng(0).normal(size=exact.shape)
    topology = border_topology(half_edges(quads, len(vertices)), side)
    used = sorted({int(chain.vertices[end]) for chain in topology.chains for end in (0, -1)})
    edges = []
    for chain in topology.chains:
        a, b = exact[chain.vertices[0]], exact[chain.vertices[-1]]
        line = Line(a, (b - a) / 2.0, 0.0, 2.0)
        start, end = used.index(chain.vertices[0]), used.index(chain.vertices[-1])
        edges.append(Edge(line, start, end, chain.left, chain.right, 0.0, np.pi / 2, True))
    plane = Plane(np.zeros(3), np.eye(3)[0])  # surfaces play no part here
    faces = tuple(
        Face(plane, 1, topology.loops[k], np.zeros((0, 3)), np.zeros(0), k) for k in range(6)
    )
    model = Model(exact[used], np.zeros(len(used)), tuple(edges), faces)
    return QuadNet(vertices, quads), topology, model, exact


def with_sharp(model, is_sharp):
    """The model with the given edges sharp and the others tangent."""
    edges = tuple(
        Edge(e.curve, e.start, e.end, e.left, e.right, e.gap, e.angle, bool(sharp))
        for e, sharp in zip(model.edges, is_sharp, strict=True)
    )
    return Model(model.vertices, model.vertex_gaps, edges, model.faces)


def test_the_net_follows_the_edges_and_nothing_else_moves(cube):
    net, topology, model, _ = cube
    creased = preserve(net, topology, model, 1.0)
    on_chain = np.unique(np.concatenate([chain.vertices for chain in topology.chains]))
    placed = np.sort(np.abs(creased.vertices[on_chain]), axis=1)
    np.testing.assert_allclose(placed[:, 1:], 1.0)
    others = np.setdiff1d(np.arange(len(net.vertices)), on_chain)
    np.testing.assert_array_equal(creased.vertices[others], net.vertices[others])
    np.testing.assert_array_equal(creased.quads, net.quads)


def test_creases_are_sides_of_the_net_and_corners_are_the_eight(cube):
    net, topology, model, exact = cube
    creased = preserve(net, topology, model, 1.0)
    sides = {frozenset(pair) for quad in net.quads for pair in zip(quad, np.roll(quad, 1))}  # noqa: B905
    assert len(creased.creases) == 12 * N
    assert {frozenset(pair) for pair in creased.creases} <= sides
    np.testing.assert_array_equal(
        creased.corners, np.flatnonzero((np.abs(exact) == 1.0).all(axis=1))
    )


def test_neighbours_on_a_chain_keep_their_order(cube):
    net, topology, model, _ = cube
    creased = preserve(net, topology, model, 1.0)
    for chain, edge in zip(topology.chains, model.edges, strict=True):
        start, end = edge.curve.samples(2)
        along = (creased.vertices[chain.vertices] - start) @ (end - start)
        assert (np.diff(along) > 0.0).all()


def test_vertices_go_to_places_near_them(cube):
    net, topology, model, _ = cube
    creased = preserve(net, topology, model, 1.0)
    moved = np.linalg.norm(creased.vertices - net.vertices, axis=1)
    nearest = np.sort(np.abs(np.abs(net.vertices) - 1.0), axis=1)[:, :2]
    to_edge = np.linalg.norm(nearest, axis=1)
    on_chain = np.unique(np.concatenate([chain.vertices for chain in topology.chains]))
    inner = np.setdiff1d(on_chain, creased.corners)
    assert np.all(moved[inner] < to_edge[inner] + 0.1)


def test_an_edge_far_from_the_net_stays_smooth(cube):
    net, topology, model, _ = cube
    smooth = preserve(net, topology, model, 1e-3)
    np.testing.assert_array_equal(smooth.vertices, net.vertices)
    assert len(smooth.creases) == 0


def test_sides_that_a_contraction_has_removed_are_no_creases(cube):
    net, topology, model, _ = cube
    chain = topology.chains[0]
    away = chain.vertices.copy()
    away[-1] = topology.chains[-1].vertices[2]  # no neighbour of the vertex before
    bent = replace(topology, chains=(replace(chain, vertices=away), *topology.chains[1:]))
    sides = {frozenset(pair) for quad in net.quads for pair in zip(quad, np.roll(quad, 1))}  # noqa: B905
    assert {frozenset(pair) for pair in preserve(net, bent, model, 9.0).creases} <= sides


def test_the_surface_passes_through_the_features(cube):
    net, topology, model, exact = cube
    creased = preserve(net, topology, model, 1.0)
    for _ in range(3):
        creased = subdivided(creased)
    np.testing.assert_allclose(
        creased.vertices[creased.corners], exact[creased.corners], atol=1e-12
    )
    along = np.sort(np.abs(creased.vertices[np.unique(creased.creases)]), axis=1)
    np.testing.assert_allclose(along[:, 1:], 1.0)


def test_tangent_edges_stay_smooth(cube):
    net, topology, model, _ = cube
    smooth = preserve(net, topology, with_sharp(model, np.zeros(12)), 1.0)
    np.testing.assert_array_equal(smooth.vertices, net.vertices)
    assert smooth.creases.shape == (0, 2)
    assert len(smooth.corners) == 0
    one = preserve(net, topology, with_sharp(model, np.arange(12) == 0), 1.0)
    assert len(one.creases) == N
    assert len(one.corners) == 0
