"""Faces that can be told apart, their size, and which are recovered."""

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

from parts.faces import by_inradius, recovered, true_faces
from parts.modelling import box, fillet, sphere
from parts.scan import scan


def faces_of(shape, n_points=6000):
    truth, _ = scan(shape, n_points)
    return truth, true_faces(truth)


def half_cylinder(turn):
    frame = gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1), gp_Dir(turn, 0, 0))
    return BRepPrimAPI_MakeCylinder(frame, 10.0, 30.0, np.pi).Shape()


def test_a_cylinder_cut_in_halves_has_three_faces():
    truth, faces = faces_of(BRepAlgoAPI_Fuse(half_cylinder(1), half_cylinder(-1)).Shape())
    assert truth.n_faces == 6
    assert len(faces.inradius) == 3


def test_a_plane_cut_in_two_is_one_face():
    pair = BRepAlgoAPI_Fuse(box((30, 40, 20)), box((30, 40, 20), (30, 0, 0))).Shape()
    truth, faces = faces_of(pair)
    assert truth.n_faces == 10
    assert len(faces.inradius) == 6


def test_tangent_faces_on_two_surfaces_stay_apart():
    rounded = fillet(box((40, 30, 20)), 6.0, lambda m: bool(m[0] > 39 and m[1] > 29))
    truth, faces = faces_of(rounded)
    assert len(faces.inradius) == truth.n_faces == 7


def test_the_inradius_of_the_faces_of_a_box():
    truth, faces = faces_of(box((60, 40, 30)))
    found = np.sort(faces.inradius * truth.spacing)
    np.testing.assert_allclose(found, [15, 15, 15, 15, 20, 20], atol=1.5 * truth.spacing)


def test_a_thin_wall_does_not_make_its_faces_narrow():
    truth, faces = faces_of(box((60, 40, 1.3)), 12_000)
    assert truth.spacing < 1.3 < 2 * truth.spacing + 0.8
    large = np.sort(faces.inradius * truth.spacing)[-2:]
    np.testing.assert_allclose(large, 20, atol=1.5 * truth.spacing)


def test_a_face_without_a_border_is_large():
    _, faces = faces_of(sphere(10), 2000)
    assert faces.inradius.tolist() == [np.inf]


@pytest.fixture(scope="module")
def block():
    return faces_of(box((60, 40, 30)))


def test_one_to_one(block):
    _, faces = block
    assert recovered(faces, faces.label).all()
    # Two model faces on true face 0: neither holds 80 % of it.
    split = faces.label.copy()
    split[np.flatnonzero(split == 0)[::2]] = 6
    assert recovered(faces, split).tolist() == [False, True, True, True, True, True]
    # One model face on the true faces 0 and 1, which are of one size.
    joined = np.where(faces.label == 1, 0, faces.label)
    assert recovered(faces, joined).tolist() == [False, False, True, True, True, True]
    assert by_inradius(faces, recovered(faces, joined)) == [(0, 0), (0, 0), (4, 6)]


def test_the_cuts_of_the_cad_system_are_right_too():
    _, faces = faces_of(BRepAlgoAPI_Fuse(half_cylinder(1), half_cylinder(-1)).Shape())
    assert recovered(faces, faces.given).all()
    assert recovered(faces, faces.label).all()
