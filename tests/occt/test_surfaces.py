"""B-spline surfaces made by OCCT, as values and back, in STEP and IGES files."""

from dataclasses import replace

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
from OCP.collections import Array2_gp_Pnt
from OCP.Geom import (
    Geom_BezierSurface,
    Geom_CylindricalSurface,
    Geom_RectangularTrimmedSurface,
)
from OCP.GeomAPI import GeomAPI_PointsToBSplineSurface
from OCP.GeomConvert import GeomConvert
from OCP.gp import gp_Ax3, gp_Pnt, gp_Vec
from OCP.Interface import Interface_Static
from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopoDS import TopoDS

from crispline import occt
from crispline.cadfile.step import quieten
from crispline.cadfile.surface_files import MILLIMETRES, read_faces, write_faces
from crispline.errors import InputError, ReconstructionError
from crispline.occt.surfaces import face_shape, faces_from_occt, surface_from_occt, surface_to_occt
from crispline.spline.tensor import TensorSpline, spline_over_grid


def points_array(points):
    array = Array2_gp_Pnt(1, len(points), 1, len(points[0]))
    for i, row in enumerate(points, start=1):
        for j, place in enumerate(row, start=1):
            array.SetValue(i, j, occt.point(place))
    return array


def wavy_grid(m=9, n=8):
    x, y = np.meshgrid(np.arange(float(m)), np.arange(float(n)), indexing="ij")
    return np.stack([x, y, np.sin(x / 2.0) * np.cos(y / 3.0)], axis=-1)


@pytest.fixture(scope="module")
def interpolated():
    """A surface through points, as someone else's program makes it."""
    maker = GeomAPI_PointsToBSplineSurface(points_array(wavy_grid()), 3, 3)
    return maker.Surface()


@pytest.fixture(scope="module")
def tube():
    """A whole cylinder as a periodic rational B-spline of degree 2 x 1."""
    cylinder = Geom_CylindricalSurface(gp_Ax3(), 2.0)
    piece = Geom_RectangularTrimmedSurface(cylinder, 0.0, 2.0 * np.pi, 0.0, 3.0)
    return GeomConvert.SurfaceToBSplineSurface_s(piece)


def creased(is_rational=False):
    """A bicubic surface with a crease along a column and one across, C0 there."""
    spline = spline_over_grid(wavy_grid()).with_knot_u(4.0, 3).with_knot_v(2.5, 3)
    net = spline.control_points.copy()
    weights = None
    if is_rational:
        weights = np.random.default_rng(0).uniform(0.5, 2.0, net.shape[:2])
    i = int(np.searchsorted(spline.knots_u, 4.0)) - 1
    j = int(np.searchsorted(spline.knots_v, 2.5)) - 1
    net[i, :, 2] += 0.7
    net[:, j, 2] += 0.5
    return replace(spline, control_points=net, weights=weights).clamped()


def assert_equal(found, expected, rtol=1e-12):
    size = np.abs(expected.control_points).max()
    assert (found.degree_u, found.degree_v) == (expected.degree_u, expected.degree_v)
    np.testing.assert_allclose(found.knots_u, expected.knots_u, rtol=rtol, atol=1e-14)
    np.testing.assert_allclose(found.knots_v, expected.knots_v, rtol=rtol, atol=1e-14)
    np.testing.assert_allclose(
        found.control_points, expected.control_points, rtol=0, atol=rtol * size
    )
    if expected.weights is None:
        assert found.weights is None
    else:
        np.testing.assert_allclose(found.weights, expected.weights, rtol=rtol)


def occt_values(surface, u, v):
    """Point and derivatives up to the second order, as OCCT computes them."""
    values = []
    for a, b in zip(u, v, strict=True):
        point, vectors = gp_Pnt(), [gp_Vec() for _ in range(5)]
        surface.D2(float(a), float(b), point, *vectors)
        values.append([(q.X(), q.Y(), q.Z()) for q in (point, *vectors)])
    return np.array(values)


ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (0, 2), (1, 1))


@pytest.mark.parametrize("name", ["interpolated", "tube"])
def test_values_and_derivatives_are_those_of_occt(name, request):
    surface = request.getfixturevalue(name)
    spline = surface_from_occt(surface)
    (u0, u1), (v0, v1) = spline.domain
    rng = np.random.default_rng(1)
    u, v = rng.uniform(u0, u1, 50), rng.uniform(v0, v1, 50)
    expected = occt_values(surface, u, v)
    for k, orders in enumerate(ORDERS):
        np.testing.assert_allclose(spline.evaluate(u, v, *orders), expected[:, k], atol=1e-10)


