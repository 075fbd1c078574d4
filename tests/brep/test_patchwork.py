"""Creased nets to valid shells and solids, to STEP and back."""

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.collections import IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher
from OCP.TopExp import TopExp

from crispline import occt
from crispline.brep import patchwork
from crispline.brep.check import check_shape
from crispline.brep.patchsolid import patch_solid
from crispline.brep.patchwork import write_patchwork
from crispline.cadfile.step import read_step, step_bytes
from crispline.errors import InputError, ReconstructionError
from crispline.gauge.certificate import certify
from crispline.spline.creased import CreasedNet
from crispline.spline.joins import measure_joins
from crispline.spline.separate import separated

NONE = np.zeros((0, 2), dtype=np.int64)
NO_CORNERS = np.zeros(0, dtype=np.int64)


def smooth(vertices, quads):
    return CreasedNet(vertices, quads, NONE, NO_CORNERS)


def sharp_box(nets, n):
    vertices, quads, side = nets.box(n)
    return CreasedNet(vertices, quads, nets.borders(quads, side), NO_CORNERS)


def creased_grid(nets):
    """An open grid with a crease that ends inside, and a diagonal one by steps."""
    vertices, quads = nets.plane(12, 10)
    vertices = vertices + 0.1 * np.random.default_rng(2).normal(size=vertices.shape)
    index = np.arange(120).reshape(12, 10)
    i = np.arange(3, 7)
    creases = np.concatenate(
        [
            np.stack([index[:6, 8], index[1:7, 8]], axis=1),
            np.stack([index[i, i], index[i + 1, i]], axis=1),
            np.stack([index[i + 1, i], index[i + 1, i + 1]], axis=1),
        ]
    )
    return CreasedNet(vertices, quads, creases, index[[0, 0, -1, -1], [0, -1, 0, -1]])


def n_free_edges(shape):
    uses = IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapesAndAncestors_s(shape, occt.EDGE, occt.FACE, uses)
    sizes = [uses.FindFromIndex(i).Size() for i in range(1, uses.Size() + 1)]
    assert set(sizes) <= {1, 2}
    return sizes.count(1)


def written(patches, folder):
    """The shape read back from a file."""
    path = folder / "patches.step"
    write_patchwork(patches, path)
    return read_step(path)


def test_a_cube_with_creases_is_six_square_faces(nets, tmp_path):
    patches = patchwork.build_patchwork(sharp_box(nets, 5))
    for shape in (patches.shape, written(patches, tmp_path)):
        check = check_shape(shape)
        assert check.is_good
        assert (check.n_faces, check.n_edges, check.n_vertices) == (6, 12, 8)
        assert check.volume == pytest.approx(8.0, rel=1e-12)
        assert check.edge_tolerance <= 1.01e-7
    assert measure_joins(patches.quilt).angle == pytest.approx(np.pi / 2)


def test_a_sphere_is_a_closed_smooth_solid(nets, tmp_path):
    vertices, quads = nets.sphere(8)
    patches = patchwork.build_patchwork(smooth(vertices, quads))
    joins = measure_joins(patches.quilt)
    assert joins.largest_gap < 1e-14
    assert np.degrees(joins.largest_kink) < 0.5
    for shape in (patches.shape, written(patches, tmp_path)):
        check = check_shape(shape)
        assert check.is_good
        assert check.n_faces == len(patches.quilt.faces) < len(quads) / 8
        assert check.volume == pytest.approx(4.0 / 3.0 * np.pi, rel=0.04)


def test_a_torus_without_irregular_vertices_is_four_faces(nets):
    patches = patchwork.build_patchwork(smooth(*nets.torus(24, 12)))
    check = check_shape(patches.shape)
    assert check.is_good
    assert check.n_faces == 4
    assert measure_joins(patches.quilt).largest_kink < 1e-6
    # The surface lies inside its net: radii shrink by (2 + cos a) / 3, a the step of the angle.
    major, minor = 10.0 * (2.0 + np.cos(np.pi / 12)) / 3.0, 4.0 * (2.0 + np.cos(np.pi / 6)) / 3.0
    assert check.volume == pytest.approx(2.0 * np.pi**2 * major * minor**2, rel=0.02)


