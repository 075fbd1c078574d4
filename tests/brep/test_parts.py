"""The mathematics under the builder: charts, cuts, parameter curves, distances."""

import brep_models
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crispline.brep.arcs import is_inside, trace_loops
from crispline.brep.build import build_shape
from crispline.brep.chart import TURN, BSplineChart, PlaneChart
from crispline.brep.pcurve import pcurve
from crispline.brep.revolved import (
    ConeChart,
    CylinderChart,
    ProfileChart,
    SphereChart,
    TorusChart,
)
from crispline.brep.seam import choose_seams
from crispline.brep.sphere import sphere_axis
from crispline.brep.split import recut, split_curve, split_model
from crispline.curve import Circle, Line
from crispline.gauge.deviation import point_triangle_distance, sample_triangles
from crispline.occt.measure import face_areas, tessellate, volume
from crispline.surface import perpendicular_frame, unit

ORIGIN, AXIS = np.array([1.0, 2.0, 3.0]), unit(np.array([1.0, -2.0, 0.5]))
FRAME = (ORIGIN, AXIS, perpendicular_frame(AXIS)[0])
SPLINE = brep_models.spline_top().model.faces[-1].surface
CHARTS = [
    PlaneChart(*FRAME),
    CylinderChart(*FRAME, 4.0),
    ConeChart(*FRAME, 4.0, 0.6),
    SphereChart(*FRAME, 4.0),
    TorusChart(*FRAME, 9.0, 4.0, 1.0),
    ProfileChart(*FRAME, brep_models.vase_profile()),
    BSplineChart(SPLINE),
]


def inside(chart, share):
    low, high = np.clip(np.transpose([chart.u_range, chart.v_range]), -5.0, 12.0)
    return np.array([low + share * (high - low)])


shares = st.tuples(st.floats(0.02, 0.98), st.floats(0.02, 0.98))


@pytest.mark.parametrize("chart", CHARTS, ids=lambda chart: type(chart).__name__)
@given(share=shares)
def test_chart_agrees_with_occt_and_inverts(chart, share):
    uv = inside(chart, share)
    point = chart.points(uv)
    value = chart.geometry.Value(*uv[0])
    np.testing.assert_allclose(point[0], [value.X(), value.Y(), value.Z()], atol=1e-12)
    back = chart.parameters(point) - uv
    for axis in (0, 1):
        if chart.is_periodic[axis]:
            back[:, axis] -= TURN * np.round(back[:, axis] / TURN)
    np.testing.assert_allclose(back, 0.0, atol=1e-8)


def test_angle_at_a_pole_is_taken_from_the_border():
    chart = ConeChart(np.array([0, 0, 20.0]), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), 10, 0.5)
    apex = chart.pole_points()[0]
    ruling = apex + np.linspace(0, 1, 9)[:, None] * (chart.points(np.array([[2.0, 5.0]])) - apex)
    uv = chart.trace(ruling, np.arange(len(ruling)))
    np.testing.assert_allclose(uv[:, 0], 2.0)
    assert uv[0, 1] == pytest.approx(chart.v_range[0])
    assert chart.is_pole(uv[0])


CURVES = [
    Line(ORIGIN, AXIS, -1.0, 4.0),
    Circle(ORIGIN, AXIS, FRAME[2], 3.0, 0.5, 0.5 + TURN),
    brep_models.slanted_cylinder().model.edges[1].curve,
]


@pytest.mark.parametrize("curve", CURVES, ids=lambda curve: curve.kind)
@given(places=st.lists(st.floats(0.01, 0.99), min_size=1, max_size=4, unique=True))
def test_pieces_make_up_the_curve(curve, places):
    cuts = [curve.start + s * (curve.end - curve.start) for s in sorted(places)]
    pieces = split_curve(curve, cuts)
    ends = [curve.start, *cuts, curve.end]
    for piece, start, end in zip(pieces, ends[:-1], ends[1:], strict=True):
        assert (piece.start, piece.end) == pytest.approx((start, end), abs=1e-8)
        t = np.linspace(piece.start, piece.end, 7)
        np.testing.assert_allclose(piece.evaluate(t), curve.evaluate(t), atol=1e-9)


@pytest.mark.parametrize("curve", CURVES[1:], ids=lambda curve: curve.kind)
@given(share=st.floats(0.001, 0.999))
def test_recut_moves_only_the_ends(curve, share):
    period = curve.end - curve.start
    place = curve.start + share * period
    turned = recut(curve, place)
    assert (turned.start, turned.end) == pytest.approx((place, place + period), abs=1e-8)
    t = np.linspace(curve.start, curve.end, 50)
    later = np.clip(np.where(t < place, t + period, t), turned.start, turned.end)
    np.testing.assert_allclose(turned.evaluate(later), curve.evaluate(t), atol=1e-6)


