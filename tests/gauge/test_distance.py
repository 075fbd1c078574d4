"""Signed distances against OCCT's own, point by point."""

import brep_models
import numpy as np
import pytest
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex, BRepBuilderAPI_Transform
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakePrism, BRepPrimAPI_MakeRevol
from OCP.gp import gp_Ax1, gp_Ax2, gp_Dir, gp_Pnt, gp_Trsf, gp_Vec
from OCP.TopAbs import TopAbs_State
from OCP.TopoDS import TopoDS_Compound

from crispline import occt
from crispline.brep.build import build_shape
from crispline.brep.patchwork import build_patchwork
from crispline.errors import InputError
from crispline.gauge.accuracy import surface_samples
from crispline.gauge.carriers import carriers
from crispline.gauge.distance import deviations

SPACING = 1.0


def profile():
    """An edge on a cubic B-spline in the xz plane, away from the z axis."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge

    from crispline.curve import BSplineCurve

    points = np.array([[8.0, 0, 0], [12.0, 0, 4], [6.0, 0, 9], [9.0, 0, 14], [8.0, 0, 18]])
    knots = np.array([0.0, 0, 0, 0, 0.5, 1, 1, 1, 1])
    curve = BSplineCurve(knots, points)
    return BRepBuilderAPI_MakeEdge(occt.curve_to_occt(curve)).Edge()


def mirrored(shape):
    flip = gp_Trsf()
    flip.SetMirror(gp_Ax2(gp_Pnt(3, 1, 2), gp_Dir(1, 2, 3)))
    return BRepBuilderAPI_Transform(shape, flip, True).Shape()


SHAPES = {
    "fillet": lambda: build_shape(brep_models.fillet().model).shape,
    "conical hole": lambda: build_shape(brep_models.conical_hole().model).shape,
    "frustum": lambda: build_shape(brep_models.frustum().model).shape,
    "rounded box": lambda: build_shape(brep_models.rounded_box().model).shape,
    "whole sphere": lambda: build_shape(brep_models.whole_sphere().model).shape,
    "spline top": lambda: build_shape(brep_models.spline_top().model).shape,
    "mirrored fillet": lambda: mirrored(build_shape(brep_models.fillet().model).shape),
    "half vase": lambda: build_shape(brep_models.half_vase().model).shape,
    "open box": lambda: build_shape(brep_models.open_box().model).shape,
    "extrusion": lambda: BRepPrimAPI_MakePrism(profile(), gp_Vec(1, 20, 3)).Shape(),
    "revolution": lambda: BRepPrimAPI_MakeRevol(
        profile(), gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 4.0
    ).Shape(),
}


def around(shape, n_points, far):
    """Points on and off the faces, half of them near the edges, up to a distance."""
    stream = np.random.default_rng(1)
    on_faces = surface_samples(shape, n_points, 0.01 * SPACING)
    return on_faces + stream.normal(size=on_faces.shape) * far * stream.random((n_points, 1))


def exact(points, shape):
    """Naive twin: one point at a time, from the faces, as solids hold what is inside them."""
    faces = TopoDS_Compound()
    BRep_Builder().MakeCompound(faces)
    for face in occt.subshapes(shape, occt.FACE):
        BRep_Builder().Add(faces, face)
    vertices = [BRepBuilderAPI_MakeVertex(occt.point(point)).Vertex() for point in points]
    return np.array([BRepExtrema_DistShapeShape(vertex, faces).Value() for vertex in vertices])


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("far", [0.3, 3.0])
def test_distances_are_exact(name, far):
    shape = SHAPES[name]()
    points = around(shape, 120, far)
    found = deviations(shape, points, SPACING)
    assert np.abs(np.abs(found.distance) - exact(points, shape)).max() < 1e-3 * SPACING
    assert np.allclose(np.linalg.norm(points - found.foot, axis=1), np.abs(found.distance))
    assert exact(found.foot[:30], shape).max() < 1e-3 * SPACING
    # The foot lies on the very face that is named.
    faces = occt.subshapes(shape, occt.FACE)
    for i in range(20):
        vertex = BRepBuilderAPI_MakeVertex(occt.point(found.foot[i])).Vertex()
        away = BRepExtrema_DistShapeShape(vertex, faces[found.face[i]]).Value()
        assert away < 1e-3 * SPACING


@pytest.mark.parametrize(
    "name", ["fillet", "conical hole", "rounded box", "mirrored fillet", "half vase"]
)
def test_points_outside_are_positive(name):
    shape = SHAPES[name]()
    points = around(shape, 200, 2.0)
    found = deviations(shape, points, SPACING)
    solid = occt.subshapes(shape, occt.SOLID)[0]
    state = [
        BRepClass3d_SolidClassifier(solid, occt.point(point), 1e-7).State() for point in points
    ]
    is_outside = np.array([s == TopAbs_State.TopAbs_OUT for s in state])
    is_clear = np.abs(found.distance) > 1e-3 * SPACING
    assert 25 < is_outside.sum() < 175
    assert np.array_equal(found.distance[is_clear] > 0.0, is_outside[is_clear])


def test_a_turned_spline_is_read_back_as_one():
    sample = brep_models.half_vase()
    found = carriers(occt.subshapes(build_shape(sample.model).shape, occt.FACE))
    kinds = [kind for kind, _ in found.described()]
    assert sorted(kinds) == ["plane", "plane", "plane", "revolution"]
    told = found.described()[kinds.index("revolution")][1]
    piece = brep_models.vase_profile().between(0.0, 15.0).reversed()
    assert np.allclose(told["knots"], piece.knots)
    assert np.allclose(told["radii"], piece.control_points[:, 0])


def test_the_corner_of_a_box_by_hand():
    box = BRepPrimAPI_MakeBox(10.0, 20.0, 30.0).Shape()
    points = np.array([[13.0, 24.0, 30.0], [12.0, 21.0, 32.0], [9.0, 10.0, 15.0], [5.0, 5.0, 31.0]])
    found = deviations(box, points, SPACING)
    assert np.allclose(found.distance, [5.0, 3.0, -1.0, 1.0])
    assert np.allclose(found.foot[:2], [10.0, 20.0, 30.0])
    assert np.allclose(found.foot[2:], [[10.0, 10.0, 15.0], [5.0, 5.0, 30.0]])


def test_a_long_thin_strip_is_found_from_its_middle():
    box = BRepPrimAPI_MakeBox(200.0, 0.05, 40.0).Shape()
    points = np.array([[100.0, 0.02, 40.3], [57.3, 0.03, -0.2]])
    found = deviations(box, points, SPACING)
    assert np.allclose(found.distance, [0.3, 0.2])
    assert np.allclose(found.foot[:, 2], [40.0, 0.0])


def test_many_patches_follow_the_same_rule(nets):
    vertices, quads, _ = nets.box(6, half=10.0)
    from crispline.spline.creased import CreasedNet

    none = np.zeros((0, 2), dtype=np.int64)
    shape = build_patchwork(CreasedNet(vertices, quads, none, np.arange(0, 200, 9))).shape
    points = around(shape, 80, 1.0)
    found = deviations(shape, points, SPACING)
    assert len(occt.subshapes(shape, occt.FACE)) > 20
    assert np.abs(np.abs(found.distance) - exact(points, shape)).max() < 1e-3 * SPACING


@pytest.mark.parametrize("factor", [1000.0, 1e-4])
def test_the_unit_does_not_matter(factor):
    shape = SHAPES["rounded box"]()
    points = around(shape, 200, 0.5)
    grow = gp_Trsf()
    grow.SetScaleFactor(factor)
    other = BRepBuilderAPI_Transform(shape, grow, True).Shape()
    one = deviations(shape, points, SPACING)
    found = deviations(other, factor * points, factor * SPACING)
    assert np.allclose(found.distance, factor * one.distance, atol=1e-3 * factor * SPACING)


def test_no_point_and_no_face():
    box = BRepPrimAPI_MakeBox(1.0, 1.0, 1.0).Shape()
    assert deviations(box, np.empty((0, 3)), SPACING).foot.shape == (0, 3)
    empty = TopoDS_Compound()
    BRep_Builder().MakeCompound(empty)
    with pytest.raises(InputError, match="at least one face"):
        deviations(empty, np.zeros((1, 3)), SPACING)