def test_an_open_grid_is_a_shell_with_free_edges_at_its_border_only(nets, tmp_path):
    patches = patchwork.build_patchwork(creased_grid(nets))
    n_border = sum(edge.right is None for edge in patches.quilt.edges)
    for shape in (patches.shape, written(patches, tmp_path)):
        check = check_shape(shape)
        assert check.is_valid
        assert not check.bad_faces
        assert (check.n_solids, len(occt.subshapes(shape, occt.SHELL))) == (0, 1)
        assert check.n_vertices - check.n_edges + check.n_faces == 1
        assert n_free_edges(shape) == n_border
    assert measure_joins(patches.quilt).largest_gap < 1e-13


def test_surfaces_in_the_shape_are_those_of_the_quilt(nets):
    patches = patchwork.build_patchwork(smooth(*nets.sphere(4)))
    for face, surface in zip(
        occt.subshapes(patches.shape, occt.FACE), patches.quilt.faces, strict=True
    ):
        low, high = surface.domain
        u, v = low + 0.3 * (high - low)
        found = BRep_Tool.Surface_s(face).Value(u, v)
        expected = surface.evaluate(np.array([u]), np.array([v]))[0]
        np.testing.assert_allclose([found.X(), found.Y(), found.Z()], expected, atol=1e-14)


def test_a_piece_inside_another_is_a_void_if_it_is_turned(nets):
    vertices, quads = nets.sphere(3)
    n = len(vertices)
    parts = [3.0 * vertices, 0.5 * vertices + 0.2, vertices + 10.0]
    net = smooth(np.vstack(parts), np.vstack([quads, quads[:, ::-1] + n, quads + 2 * n]))
    shape = patchwork.build_patchwork(net).shape
    check = check_shape(shape)
    assert check.is_good
    assert check.n_solids == 2
    assert len(occt.subshapes(shape, occt.SHELL)) == 3
    one = check_shape(patchwork.build_patchwork(smooth(vertices, quads)).shape).volume
    assert check.volume == pytest.approx((27.0 - 0.125 + 1.0) * one, rel=1e-6)


def test_a_net_that_is_inside_out_gives_a_solid_all_the_same(nets):
    vertices, quads = nets.sphere(3)
    outside = check_shape(patchwork.build_patchwork(smooth(vertices, quads)).shape)
    inverted = check_shape(patchwork.build_patchwork(smooth(vertices, quads[:, ::-1])).shape)
    assert inverted.is_good
    assert inverted.volume == pytest.approx(outside.volume, rel=1e-9)


