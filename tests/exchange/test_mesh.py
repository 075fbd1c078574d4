"""Surfaces as triangles."""

import numpy as np
import pytest
import trimesh

from crispline.errors import InputError
from crispline.exchange.mesh import tessellate, write_mesh
from crispline.spline.tensor import spline_over_grid


def test_a_plane_has_its_area_and_its_normal():
    i, j = np.meshgrid(np.arange(6.0), np.arange(4.0), indexing="ij")
    vertices, triangles = tessellate(spline_over_grid(np.stack([i, j, 0 * i], -1)), 3)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    assert len(triangles) == 2 * 15 * 9
    assert mesh.area == pytest.approx(15.0)
    np.testing.assert_allclose(mesh.face_normals, [[0.0, 0.0, 1.0]] * len(triangles), atol=1e-12)
    assert mesh.euler_number == 1


def test_a_crease_is_a_line_of_edges(creased):
    vertices, triangles = tessellate(creased, 4)
    _, (v0, v1) = creased.domain
    v = np.linspace(v0, v1, 4 * 7 + 1)
    on_crease = creased.evaluate(np.full(len(v), 4.0), v)
    number = np.array([np.flatnonzero((vertices == place).all(axis=1))[0] for place in on_crease])
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    for edge in np.sort(np.column_stack([number[:-1], number[1:]]), axis=1):
        assert (edges == edge).all(axis=1).sum() == 2


def test_triangles_approach_the_surface_with_second_order(rational):
    u, v = np.random.default_rng(0).uniform([0.0, 0.0], [8.0, 7.0], (200, 2)).T
    points = rational.evaluate(u, v)
    errors = []
    for per_span in (4, 8):
        mesh = trimesh.Trimesh(*tessellate(rational, per_span), process=False)
        errors.append(trimesh.proximity.closest_point_naive(mesh, points[:40])[1].mean())
    assert np.log2(errors[0] / errors[1]) > 1.6


@pytest.mark.parametrize("suffix", [".ply", ".obj"])
@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
def test_trimesh_reads_every_digit(tmp_path, creased, suffix, scale):
    vertices, triangles = tessellate(creased, 2)
    vertices = scale * vertices + scale * 1000.0
    write_mesh(tmp_path / f"a{suffix}", vertices, triangles)
    mesh = trimesh.load_mesh(tmp_path / f"a{suffix}", process=False)
    np.testing.assert_allclose(mesh.vertices, vertices, rtol=1e-16, atol=0)
    np.testing.assert_array_equal(mesh.faces, triangles)


def test_no_pieces_are_refused(creased):
    with pytest.raises(InputError, match="at least 1 piece for each span, got 0"):
        tessellate(creased, 0)
