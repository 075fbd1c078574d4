"""The edges of a shape as fine polylines, and on which side of them its faces lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.GCPnts import GCPnts_TangentialDeflection
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopExp import TopExp_Explorer

from crispline import occt
from crispline.surface.base import Array

Index = NDArray[np.int64]

_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
_REVERSED = TopAbs_Orientation.TopAbs_REVERSED
_ANGLE = 0.5  # radians between neighbouring segments; the deflection asks for less nearly always


@dataclass(frozen=True)
class Borders:
    """Short segments along every edge, once for every face that the edge bounds.

    Seams and degenerate edges bound nothing and are left out.

    Attributes
    ----------
    start, end : shape ``(k, 3)``; the face lies to the left, seen from outside.
    face : index into the faces, shape ``(k,)``.
    """

    start: Array
    end: Array
    face: Index


def borders(faces: list[Any], deflection: float, length: float) -> Borders:
    """Polylines along the edges of faces.

    Parameters
    ----------
    faces : any ``TopoDS_Face``.
    deflection : largest distance between an edge and its polyline (length unit).
    length : longest segment.
    """
    lines: dict[int, Array] = {}
    starts, ends, owners = [np.empty((0, 3))], [np.empty((0, 3))], [np.empty(0, np.int64)]
    for index, face in enumerate(faces):
        explorer = TopExp_Explorer(face, occt.EDGE)
        while explorer.More():
            edge = occt.as_edge(explorer.Current())
            explorer.Next()
            way = edge.Orientation()
            if way not in (_FORWARD, _REVERSED) or BRep_Tool.Degenerated_s(edge):
                continue
            if BRep_Tool.IsClosed_s(edge, face):
                continue
            # The bindings compare shapes by their wrappers; the hash tells which are the same.
            if hash(edge) not in lines:
                lines[hash(edge)] = _polyline(edge, deflection, length)
            line = lines[hash(edge)][:: 1 if way == _FORWARD else -1]
            starts.append(line[:-1])
            ends.append(line[1:])
            owners.append(np.full(len(line) - 1, index))
    return Borders(np.concatenate(starts), np.concatenate(ends), np.concatenate(owners))


def _polyline(edge: Any, deflection: float, length: float) -> Array:
    """Points along the curve of an edge, shape ``(k + 1, 3)``, ``k`` at least 1."""
    finder = GCPnts_TangentialDeflection(BRepAdaptor_Curve(edge), _ANGLE, deflection)
    places = [finder.Value(i) for i in range(1, finder.NbPoints() + 1)]
    points = np.array([(place.X(), place.Y(), place.Z()) for place in places]).reshape(-1, 3)
    legs = np.diff(points, axis=0)
    pieces = np.maximum(1, np.ceil(np.linalg.norm(legs, axis=1) / length)).astype(np.int64)
    leg = np.repeat(np.arange(len(legs)), pieces)
    share = (np.arange(len(leg)) - (np.cumsum(pieces) - pieces)[leg]) / pieces[leg]
    return np.concatenate([points[leg] + share[:, None] * legs[leg], points[-1:]])
