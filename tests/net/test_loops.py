"""Border loops: found once, and holes filled without changing the rest."""

import numpy as np
import pytest

from crispline.net.halfedge import half_edges
from crispline.net.loops import (
    border_loops,
    with_quad_holes_filled,
    with_small_holes_filled,
    without_pinches,
)
from crispline.net.mesh import TriangleMesh


def euler(quads):
    n = len(np.unique(quads))
    connected = half_edges(quads, int(quads.max()) + 1)
    n_free = int((connected.twin < 0).sum())
    return n - len(connected.pairs()) - n_free + len(quads)


def test_a_sheet_has_one_loop_and_a_box_none(nets):
    (loop,) = border_loops(nets.grid(6, 5))
    assert len(loop) == 18
    assert len(np.unique(loop)) == 18
    assert border_loops(nets.box(3)[1]) == ()


@pytest.mark.parametrize("missing", [[7], [7, 8], [7, 8, 12, 13]])
def test_quad_holes_are_closed_with_consistent_quads(nets, missing):
    vertices, quads, _ = nets.box(6)
    vertices, filled = with_quad_holes_filled(vertices, np.delete(quads, missing, axis=0), 12)
    assert half_edges(filled, len(vertices)).is_closed
    assert euler(filled) == 2


def test_long_and_odd_holes_stay_open(nets):
    vertices, quads, _ = nets.box(6)
    hole = np.delete(quads, [7, 8, 12, 13], axis=0)
    assert len(with_quad_holes_filled(vertices, hole, 6)[1]) == len(hole)
    # The border of three quads round a vertex of valence 3 has six sides; of two of them, five
    # and a bit cannot be: loops of closed nets are even, so cut one quad into an odd ring.
    odd = np.array([[0, 1, 5, 6], [1, 2, 7, 5], [2, 3, 8, 7], [3, 4, 9, 8], [4, 0, 6, 9]])
    assert sorted(len(loop) for loop in border_loops(odd)) == [5, 5]
    assert len(with_quad_holes_filled(np.zeros((10, 3)), odd, 12)[1]) == len(odd)


def test_small_holes_of_triangles_are_closed_and_wide_ones_stay(nets):
    vertices, quads = nets.sphere(12, radius=10.0)
    triangles = np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    middle = vertices[triangles].mean(axis=1)
    top = np.array([0.0, 0.0, 10.0])
    for radius, is_filled in ((2.5, True), (5.0, False)):
        keep = np.linalg.norm(middle - top, axis=1) > radius
        mesh = TriangleMesh(vertices, triangles[keep])
        assert len(mesh.borders()) > 0
        filled = with_small_holes_filled(mesh, 8.0)
        assert (len(filled.borders()) == 0) == is_filled
        assert (np.einsum("ij,ij->i", filled.normals(), filled.vertices) > 0.0).all()


def test_pinches_go(nets):
    quads = nets.grid(5, 5)
    touching = np.delete(quads, [5, 10], axis=0)  # two holes that share a vertex
    clean = without_pinches(touching)
    tail = np.concatenate(border_loops(clean))
    assert len(np.unique(tail)) == len(tail)
    np.testing.assert_array_equal(without_pinches(quads), quads)


def test_many_holes_are_found_one_by_one_from_the_lowest_vertex_on(nets):
    whole = nets.grid(41, 41)
    middle = np.arange(len(whole)).reshape(40, 40)[2:-2:4, 2:-2:4].ravel()
    loops = border_loops(np.delete(whole, middle, axis=0))
    assert sorted(len(loop) for loop in loops) == [4] * len(middle) + [160]
    assert [loop[0] for loop in loops] == sorted(loop.min() for loop in loops)


def test_wide_quad_holes_stay_open(nets):
    vertices, quads, _ = nets.box(6)
    hole = np.delete(quads, [7, 8, 12, 13], axis=0)
    (ring,) = border_loops(hole)
    middle = vertices[ring].mean(axis=0)
    width = 2.0 * np.linalg.norm(vertices[ring] - middle, axis=1).max()
    for widest, is_filled in ((1.01 * width, True), (0.99 * width, False)):
        more = len(with_quad_holes_filled(vertices, hole, 12, widest)[1]) - len(hole)
        assert (more > 0) == is_filled
