"""B-spline surfaces and organised points in and out, in the files and objects of other programs."""

from __future__ import annotations

from crispline.exchange.geomdl import from_geomdl, to_geomdl
from crispline.exchange.read import SurfaceFile, read_surface_file, read_surfaces
from crispline.exchange.scipy import from_scipy, to_scipy
from crispline.exchange.write import write_surfaces

__all__ = [
    "SurfaceFile",
    "from_geomdl",
    "from_scipy",
    "read_surface_file",
    "read_surfaces",
    "to_geomdl",
    "to_scipy",
    "write_surfaces",
]
