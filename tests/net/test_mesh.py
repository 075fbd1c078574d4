"""Triangle meshes: clipping is exact for linear fields, normals and pieces are right."""

import numpy as np
import pytest

from crispline.net.mesh import TriangleMesh, clipped, compact


@pytest.fixture
def square(nets):
    vertices, quads = nets.plane(9, 9)
    return TriangleMesh(vertices, np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]]))


@pytest.mark.parametrize("line", [(1.0, 0.0, -3.3), (0.6, 0.8, -5.0), (1.0, -1.0, 0.0)])
def test_clipping_with_a_linear_field_is_exact(square, line):
    a, b, c = line
    values = a * square.vertices[:, 0] + b * square.vertices[:, 1] + c
    part = clipped(square, values)
    height = a * part.vertices[:, 0] + b * part.vertices[:, 1] + c
    assert height.min() > -1e-6
    other = clipped(square, -values)
    assert part.areas().sum() + other.areas().sum() == pytest.approx(64.0, abs=1e-6)
    assert (part.normals()[:, 2] > 0.999).all()


def test_clipping_keeps_all_or_nothing(square):
    whole = clipped(square, np.ones(len(square.vertices)))
    np.testing.assert_array_equal(whole.triangles, square.triangles)
    assert len(clipped(square, -np.ones(len(square.vertices))).triangles) == 0


def test_borders_and_pieces(square):
    assert len(square.borders()) == 32
    both = TriangleMesh(
        np.concatenate([square.vertices, square.vertices + 20.0]),
        np.concatenate([square.triangles, square.triangles + len(square.vertices)]),
    )
    piece = both.pieces()
    assert len(np.unique(piece)) == 2
    assert (piece[: len(square.vertices)] == piece[0]).all()


def test_compact_drops_unused_vertices(square):
    small = compact(square.vertices, square.triangles[:1])
    assert len(small.vertices) == 3
    np.testing.assert_allclose(small.areas(), [0.5])