def test_a_periodic_cylinder_is_opened_and_round(tube):
    assert tube.IsUPeriodic()
    spline = surface_from_occt(tube)
    assert tube.IsUPeriodic()  # the surface itself stays as it was
    assert spline.weights is not None
    assert spline.domain == ((0.0, pytest.approx(2.0 * np.pi)), (0.0, 3.0))
    cubic = spline.elevated()
    rng = np.random.default_rng(2)
    points = cubic.evaluate(rng.uniform(0.0, 6.28, 100), rng.uniform(0.0, 3.0, 100))
    np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 2.0, atol=1e-12)


def test_bezier_surfaces_are_splines_of_one_span():
    net = np.random.default_rng(3).normal(size=(4, 3, 3))
    spline = surface_from_occt(Geom_BezierSurface(points_array(net)))
    assert spline.knots_u.tolist() == [0.0] * 4 + [1.0] * 4
    assert (spline.degree_u, spline.degree_v) == (3, 2)
    np.testing.assert_allclose(spline.control_points, net, atol=1e-15)


def test_a_trimmed_wrapper_is_the_piece_inside(interpolated):
    piece = Geom_RectangularTrimmedSurface(interpolated, 0.2, 0.7, 0.1, 0.5)
    spline = surface_from_occt(piece)
    assert spline.domain == ((0.2, 0.7), (0.1, 0.5))
    u, v = np.linspace(0.2, 0.7, 9), np.linspace(0.1, 0.5, 9)
    whole = surface_from_occt(interpolated)
    np.testing.assert_allclose(spline.evaluate(u, v), whole.evaluate(u, v), atol=1e-12)


def test_other_surfaces_are_no_splines():
    assert surface_from_occt(Geom_CylindricalSurface(gp_Ax3(), 2.0)) is None


@pytest.mark.parametrize("is_rational", [False, True])
def test_occt_gives_back_what_it_was_given(is_rational):
    spline = creased(is_rational)
    assert_equal(surface_from_occt(surface_to_occt(spline)), spline, 1e-15)


def test_unclamped_surfaces_are_given_clamped():
    spline = spline_over_grid(wavy_grid())
    assert_equal(surface_from_occt(surface_to_occt(spline)), spline.clamped(), 1e-15)


@pytest.mark.parametrize("suffix", [".step", ".stp", ".iges", ".igs"])
@pytest.mark.parametrize("is_rational", [False, True])
def test_a_creased_surface_is_one_valid_face_and_reads_back_to_12_digits(
    tmp_path, suffix, is_rational
):
    spline = creased(is_rational)
    shape = face_shape([spline])
    assert BRepCheck_Analyzer(shape).IsValid()
    path = tmp_path / f"crease{suffix}"
    write_faces(path, [spline])
    found = read_faces(path)
    assert len(found.splines) == 1
    assert (found.unit, found.n_trimmed, found.left_out) == ("mm", 0, {})
    assert_equal(found.splines[0], spline)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("unit", sorted(MILLIMETRES))
def test_numbers_stay_in_the_unit_of_the_file(tmp_path, suffix, unit):
    spline = creased()
    write_faces(tmp_path / f"a{suffix}", [spline], unit)
    found = read_faces(tmp_path / f"a{suffix}")
    assert found.unit == unit
    assert_equal(found.splines[0], spline)


def test_an_inch_is_25_millimetres_and_four_tenths(tmp_path):
    write_faces(tmp_path / "a.step", [creased()], "in")
    content = (tmp_path / "a.step").read_bytes()
    assert b"CONVERSION_BASED_UNIT('INCH'" in content
    write_faces(tmp_path / "b.igs", [creased()], "in")
    assert b"4HINCH" in (tmp_path / "b.igs").read_bytes()


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("scale", [1e-4, 1e-3, 1e3, 1e6])
def test_files_are_as_exact_at_any_size(tmp_path, suffix, scale):
    spline = creased(is_rational=True)
    spline = replace(spline, control_points=scale * spline.control_points)
    write_faces(tmp_path / f"a{suffix}", [spline])
    assert_equal(read_faces(tmp_path / f"a{suffix}").splines[0], spline)


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_several_surfaces_stay_several_faces_in_order(tmp_path, suffix, tube):
    splines = [creased(), surface_from_occt(tube).elevated(), creased(is_rational=True)]
    write_faces(tmp_path / f"a{suffix}", splines)
    found = read_faces(tmp_path / f"a{suffix}")
    for one, other in zip(found.splines, splines, strict=True):
        assert_equal(one, other.clamped())
    assert found.n_trimmed == 0


@pytest.mark.parametrize("suffix", [".step", ".igs"])
def test_equal_surfaces_give_equal_bytes_without_names_or_times(tmp_path, suffix, capfd):
    contents = []
    for name in ("a", "b"):
        write_faces(tmp_path / f"{name}{suffix}", [creased()])
        contents.append((tmp_path / f"{name}{suffix}").read_bytes())
        read_faces(tmp_path / f"{name}{suffix}")
    assert contents[0] == contents[1]
    assert b"1970" in contents[0]
    assert capfd.readouterr() == ("", "")


