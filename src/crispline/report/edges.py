"""Sharp edges and corners as JSON or OBJ."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from crispline.files import check_output, write_text
from crispline.surface.base import Array

EDGE_SUFFIXES = (".json", ".obj")


class SharpEdge(Protocol):
    """What is written of an edge: a polyline ``(k, 3)`` and the angle of its faces."""

    @property
    def points(self) -> Array:
        """Points along the edge; a closed one ends where it starts."""

    @property
    def angle_deg(self) -> float:
        """Angle between the normals of the two faces."""


def write_edges(
    path: Path, edges: Sequence[SharpEdge], corners: Array, *, spacing: float, noise: float
) -> None:
    """Write sharp edges and corners whole or not at all; the suffix tells the format.

    JSON holds ``spacing``, ``noise``, ``edges`` (``points``, ``closed``,
    ``angle_deg``) and ``corners``. OBJ holds one ``l`` record an edge and one
    ``p`` record a corner; edges that meet share their vertex.

    Raises
    ------
    InputError
        Unknown suffix, or the file cannot be written.
    """
    check_output(path, EDGE_SUFFIXES)
    if path.suffix.lower() == ".obj":
        write_text(path, _obj(edges, corners))
        return
    content = {
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
    write_text(path, json.dumps(content, allow_nan=False) + "\n")


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
