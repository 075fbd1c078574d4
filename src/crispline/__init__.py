"""Noisy point clouds to CAD solids with sharp edges and corners.

>>> import crispline
>>> crispline.Options(seed=1).seed
1
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from crispline.cloud.pointcloud import PointCloud
    from crispline.cloud.read import read_points
    from crispline.errors import CrisplineError, InputError, ReconstructionError
    from crispline.options import Options
    from crispline.pipeline import detect, reconstruct
    from crispline.result import Reconstruction

__version__ = "0.1.0"

# Loaded on first use, so that `import crispline` and `crispline --help` stay instant.
_HOME = {
    "CrisplineError": "crispline.errors",
    "InputError": "crispline.errors",
    "Options": "crispline.options",
    "PointCloud": "crispline.cloud.pointcloud",
    "Reconstruction": "crispline.result",
    "ReconstructionError": "crispline.errors",
    "detect": "crispline.pipeline",
    "read_points": "crispline.cloud.read",
    "reconstruct": "crispline.pipeline",
}

__all__ = [
    "CrisplineError",
    "InputError",
    "Options",
    "PointCloud",
    "Reconstruction",
    "ReconstructionError",
    "detect",
    "read_points",
    "reconstruct",
]


def __getattr__(name: str) -> object:
    if name not in _HOME:
        raise AttributeError(f"module 'crispline' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
