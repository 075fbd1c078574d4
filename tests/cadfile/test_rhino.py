"""Solids in the archive of openNURBS: what that library makes of them."""

import base64

import brep_models
import numpy as np
import pytest
import rhino3dm
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeBox,
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)

from crispline import occt
from crispline.brep.build import build_shape
from crispline.cadfile.opennurbs import TrimKind, encode
from crispline.cadfile.rhino import brep_tables

# Solid, its numbers of faces and of edges.
SIMPLE = {
    "box": (BRepPrimAPI_MakeBox(1.0, 2.0, 3.0), 6, 12),
    "cylinder": (BRepPrimAPI_MakeCylinder(5.0, 10.0), 3, 3),
    "cone": (BRepPrimAPI_MakeCone(5.0, 0.0, 10.0), 2, 2),
    "sphere": (BRepPrimAPI_MakeSphere(5.0), 1, 1),
    "torus": (BRepPrimAPI_MakeTorus(5.0, 2.0), 1, 2),
}


def decoded(tables):
    """What openNURBS reads in the archive."""
    ball = rhino3dm.Brep.CreateFromSphere(rhino3dm.Sphere(rhino3dm.Point3d(0, 0, 0), 1.0))
    envelope = ball.Encode()
    envelope["data"] = base64.b64encode(encode(tables)).decode()
    return rhino3dm.CommonObject.Decode(envelope)


@pytest.mark.parametrize("name", SIMPLE)
def test_closed_surfaces_seams_and_poles(name):
    maker, n_faces, n_edges = SIMPLE[name]
    tables = brep_tables(maker.Shape())
    solid = decoded(tables)
    assert solid.IsValid, solid.IsValidWithLog
    assert solid.IsSolid
    assert (len(solid.Faces), len(solid.Edges)) == (n_faces, n_edges)
    kinds = {trim.kind for trim in tables.trims}
    assert (TrimKind.SEAM in kinds) == (name != "box")
    assert (TrimKind.SINGULAR in kinds) == (name in ("cone", "sphere"))


@pytest.mark.parametrize("name", ["box_cylinder", "spline_top", "two_boxes"])
def test_models_of_the_package(name):
    shape = build_shape(brep_models.SAMPLES[name]().model).shape
    solid = decoded(brep_tables(shape))
    assert solid.IsValid, solid.IsValidWithLog
    assert solid.IsSolid
    assert len(solid.Faces) == len(occt.subshapes(shape, occt.FACE))


def test_surfaces_are_the_exact_ones():
    solid = decoded(brep_tables(BRepPrimAPI_MakeSphere(5.0).Shape()))
    surface = solid.Faces[0].UnderlyingSurface()
    u, v = surface.Domain(0), surface.Domain(1)
    shares = np.linspace(0.05, 0.95, 7)
    points = [
        surface.PointAt(u.T0 + a * (u.T1 - u.T0), v.T0 + b * (v.T1 - v.T0))
        for a in shares
        for b in shares
    ]
    radius = [np.hypot(np.hypot(p.X, p.Y), p.Z) for p in points]
    np.testing.assert_allclose(radius, 5.0, rtol=1e-14)


def test_an_open_shell_is_no_solid():
    lid = occt.subshapes(BRepPrimAPI_MakeCylinder(5.0, 10.0).Shape(), occt.FACE)[0]
    tables = brep_tables(lid)
    shell = decoded(tables)
    assert (shell.IsValid, shell.IsSolid, tables.is_solid) == (True, False, False)


def test_the_same_shape_gives_the_same_bytes():
    contents = [encode(brep_tables(BRepPrimAPI_MakeTorus(5.0, 2.0).Shape())) for _ in range(2)]
    assert contents[0] == contents[1]


def test_a_damaged_archive_is_no_solid():
    content = bytearray(encode(brep_tables(BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape())))
    content[len(content) // 2] ^= 0xFF
    ball = rhino3dm.Brep.CreateFromSphere(rhino3dm.Sphere(rhino3dm.Point3d(0, 0, 0), 1.0))
    envelope = ball.Encode()
    envelope["data"] = base64.b64encode(bytes(content)).decode()
    solid = rhino3dm.CommonObject.Decode(envelope)
    assert solid is None or not solid.IsValid
