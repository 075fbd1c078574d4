"""Surfaces, models, edges in and out, in the files and objects of other programs."""

from __future__ import annotations

from crispline.exchange.bridges import to_build123d, to_cadquery, to_open3d, to_trimesh
from crispline.exchange.edges import write_edges
from crispline.exchange.geomdl import from_geomdl, to_geomdl
from crispline.exchange.models import convert_model, write_model
from crispline.exchange.read import SurfaceFile, read_surface_file, read_surfaces
from crispline.exchange.scipy import from_scipy, to_scipy
from crispline.exchange.write import write_surfaces

__all__ = [
    "SurfaceFile",
    "convert_model",
    "from_geomdl",
    "from_scipy",
    "read_surface_file",
    "read_surfaces",
    "to_build123d",
    "to_cadquery",
    "to_geomdl",
    "to_open3d",
    "to_scipy",
    "to_trimesh",
    "write_edges",
    "write_model",
    "write_surfaces",
]