def test_the_mesh_of_the_net_measures_as_that_of_the_shape_does(nets):
    """One body with a void, one inside out, one open sheet: faces in another order than quads."""
    vertices, quads = nets.sphere(8)
    sheet, cells = nets.plane(4, 3)
    inside_out = quads[:, ::-1]
    pieces = [(0.3 * sheet - 4.0, cells), (2.0 * vertices, quads)]
    pieces += [(0.5 * vertices + 5.0, inside_out), (vertices, inside_out)]
    first = np.cumsum([0, *(len(points) for points, _ in pieces)])
    corners = [faces + n for (_, faces), n in zip(pieces, first[:-1], strict=True)]
    net = smooth(np.concatenate([points for points, _ in pieces]), np.concatenate(corners))
    solid = patch_solid(net, None, 0.4)
    rng = np.random.default_rng(0)
    points = net.vertices[rng.integers(0, len(net.vertices), 800)]
    points = points + 0.1 * rng.normal(size=points.shape)
    plain = certify(solid.shape, points, 0.4, 0.1)
    found = certify(solid.shape, points, 0.4, 0.1, solid.mesh)
    np.testing.assert_allclose(found.found.distance, plain.found.distance, atol=1e-9)
    np.testing.assert_array_equal(found.found.face, plain.found.face)
    assert len(set(plain.found.face.tolist())) == 3 * 6 + 1
    # The ball of radius 2 has a void of radius 1: its matter lies between.
    height = np.linalg.norm(points, axis=1)
    clear = (height < 3.0) & (np.abs(found.found.distance) > 0.02)
    is_outside = (height > 2.0) | (height < 1.0)
    np.testing.assert_array_equal((found.found.distance > 0.0)[clear], is_outside[clear])


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_the_shape_follows_a_motion_and_a_scale(nets, scale):
    vertices, quads = nets.sphere(3)
    rotation = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    rotation *= np.sign(np.linalg.det(rotation))
    plain = check_shape(patchwork.build_patchwork(smooth(vertices, quads)).shape)
    image = scale * (vertices @ rotation.T + [5.0, -3.0, 2.0])
    moved = check_shape(patchwork.build_patchwork(smooth(image, quads)).shape, spacing=scale)
    assert moved.is_valid
    assert moved.is_closed
    assert moved.n_faces == plain.n_faces
    assert moved.volume == pytest.approx(scale**3 * plain.volume, rel=1e-6)


def test_equal_nets_give_equal_files(nets):
    contents = [
        step_bytes(patchwork.build_patchwork(creased_grid(nets)).shape, has_pcurves=False)
        for _ in range(2)
    ]
    assert contents[0] == contents[1]


def test_a_file_that_reads_back_as_something_else_is_refused(nets, tmp_path, monkeypatch):
    patches = patchwork.build_patchwork(sharp_box(nets, 1))
    other = patchwork.build_patchwork(smooth(*nets.torus(6, 4)))
    content = step_bytes(other.shape, has_pcurves=False)
    monkeypatch.setattr(patchwork, "step_bytes", lambda *_, **__: content)
    with pytest.raises(ReconstructionError, match="does not read back"):
        write_patchwork(patches, tmp_path / "part.step")
    assert not list(tmp_path.iterdir())


def test_what_is_no_surface_is_refused(nets):
    vertices, quads, _ = nets.box(1)
    with pytest.raises(InputError, match="the net is no surface"):
        patchwork.build_patchwork(smooth(vertices, np.vstack([quads, quads[:1]])))


@pytest.mark.parametrize("seed", range(8))
def test_any_creases_and_corners_give_a_valid_shape(nets, seed):
    """Creases that end, cross, branch and zigzag, and loose corners, on a ragged net."""
    rng = np.random.default_rng(seed)
    vertices, quads = (
        nets.box(3)[:2],
        nets.torus(5, 4),
        nets.plane(6, 5),
        nets.sphere(3),
    )[seed % 4]
    vertices = vertices + 0.05 * rng.normal(size=vertices.shape)
    if seed >= 4:  # holes, and sheets that touch in a vertex
        quads = quads[rng.random(len(quads)) < 0.85]
    pairs = np.stack([quads.ravel(), np.roll(quads, -1, axis=1).ravel()], axis=1)
    sides = np.unique(np.sort(pairs, axis=1), axis=0)
    creases = sides[rng.random(len(sides)) < 0.15]
    corners = rng.choice(len(vertices), 3, replace=False)
    patches = patchwork.build_patchwork(separated(CreasedNet(vertices, quads, creases, corners)))
    assert measure_joins(patches.quilt).largest_gap < 1e-13 * np.abs(vertices).max() * 10
    check = check_shape(patches.shape)
    assert check.is_valid
    assert check.is_closed == patches.quilt.is_closed
    n_border = sum(edge.right is None for edge in patches.quilt.edges)
    assert n_free_edges(patches.shape) == n_border
