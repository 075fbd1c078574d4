"""Curves and points as DXF."""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from crispline.curve import BSplineCurve, Circle, Curve, Line
from crispline.extras import optional
from crispline.files import write_text
from crispline.surface.base import Array

_UNITS: Mapping[str, int] = {
    "in": 1,
    "ft": 2,
    "mm": 4,
    "cm": 5,
    "m": 6,
    "km": 7,
    "mil": 9,
    "um": 13,
}
"""Codes of ``$INSUNITS`` (DXF reference, header section)."""


def write_dxf(path: Path, curves: Sequence[Curve], corners: Array, unit: str = "mm") -> None:
    """Write curves and points as DXF (R2010) whole or not at all; the same bytes for the same.

    Parameters
    ----------
    curves : become ``LINE``, ``ARC`` or ``CIRCLE``, and ``SPLINE`` on the layer ``EDGES``.
    corners : become ``POINT`` on the layer ``CORNERS``, shape ``(c, 3)``.
    unit : one of `crispline.cadfile.units.MILLIMETRES`; it goes into the header.

    Raises
    ------
    InputError
        ezdxf is not installed, or the file cannot be written.
    """
    ezdxf = optional("ezdxf", "dxf", "DXF files")
    with _same_bytes(ezdxf):
        document = ezdxf.new("R2010", units=_UNITS[unit])
        document.layers.add("EDGES", color=7)
        document.layers.add("CORNERS", color=1)
        space = document.modelspace()
        for curve in curves:
            _add(space, curve, {"layer": "EDGES"})
        for corner in corners.tolist():
            space.add_point(corner, dxfattribs={"layer": "CORNERS"})
        stream = io.StringIO()
        document.write(stream)
    write_text(path, stream.getvalue())


@contextmanager
def _same_bytes(ezdxf: Any) -> Iterator[None]:
    """Keep the time and random identifiers out of the file."""
    options = ezdxf.options
    before = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True
    try:
        yield
    finally:
        options.write_fixed_meta_data_for_testing = before


def _add(space: Any, curve: Curve, attributes: dict[str, str]) -> None:
    match curve:
        case Line():
            start, end = curve.samples(2).tolist()
            space.add_line(start, end, dxfattribs=attributes)
        case Circle():
            _add_arc(space, curve, attributes)
        case BSplineCurve():
            spline = space.add_spline(degree=3, dxfattribs=attributes)
            spline.control_points = curve.control_points.tolist()
            spline.knots = curve.knots.tolist()
        case _:
            raise TypeError(f"no DXF entity for {type(curve).__name__}")


def _add_arc(space: Any, circle: Circle, attributes: dict[str, str]) -> None:
    """A circle or arc lies in a plane whose x axis follows from its normal alone."""
    x_axis, y_axis = _object_axes(circle.normal)
    frame = np.array([x_axis, y_axis, circle.normal])
    centre = (frame @ circle.centre).tolist()
    placed = {**attributes, "extrusion": circle.normal.tolist()}
    if circle.end - circle.start >= 2.0 * np.pi * (1.0 - 1e-12):
        space.add_circle(centre, circle.radius, dxfattribs=placed)
        return
    turn = math.atan2(float(y_axis @ circle.x_axis), float(x_axis @ circle.x_axis))
    start, end = np.degrees([circle.start + turn, circle.end + turn]).tolist()
    space.add_arc(centre, circle.radius, start, end, dxfattribs=placed)


def _object_axes(normal: Array) -> tuple[Array, Array]:
    """Axes of the plane of an entity with this unit normal.

    References
    ----------
    DXF reference, "Arbitrary Axis Algorithm".
    """
    is_near_z = abs(normal[0]) < 1.0 / 64.0 and abs(normal[1]) < 1.0 / 64.0
    helper = np.array([0.0, 1.0, 0.0]) if is_near_z else np.array([0.0, 0.0, 1.0])
    x_axis = np.cross(helper, normal)
    x_axis /= np.linalg.norm(x_axis)
    return x_axis, np.cross(normal, x_axis)
