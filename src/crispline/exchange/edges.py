"""Sharp edges and corners to files: JSON, OBJ, DXF, STEP; the suffix tells the format."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from crispline.cadfile.units import checked_unit
from crispline.curve import Curve
from crispline.exchange.dxf import write_dxf
from crispline.files import check_output, write_text
from crispline.surface.base import Array

EDGE_SUFFIXES = (".dxf", ".json", ".obj", ".step", ".stp")


class SharpEdge(Protocol):
    """What is written of an edge: its curve, a polyline ``(k, 3)``, the angle of its faces."""

    @property
    def curve(self) -> Curve:
        """The exact geometry."""

    @property
    def points(self) -> Array:
        """Points along the edge; a closed one ends where it starts."""

    @property
    def angle_deg(self) -> float:
        """Angle between the normals of the two faces."""


def write_edges(
    path: Path,
    edges: Sequence[SharpEdge],
    corners: Array,
    *,
    spacing: float,
    noise: float,
    unit: str = "mm",
) -> None:
    """Write sharp edges and corners whole or not at all; the suffix tells the format.

    JSON holds ``unit``, ``spacing``, ``noise``, ``edges`` (``points``, ``closed``,
    ``angle_deg``) and ``corners``. OBJ holds one ``l`` record an edge and one
    ``p`` record a corner; edges that meet share their vertex. DXF (extra
    ``dxf``) and STEP hold lines, arcs and splines as they are; DXF has the
    layers ``EDGES`` and ``CORNERS``, STEP one curve an edge and no corners.

    Parameters
    ----------
    unit : of the numbers, which JSON, DXF and STEP name; see
        `crispline.cadfile.units.MILLIMETRES`.

    Raises
    ------
    InputError
        Unknown suffix or unit, an extra that is missing, no edge for STEP, or the
        file cannot be written.
    """
    check_output(path, EDGE_SUFFIXES)
    checked_unit(unit)
    match path.suffix.lower():
        case ".obj":
            write_text(path, _obj(edges, corners))
        case ".dxf":
            write_dxf(path, [edge.curve for edge in edges], corners, unit)
        case ".json":
            write_text(path, _json(edges, corners, spacing, noise, unit))
        case _:
            from crispline.cadfile.curve_files import write_curves

            write_curves([edge.curve for edge in edges], path, unit)


def _json(
    edges: Sequence[SharpEdge], corners: Array, spacing: float, noise: float, unit: str
) -> str:
    content = {
        "unit": unit,
        "spacing": spacing,
        "noise": noise,
        "edges": [
            {
                "points": edge.points.tolist(),
                "closed": _is_closed(edge.points),
                "angle_deg": edge.angle_deg,
            }
            for edge in edges
        ],
        "corners": corners.tolist(),
    }
    return json.dumps(content, allow_nan=False) + "\n"


def _is_closed(points: Array) -> bool:
    return len(points) > 2 and bool(np.array_equal(points[0], points[-1]))


def _obj(edges: Sequence[SharpEdge], corners: Array) -> str:
    numbers: dict[tuple[float, ...], int] = {}

    def number(point: list[float]) -> int:
        return numbers.setdefault(tuple(point), len(numbers) + 1)

    records = [
        f"l {' '.join(str(number(point)) for point in edge.points.tolist())}" for edge in edges
    ]
    records += [f"p {number(point)}" for point in corners.tolist()]
    vertices = [f"v {x!r} {y!r} {z!r}" for x, y, z in numbers]
    return "\n".join([*vertices, *records, ""])
