"""A quilt of B-spline surfaces as an OCCT shape: the model where no segmentation suits.

Every border is an iso-parameter line of both its surfaces, over one parameter, so
edges and faces agree to rounding, and nothing is trimmed, healed or sewn.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Builder
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.TopAbs import TopAbs_Orientation, TopAbs_State
from OCP.TopoDS import (
    TopoDS_Compound,
    TopoDS_Edge,
    TopoDS_Face,
    TopoDS_Shell,
    TopoDS_Solid,
    TopoDS_Vertex,
    TopoDS_Wire,
)
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from crispline import occt
from crispline.cadfile.step import read_step, step_bytes
from crispline.errors import ReconstructionError
from crispline.files import atomic_path
from crispline.spline.creased import CreasedNet
from crispline.spline.quilt import EdgeSide, Quilt, quilt
from crispline.surface import Similarity
from crispline.surface.base import Array

_FORWARD = TopAbs_Orientation.TopAbs_FORWARD
_REVERSED = TopAbs_Orientation.TopAbs_REVERSED


@dataclass(frozen=True)
class Patchwork:
    """A shape and the surfaces it was made from, in the unit of the net.

    Attributes
    ----------
    shape : ``TopoDS_Shape``: a solid where the net is closed, a shell where it is
        open, a compound where it has several pieces.
    quilt : its surfaces; see :func:`crispline.spline.joins.measure_joins`.
    place : of each surface's face in the order of exploration, shape ``(n_faces,)``.
    is_turned : whether that face has the outer side where its surface has the inner one.
    """

    shape: Any
    quilt: Quilt
    place: NDArray[np.int64]
    is_turned: NDArray[np.bool_]


def build_patchwork(net: CreasedNet, depth: int = 1) -> Patchwork:
    """The surface of a net as a shape of few B-spline faces that share their edges.

    Parameters
    ----------
    net : counter-clockwise quads seen from outside. A closed piece that is turned
        inside out is a void if it lies in another one, else it is turned.
    depth : see :func:`crispline.spline.quilt.quilt`.

    Raises
    ------
    InputError
        If the net is no oriented surface.
    """
    covered = quilt(net, depth)
    # OCCT's tolerances are absolute: the shape is built where a side of the net is about 1.
    to_user = Similarity(_side_length(net), np.eye(3), covered.vertices.mean(axis=0))
    to_sides = to_user.inverse()
    faces = _faces(covered, to_sides)
    shape = _assembled(covered, faces, net, to_sides)
    # The bindings compare shapes by their wrappers; the hash tells which are the same.
    known = {hash(face): index for index, face in enumerate(faces)}
    found = occt.subshapes(shape, occt.FACE)
    order = np.array([known[hash(face)] for face in found], dtype=np.int64)
    is_turned = np.array([face.Orientation() == _REVERSED for face in found])
    place = np.argsort(order)
    return Patchwork(occt.transform(shape, to_user), covered, place, is_turned[place])


def write_patchwork(patchwork: Patchwork, path: str | PathLike[str]) -> None:
    """Write a patchwork as a STEP file that has been read back and found the same.

    Raises
    ------
    ReconstructionError
        If OCCT reads another shape from the file, or finds a fault in it.
    InputError
        If the file cannot be written.
    """
    content = step_bytes(patchwork.shape, has_pcurves=False)
    with atomic_path(Path(path)) as draft:
        draft.write_bytes(content)
        copy = read_step(draft)
        if not BRepCheck_Analyzer(copy).IsValid() or _counts(copy) != _counts(patchwork.shape):
            raise ReconstructionError(
                "the patches are joined in memory, but the STEP file of them does not read back "
                "as the same shape; quads that fold over are the usual cause: smooth the net"
            )


def _counts(shape: Any) -> tuple[int, ...]:
    kinds = (occt.SOLID, occt.SHELL, occt.FACE, occt.EDGE, occt.VERTEX)
    return tuple(len(occt.subshapes(shape, kind)) for kind in kinds)


def _side_length(net: CreasedNet) -> float:
    sides = net.vertices[net.quads] - net.vertices[np.roll(net.quads, -1, axis=1)]
    length = float(np.median(np.linalg.norm(sides, axis=2)))
    return length if length > 0.0 else 1.0


def _faces(quilt: Quilt, similarity: Similarity) -> list[Any]:
    builder = BRep_Builder()
    vertices = []
    for position in similarity.points(quilt.vertices):
        vertex = TopoDS_Vertex()
        builder.MakeVertex(vertex, occt.point(position), occt.CONFUSION)
        vertices.append(vertex)
    borders: list[list[tuple[float, Any]]] = [[] for _ in quilt.faces]
    faces = []
    for surface in quilt.faces:
        face = TopoDS_Face()
        geometry = occt.bspline_surface(surface.transformed(similarity))
        builder.MakeFace(face, geometry, occt.CONFUSION)
        faces.append(face)
    for item in quilt.edges:
        edge = TopoDS_Edge()
        curve = item.curve.transformed(similarity)
        builder.MakeEdge(edge, occt.curve_to_occt(curve), occt.CONFUSION)
        builder.Add(edge, vertices[item.start].Oriented(_FORWARD))
        builder.Add(edge, vertices[item.end].Oriented(_REVERSED))
        builder.Range(edge, curve.start, curve.end)
        for side, orientation in ((item.left, _FORWARD), (item.right, _REVERSED)):
            if side is not None:
                builder.UpdateEdge(edge, _line(side), faces[side.face], occt.CONFUSION)
                borders[side.face].append((side.place, edge.Oriented(orientation)))
    for face, border in zip(faces, borders, strict=True):
        wire = TopoDS_Wire()
        builder.MakeWire(wire)
        for _, edge in sorted(border, key=lambda use: use[0]):
            builder.Add(wire, edge)
        wire.Closed(True)
        builder.Add(face, wire)
    return faces


def _line(side: EdgeSide) -> Any:
    start, end = np.array(side.start, dtype=float), np.array(side.end, dtype=float)
    return occt.line_2d(start, (end - start) / np.abs(end - start).max())


def _assembled(quilt: Quilt, faces: list[Any], net: CreasedNet, similarity: Similarity) -> Any:
    """A solid for every closed piece with its voids, a shell for every open one."""
    pairs = np.array(
        [(edge.left.face, edge.right.face) for edge in quilt.edges if edge.right is not None],
        dtype=np.int64,
    ).reshape(-1, 2)
    links = coo_array((np.ones(len(pairs)), pairs.T), shape=(len(faces), len(faces)))
    n_pieces, piece = connected_components(links, directed=False)
    is_closed = np.ones(n_pieces, dtype=bool)
    is_closed[[piece[edge.left.face] for edge in quilt.edges if edge.right is None]] = False

    volumes = np.bincount(piece[quilt.face_of_quad], _cone_volumes(net), minlength=n_pieces)
    parts: list[Any] = []
    solids: list[tuple[float, Any]] = []
    inverted: list[tuple[Any, Array]] = []
    for index in range(n_pieces):
        members = np.flatnonzero(piece == index)
        shell = _shell([faces[i] for i in members])
        if not is_closed[index]:
            parts.append(shell)
            continue
        shell.Closed(True)
        if volumes[index] < 0.0:
            corner = quilt.faces[members[0]].control_points[:1, 0]
            inverted.append((shell, similarity.points(corner)[0]))
        else:
            solids.append((volumes[index], _solid(shell)))
    for shell, probe in inverted:
        around = [(size, solid) for size, solid in solids if _is_inside(solid, probe)]
        if around:
            BRep_Builder().Add(min(around, key=lambda pair: pair[0])[1], shell)
        else:
            parts.append(_solid(shell.Reversed()))
    parts = [solid for _, solid in solids] + parts
    if len(parts) == 1:
        return parts[0]
    compound = TopoDS_Compound()
    BRep_Builder().MakeCompound(compound)
    for part in parts:
        BRep_Builder().Add(compound, part)
    return compound


def _cone_volumes(net: CreasedNet) -> Array:
    """Volume between each quad and one point; over a closed piece of net they add up to its own."""
    a, b, c, d = (net.vertices[net.quads[:, i]] - net.vertices[net.quads[0, 0]] for i in range(4))
    return np.asarray(np.einsum("ij,ij->i", a, np.cross(b - d, c)) / 6.0)


def _shell(faces: list[Any]) -> Any:
    shell = TopoDS_Shell()
    BRep_Builder().MakeShell(shell)
    for face in faces:
        BRep_Builder().Add(shell, face)
    return shell


def _solid(shell: Any) -> Any:
    solid = TopoDS_Solid()
    BRep_Builder().MakeSolid(solid)
    BRep_Builder().Add(solid, shell)
    return solid


def _is_inside(solid: Any, position: Array) -> bool:
    classifier = BRepClass3d_SolidClassifier(solid, occt.point(position), occt.CONFUSION)
    return bool(classifier.State() == TopAbs_State.TopAbs_IN)
