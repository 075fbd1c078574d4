"""Areas and volumes of shapes by a rule that ends on every face."""

import numpy as np
import pytest
from OCP.BRepGProp import BRepGProp
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder, BRepPrimAPI_MakeTorus

from crispline.occt import measure

TORUS = BRepPrimAPI_MakeTorus(7.0, 2.0).Shape()
SECTOR = BRepPrimAPI_MakeCylinder(3.0, 5.0, np.radians(190.0)).Shape()


def test_volumes_of_plain_shapes_are_exact():
    assert measure.volume(TORUS) == pytest.approx(2.0 * np.pi**2 * 7.0 * 4.0, rel=1e-9)
    assert measure.volume(SECTOR) == pytest.approx(0.5 * np.radians(190.0) * 45.0, rel=1e-9)


def test_areas_of_plain_shapes_are_exact():
    areas = np.sort(measure.face_areas(SECTOR))
    turned, cap, cut = np.radians(190.0) * 15.0, np.radians(190.0) * 4.5, 15.0
    np.testing.assert_allclose(areas, np.sort([cap, cap, cut, cut, turned]), rtol=1e-9)


def test_elementary_faces_need_no_adaptive_rule(monkeypatch):
    # On a valid cylinder face they raised an index error once and hung another time.
    class Strict:
        @staticmethod
        def VolumeProperties_s(shape, properties):
            BRepGProp.VolumeProperties_s(shape, properties)

        @staticmethod
        def SurfaceProperties_s(shape, properties):
            BRepGProp.SurfaceProperties_s(shape, properties)

    monkeypatch.setattr(measure, "BRepGProp", Strict)
    assert measure.volume(TORUS) > 0.0
    assert measure.face_areas(TORUS).min() > 0.0