def write_with_occt(path, shape, unit="MM"):
    """A STEP file as another program writes it."""
    quieten()
    Interface_Static.SetCVal_s("write.step.unit", unit)
    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))


def test_a_file_of_another_program_is_read(tmp_path, interpolated):
    face = BRepBuilderAPI_MakeFace(interpolated, 1e-7).Face()
    write_with_occt(tmp_path / "part.step", face, "INCH")
    found = read_faces(tmp_path / "part.step")
    assert found.unit == "in"
    expected = surface_from_occt(interpolated)
    expected = replace(expected, control_points=expected.control_points / 25.4)
    assert_equal(found.splines[0], expected, 1e-11)  # it writes 12 digits


def test_faces_bounded_by_a_parameter_rectangle_are_cut_to_it(interpolated):
    face = BRepBuilderAPI_MakeFace(interpolated, 0.2, 0.7, 0.1, 0.5, 1e-7).Face()
    found = faces_from_occt(face, "a shape")
    assert found.n_trimmed == 0
    np.testing.assert_allclose(found.splines[0].domain, ((0.2, 0.7), (0.1, 0.5)), atol=1e-9)


def test_faces_with_any_other_border_are_counted(interpolated):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    sheet = BRepBuilderAPI_MakeFace(interpolated, 1e-7).Face()
    drill = BRepPrimAPI_MakeCylinder(1.5, 20.0).Shape()
    move = occt.transform(drill, occt.Similarity(1.0, np.eye(3), np.array([4.0, 4.0, -10.0])))
    found = faces_from_occt(BRepAlgoAPI_Cut(sheet, move).Shape(), "a shape")
    assert found.n_trimmed == 1
    assert_equal(found.splines[0], surface_from_occt(interpolated))


def test_a_reversed_face_has_its_normal_outside(interpolated):
    face = BRepBuilderAPI_MakeFace(interpolated, 1e-7).Face()
    turned = TopoDS.Face(face.Oriented(TopAbs_Orientation.TopAbs_REVERSED))
    found = faces_from_occt(turned, "a shape").splines[0]
    assert_equal(found, surface_from_occt(interpolated).transposed())


def test_faces_of_other_kinds_are_named(tmp_path, interpolated):
    face = BRepBuilderAPI_MakeFace(interpolated, 1e-7).Face()
    assert faces_from_occt(face, "x").left_out == {}
    write_with_occt(tmp_path / "drum.step", BRepPrimAPI_MakeCylinder(1.0, 2.0).Shape())
    sentence = r"B-spline faces, found faces of other kinds \(1 cylinder, 2 plane\); convert"
    with pytest.raises(InputError, match=rf"drum\.step': expected a STEP file with {sentence}"):
        read_faces(tmp_path / "drum.step")
    write_with_occt(tmp_path / "box.step", BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape())
    with pytest.raises(InputError, match=r"found faces of other kinds \(6 plane\)"):
        read_faces(tmp_path / "box.step")


@pytest.mark.parametrize("suffix", [".step", ".igs"])
@pytest.mark.parametrize("content", [b"solid", b"ISO-10303-21;\nHEADER;\n", b"S      1\n"])
def test_other_content_is_refused(tmp_path, suffix, content, capfd):
    path = tmp_path / f"part{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"part.* with a shape, found content that cannot be read"):
        read_faces(path)
    assert capfd.readouterr() == ("", "")


def test_unknown_units_are_refused(tmp_path):
    with pytest.raises(InputError, match=r"a length unit out of mm, um, .*, got 'parsec'"):
        write_faces(tmp_path / "a.step", [creased()], "parsec")


def test_what_gives_no_face_is_refused_and_leaves_no_file(tmp_path):
    point = TensorSpline(3, 3, *([np.repeat([0.0, 1.0], 4)] * 2), np.zeros((4, 4, 3)))
    with pytest.raises(ReconstructionError, match="surface 2 gives no valid face"):
        write_faces(tmp_path / "a.step", [creased(), point])
    assert list(tmp_path.iterdir()) == []


def test_names_outside_ascii_are_fine(tmp_path):
    path = tmp_path / "Fläche №1.igs"
    write_faces(path, [creased()])
    assert_equal(read_faces(path).splines[0], creased())


def test_the_face_lies_on_the_surface_it_was_made_of():
    face = occt.subshapes(face_shape([creased()]), occt.FACE)[0]
    assert_equal(surface_from_occt(BRep_Tool.Surface_s(face)), creased(), 1e-15)
