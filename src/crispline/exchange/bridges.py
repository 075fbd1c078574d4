"""Clouds and models as objects of other Python packages, none of which is imported before.

The other way, `PointCloud.from_any` takes points of Open3D, trimesh and PyVista, and
`crispline.exchange.write_model` takes shapes of CadQuery and build123d.
"""

from __future__ import annotations

from typing import Any

from crispline.cloud.pointcloud import PointCloud
from crispline.errors import ReconstructionError
from crispline.extras import required


def to_open3d(cloud: PointCloud) -> Any:
    """``open3d.geometry.PointCloud`` with the same points and normals."""
    open3d = required("open3d")
    result = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(cloud.points))
    if cloud.normals is not None:
        result.normals = open3d.utility.Vector3dVector(cloud.normals)
    return result


def to_trimesh(cloud: PointCloud) -> Any:
    """``trimesh.PointCloud`` with the same points; it has no place for normals.

    A model becomes a ``trimesh.Trimesh`` with `Reconstruction.to_mesh`.
    """
    return required("trimesh").PointCloud(cloud.points)


def to_cadquery(model: Any) -> Any:
    """The model as a shape of CadQuery (``Solid``, ``Shell`` or ``Compound``).

    Parameters
    ----------
    model : a `Reconstruction` or a ``TopoDS_Shape``.

    Raises
    ------
    InputError
        CadQuery is not installed, or not for the same version of OCP.
    ReconstructionError
        There is no valid model.
    """
    return required("cadquery").Shape.cast(_shape(model))


def to_build123d(model: Any) -> Any:
    """The model as a shape of build123d (``Solid``, ``Shell`` or ``Compound``).

    See `to_cadquery` for parameters and errors.
    """
    return required("build123d").Shape.cast(_shape(model))


def _shape(model: Any) -> Any:
    if not hasattr(model, "solid"):
        return model
    if not model.valid:
        raise ReconstructionError("there is no valid model to convert", model)
    return model.solid.shape