def test_a_line_cannot_be_recut():
    with pytest.raises(ValueError, match="line cannot be closed"):
        recut(CURVES[0], 1.0)


def test_coaxial_rims_get_one_seam():
    model = brep_models.stepped_shaft().model
    seams = choose_seams(model)
    cut = split_model(model, seams.cuts)
    angles = np.arctan2(cut.vertices[:, 1], cut.vertices[:, 0])
    np.testing.assert_allclose(angles, angles[0], atol=1e-12)
    assert len(cut.edges) == len(model.edges)


def test_partial_cylinder_has_its_seam_opposite():
    model = brep_models.fillet().model
    chart = choose_seams(model).charts[-1]
    np.testing.assert_allclose(chart.x_axis, unit(np.array([-1.0, -1.0, 0.0])), atol=1e-9)


def test_lines_in_and_out_of_a_pierced_torus():
    model = brep_models.pierced_torus().model
    face = model.faces[0]
    chart = TorusChart(np.zeros(3), np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), 20.0, 6.0)
    loops = trace_loops(model, face, chart)
    assert is_inside(loops, chart, 0, np.pi)
    assert is_inside(loops, chart, 1, np.pi)
    around_the_hole = [
        [type(a)(a.edge, -a.sign, a.t[::-1], a.uv[::-1]) for a in loop] for loop in loops
    ]
    assert not is_inside(around_the_hole, chart, 0, np.pi)
    assert not is_inside(around_the_hole, chart, 1, np.pi)


def test_sphere_axis_keeps_the_poles_out():
    model = brep_models.rounded_box().model
    for face in model.faces[:8]:
        axis = sphere_axis(model, face, face.surface)
        border = np.concatenate([model.edges[e].curve.samples(50) for e, _ in face.loops[0]])
        latitude = np.arcsin(unit(border - face.surface.centre) @ axis)
        assert np.abs(latitude).max() < np.radians(60)


def test_coaxial_circle_is_a_line_on_a_cylinder():
    chart = CylinderChart(*FRAME, 4.0)
    circle = Circle(ORIGIN + 2 * AXIS, -AXIS, FRAME[2], 4.0, 0.0, TURN)
    border = np.column_stack([-np.linspace(0, TURN, 5), np.full(5, 2.0)])
    projected = pcurve(circle, chart, border)
    assert type(projected.geometry).__name__ == "Geom2d_Line"
    assert projected.deviation < 1e-12


def test_pcurve_measures_the_gap():
    chart = CylinderChart(*FRAME, 4.0)
    circle = Circle(ORIGIN, AXIS, FRAME[2], 4.25, 0.0, 2.0)
    border = np.column_stack([np.linspace(0, 2, 5), np.zeros(5)])
    assert pcurve(circle, chart, border).deviation == pytest.approx(0.25)


def test_distance_to_a_triangle_against_a_dense_sampling():
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*[np.linspace(0, 1, 200)] * 2), axis=-1).reshape(-1, 2)
    a, b = grid[grid.sum(axis=1) <= 1.0].T
    for _ in range(30):
        corners, point = rng.normal(size=(3, 3)), 2.0 * rng.normal(size=3)
        dense = np.stack([1 - a - b, a, b], axis=1) @ corners
        truth = np.linalg.norm(dense - point, axis=1).min()
        assert point_triangle_distance(point, corners) == pytest.approx(truth, abs=0.02)


def test_distance_to_a_collapsed_triangle_is_finite():
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    assert point_triangle_distance(np.array([1.0, 3, 0]), corners) == pytest.approx(3.0)


def test_samples_of_a_mesh_are_as_dense_as_asked():
    mesh = tessellate(build_shape(brep_models.box_cylinder().model).shape, 0.01)
    samples, owners = sample_triangles(mesh, 0.5)
    n_vertices = 3 * len(mesh.triangles)
    assert len(samples) - n_vertices == pytest.approx(mesh.areas().sum() / 0.25, rel=0.01)
    corners = mesh.vertices[mesh.triangles[owners]]
    assert point_triangle_distance(samples, corners).max() < 1e-9


def test_areas_volume_and_triangles_of_the_paper_model():
    shape = build_shape(brep_models.box_cylinder().model).shape
    disc, wall = np.pi * 144, TURN * 12 * 20
    expected = [2400, 2400 - disc, 1800, 1200, 1800, 1200, wall, disc]
    np.testing.assert_allclose(face_areas(shape), expected, rtol=1e-9)
    assert volume(shape) == pytest.approx(72000 + 20 * disc)
    mesh = tessellate(shape, 0.001, angle=0.02)
    per_face = np.bincount(mesh.faces, weights=mesh.areas())
    np.testing.assert_allclose(per_face, expected, rtol=1e-3)
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    enclosed = np.einsum("ij,ij->", a, np.cross(b, c)) / 6
    assert enclosed == pytest.approx(72000 + 20 * disc, rel=1e-4)
