"""Whether a shape is a sound solid that follows the cloud it was made from.

OCCT's own check passes solids with a face that spills far over its border, and
tolerances of any size. So every face is also measured against the cloud, the
cloud against the faces, and the tolerances against the spacing.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepCheck import (
    BRepCheck_Analyzer,
    BRepCheck_Face,
    BRepCheck_Shell,
    BRepCheck_Status,
    BRepCheck_Wire,
)
from OCP.collections import IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher
from OCP.TopExp import TopExp
from OCP.TopoDS import TopoDS_Edge

from crispline import occt
from crispline.cadfile.step import read_step
from crispline.gauge.deviation import measure_deviation
from crispline.occt.measure import Tessellation, tessellate, volume
from crispline.surface.base import Array

STRAY = 3.0
"""A face this far from the cloud, or a cloud this far from the model, is a failure, in spacings."""
MAX_TOLERANCE = 3.0
"""An edge or vertex with a larger tolerance hides a gap in the model, in spacings."""
UNMESHED = "it cannot be triangulated"
"""Reason of a face that OCCT finds no fault in but cannot fill."""
_DEFLECTIONS = (0.01, 0.002)
"""Distances between a face and its triangles that are tried, in spacings: faces with a crossed
border have been seen to mesh at 0.05 and vanish at 0.02, or to mesh at 0.01 and vanish at 0.005."""
_COARSE = 0.05
"""Tried in place of the second for faces that have more triangles at the first than ..."""
_MANY = 15_000
"""... this: OCCT takes a minute and a gigabyte to mesh a face of five times as many."""
_SAME_AREA = 0.05
"""A face whose area changes by more than this share from one mesh to the other is not filled."""


@dataclass(frozen=True)
class BadFace:
    """A face that fails and why.

    Attributes
    ----------
    index : the face, in exploration order, or as :class:`crispline.brep.compose.Solid` says.
    reason : for example ``'BRepCheck_SelfIntersectingWire'`` or ``'13.2 spacings from the cloud'``.
    """

    index: int
    reason: str


@dataclass(frozen=True)
class Check:
    """What was found; lengths in the unit of the shape.

    Attributes
    ----------
    is_valid : OCCT finds no fault in the shape.
    is_closed : every edge borders two faces, and there is at least one solid.
    n_solids, n_faces, n_edges, n_vertices : distinct subshapes; seams count as edges.
    volume : enclosed volume, 0 for an open shape.
    edge_tolerance, vertex_tolerance : the largest.
    face_distances : per face, the largest distance from the cloud, in spacings, shape
        ``(n_faces,)``; 0 where no cloud was given.
    n_uncovered : cloud points that lie together and farther than ``STRAY`` from the model.
    bad_faces : faces with a fault.
    problems : faults of the shape as a whole.
    may_be_open : whether it stands for a scan that is not closed, so that free edges are
        no fault.
    """

    is_valid: bool
    is_closed: bool
    n_solids: int
    n_faces: int
    n_edges: int
    n_vertices: int
    volume: float
    edge_tolerance: float
    vertex_tolerance: float
    face_distances: Array
    n_uncovered: int
    bad_faces: tuple[BadFace, ...]
    problems: tuple[str, ...]
    may_be_open: bool = False

    @property
    def is_good(self) -> bool:
        """A valid solid, or shell if it may be open, without a face or points that stray."""
        is_whole = self.is_closed or self.may_be_open
        return self.is_valid and is_whole and not self.bad_faces and not self.problems


def check_file(
    path: str | PathLike[str], raw_points: Array | None = None, spacing: float = 1.0
) -> Check:
    """Read a STEP file back and check what is in it; see :func:`check_shape`."""
    return check_shape(read_step(path), raw_points, spacing)


def check_shape(
    shape: Any,
    raw_points: Array | None = None,
    spacing: float = 1.0,
    may_be_open: bool = False,
) -> Check:
    """Check a shape by itself and against the cloud it was made from.

    Parameters
    ----------
    shape : any ``TopoDS_Shape``.
    raw_points : the cloud in the unit of the shape, without outliers, shape ``(n, 3)``;
        None to check the shape alone.
    spacing : mean distance between neighbouring points of the cloud.
    may_be_open : whether free edges are no fault.
    """
    faces = occt.subshapes(shape, occt.FACE)
    solids = occt.subshapes(shape, occt.SOLID)
    edge_tolerance = occt.largest_tolerance(shape, occt.EDGE)
    vertex_tolerance = occt.largest_tolerance(shape, occt.VERTEX)
    analyser = BRepCheck_Analyzer(shape)
    is_valid = bool(faces) and bool(analyser.IsValid())
    is_closed = bool(solids) and shared_edges_only(shape)
    enclosed = volume(shape) if is_closed else 0.0

    bad = [BadFace(i, reason) for i, face in enumerate(faces) for reason in _faults(analyser, face)]
    problems = list(_shell_faults(shape, may_be_open))
    if is_closed and enclosed <= 0.0:
        problems.append(f"the enclosed volume is {enclosed:.3g}, so the solid is inside out")
    for face_index, face in enumerate(faces):
        tolerance = max(occt.largest_tolerance(face, kind) for kind in (occt.EDGE, occt.VERTEX))
        if tolerance > MAX_TOLERANCE * spacing:
            reason = f"its border misses the surface by {tolerance / spacing:.1f} spacings"
            bad.append(BadFace(face_index, reason))

    distances, n_uncovered = np.zeros(len(faces)), 0
    # A fine mesh of a face with crossed borders takes minutes, and tells nothing new.
    first, second = _DEFLECTIONS
    meshes = [tessellate(shape, first * spacing)]
    if is_valid:
        is_heavy = np.bincount(meshes[0].faces, minlength=1).max() > _MANY
        meshes.append(tessellate(shape, (_COARSE if is_heavy else second) * spacing))
    vanishing = np.flatnonzero(_vanishes(meshes, len(faces)))
    bad += [BadFace(int(i), UNMESHED) for i in vanishing]
    mesh = meshes[0]
    if raw_points is not None and len(mesh.triangles):
        deviation = measure_deviation(mesh, len(faces), raw_points, spacing, STRAY)
        distances, n_uncovered = deviation.face_distances, int(deviation.n_uncovered.sum())
        bad += [
            BadFace(int(i), f"{distances[i]:.1f} spacings from the cloud")
            for i in np.flatnonzero(distances > STRAY)
        ]
        bad += [
            BadFace(int(i), f"{deviation.n_uncovered[i]} raw points beside it are uncovered")
            for i in np.flatnonzero(deviation.n_uncovered)
            if not len(vanishing)  # their points lie beside faces that are none the worse
        ]
    return Check(
        is_valid,
        is_closed,
        len(solids),
        len(faces),
        len(occt.subshapes(shape, occt.EDGE)),
        len(occt.subshapes(shape, occt.VERTEX)),
        enclosed,
        edge_tolerance,
        vertex_tolerance,
        distances,
        n_uncovered,
        tuple(sorted(bad, key=lambda fault: fault.index)),
        tuple(problems),
        may_be_open,
    )


def _vanishes(meshes: list[Tessellation], n_faces: int) -> NDArray[np.bool_]:
    """Faces that one of the meshes does not fill, or not as the others do, shape ``(n_faces,)``."""
    areas = np.stack([np.bincount(mesh.faces, mesh.areas(), n_faces) for mesh in meshes])
    return np.asarray(areas.min(axis=0) <= (1.0 - _SAME_AREA) * areas.max(axis=0))


def shared_edges_only(shape: Any) -> bool:
    """Whether every edge is used twice; a seam twice by one face, a pole by none but its own."""
    uses = IndexedDataMap_TopoDS_Shape_List_TopoDS_Shape_TopTools_ShapeMapHasher()
    TopExp.MapShapesAndAncestors_s(shape, occt.EDGE, occt.FACE, uses)
    return all(
        uses.FindFromIndex(i).Size() == 2 or BRep_Tool.Degenerated_s(occt.as_edge(uses.FindKey(i)))
        for i in range(1, uses.Size() + 1)
    )


def _faults(analyser: Any, face: Any) -> Iterator[str]:
    """Names of what OCCT finds wrong with a face."""
    if analyser.IsValid(face):
        return
    names = []
    for wire in occt.subshapes(face, occt.WIRE):
        checker = BRepCheck_Wire(wire)
        first, second = TopoDS_Edge(), TopoDS_Edge()
        names += [
            checker.SelfIntersect(face, first, second),
            checker.Closed(),
            checker.Closed2d(face),
            checker.Orientation(face),
        ]
    checker = BRepCheck_Face(face)
    names += [checker.IntersectWires(), checker.ClassifyWires(), checker.OrientationOfWires()]
    faults = [status.name for status in names if status != BRepCheck_Status.BRepCheck_NoError]
    if any(not analyser.IsValid(edge) for edge in occt.subshapes(face, occt.EDGE)):
        faults.append("BRepCheck_InvalidCurveOnSurface")
    yield from dict.fromkeys(faults or ["BRepCheck_CheckFail"])


def _shell_faults(shape: Any, may_be_open: bool) -> Iterator[str]:
    for shell in occt.subshapes(shape, occt.SHELL):
        checker = BRepCheck_Shell(shell)
        for status in (checker.Closed(), checker.Orientation()):
            is_free = may_be_open and status == BRepCheck_Status.BRepCheck_NotClosed
            if status != BRepCheck_Status.BRepCheck_NoError and not is_free:
                yield status.name
