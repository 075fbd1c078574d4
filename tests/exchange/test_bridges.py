"""Objects of other packages; those too large to install here are stood in for or skipped."""

import sys
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
import trimesh
from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox

from crispline.cloud.pointcloud import PointCloud
from crispline.errors import InputError, ReconstructionError
from crispline.exchange import to_build123d, to_cadquery, to_open3d, to_trimesh

RNG = np.random.default_rng(1)
POINTS, NORMALS = RNG.normal(size=(2, 30, 3))
CLOUD = PointCloud.from_arrays(POINTS, NORMALS)
BOX = BRepPrimAPI_MakeBox(1.0, 2.0, 3.0).Shape()


def test_trimesh():
    cloud = to_trimesh(CLOUD)
    assert isinstance(cloud, trimesh.PointCloud)
    np.testing.assert_array_equal(PointCloud.from_any(cloud).points, POINTS)


def test_open3d():
    open3d = pytest.importorskip("open3d")
    cloud = to_open3d(CLOUD)
    assert isinstance(cloud, open3d.geometry.PointCloud)
    back = PointCloud.from_any(cloud)
    np.testing.assert_array_equal(back.points, POINTS)
    np.testing.assert_allclose(back.normals, CLOUD.normals)


def test_build123d():
    pytest.importorskip("build123d")
    solid = to_build123d(BOX)
    assert solid.volume == pytest.approx(6.0)
    assert len(solid.faces()) == 6


@pytest.mark.parametrize("name", ["cadquery", "build123d"])
def test_the_shape_is_handed_over_as_it_is(monkeypatch, name):
    module = ModuleType(name)
    module.Shape = SimpleNamespace(cast=lambda shape: (name, shape))
    monkeypatch.setitem(sys.modules, name, module)
    convert = {"cadquery": to_cadquery, "build123d": to_build123d}[name]
    assert convert(BOX) == (name, BOX)
    part = SimpleNamespace(solid=SimpleNamespace(shape=BOX), valid=True)
    assert convert(part) == (name, BOX)
    with pytest.raises(ReconstructionError, match="no valid model to convert"):
        convert(SimpleNamespace(solid=None, valid=False))


@pytest.mark.parametrize("convert", [to_cadquery, to_build123d, to_open3d])
def test_a_package_that_is_not_there_is_named(monkeypatch, convert):
    name = convert.__name__.removeprefix("to_")
    monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(InputError, match=f"expected the package '{name}'"):
        convert(CLOUD if convert is to_open3d else BOX)
