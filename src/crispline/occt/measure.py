"""Areas, volume and triangles of a shape."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepGProp import BRepGProp
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.GeomAbs import GeomAbs_SurfaceType
from OCP.GProp import GProp_GProps
from OCP.TopAbs import TopAbs_Orientation
from OCP.TopLoc import TopLoc_Location

from crispline import occt
from crispline.surface.base import Array

_AREA_ERROR = 1e-6
"""Relative, as OCCT estimates it; each further digit doubles the time on B-spline faces."""

# One Gauss rule a span is exact there, and the adaptive rules of OCCT 8 raise an index error, or
# never end, on some valid ones, so that good solids were lost.
_ELEMENTARY = (
    GeomAbs_SurfaceType.GeomAbs_Plane,
    GeomAbs_SurfaceType.GeomAbs_Cylinder,
    GeomAbs_SurfaceType.GeomAbs_Cone,
    GeomAbs_SurfaceType.GeomAbs_Sphere,
    GeomAbs_SurfaceType.GeomAbs_Torus,
)


@dataclass(frozen=True)
class Tessellation:
    """Triangles of a shape, anticlockwise seen from outside.

    Attributes
    ----------
    vertices : shape ``(n, 3)``; faces do not share vertices.
    triangles : indices into ``vertices``, shape ``(m, 3)``.
    faces : index of each triangle's face in exploration order, shape ``(m,)``.
    """

    vertices: Array
    triangles: NDArray[np.int64]
    faces: NDArray[np.int64]

    def areas(self) -> Array:
        """Area of each triangle, shape ``(m,)``."""
        a, b, c = (self.vertices[self.triangles[:, i]] for i in range(3))
        return 0.5 * np.asarray(np.linalg.norm(np.cross(b - a, c - a), axis=1))

    def cones(self, apex: Array, n_faces: int) -> Array:
        """Volume between a point and each face, negative where that looks to it, ``(n_faces,)``."""
        a, b, c = (self.vertices[self.triangles[:, i]] - apex for i in range(3))
        each = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
        return np.asarray(np.bincount(self.faces, each, minlength=n_faces), dtype=np.float64)

    def volume(self) -> float:
        """Enclosed volume; of an open surface, that of the cone from the mean of its vertices."""
        return float(self.cones(self.vertices.mean(axis=0), 1).sum()) if len(self.faces) else 0.0


def tessellate(shape: object, deflection: float, angle: float = 0.3) -> Tessellation:
    """Triangulate every face of a shape.

    Parameters
    ----------
    shape : any ``TopoDS_Shape``. Its stored triangulation, if any, is replaced.
    deflection : largest distance between a face and its triangles (length unit).
    angle : largest angle between neighbouring triangles on a bend, radians.

    Returns
    -------
    Tessellation
        A face that OCCT cannot triangulate has no triangles.
    """
    BRepTools.Clean_s(shape)
    BRepMesh_IncrementalMesh(shape, max(deflection, occt.CONFUSION), False, angle, False)
    vertices: list[Array] = []
    triangles: list[NDArray[np.int64]] = []
    faces: list[NDArray[np.int64]] = []
    n_vertices = 0
    for index, face in enumerate(occt.subshapes(shape, occt.FACE)):
        mesh = BRep_Tool.Triangulation_s(face, TopLoc_Location())
        if mesh is None:
            continue
        nodes = (mesh.Node(i) for i in range(1, mesh.NbNodes() + 1))
        corners = np.array([(node.X(), node.Y(), node.Z()) for node in nodes])
        cells = (mesh.Triangle(i) for i in range(1, mesh.NbTriangles() + 1))
        local = np.array([[cell.Value(j) for j in (1, 2, 3)] for cell in cells], dtype=np.int64)
        if face.Orientation() == TopAbs_Orientation.TopAbs_REVERSED:
            local = local[:, ::-1]
        vertices.append(corners)
        triangles.append(local - 1 + n_vertices)
        faces.append(np.full(len(local), index, dtype=np.int64))
        n_vertices += len(corners)
    if not triangles:
        return Tessellation(np.empty((0, 3)), np.empty((0, 3), np.int64), np.empty(0, np.int64))
    return Tessellation(np.vstack(vertices), np.vstack(triangles), np.concatenate(faces))


def face_areas(shape: object) -> Array:
    """Area of each face in exploration order, shape ``(n_faces,)``."""
    return np.array([_area(face) for face in occt.subshapes(shape, occt.FACE)])


def volume(shape: object, error: float = 1e-9) -> float:
    """Enclosed volume; negative if the faces look inwards, meaningless for an open shell.

    Parameters
    ----------
    shape : any ``TopoDS_Shape``.
    error : relative, that integrals stop at where there are spline faces; thousands of bicubic
        ones take half a minute for nine digits.
    """
    if not all(_is_elementary(face) for face in occt.subshapes(shape, occt.FACE)):
        try:
            properties = GProp_GProps()
            BRepGProp.VolumeProperties_s(shape, properties, error)
            return float(properties.Mass())
        except occt.FAILURES:
            pass  # the rule below is good to four digits on splines
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())


def diagonal(shape: object) -> float:
    """Length of the diagonal of a box round a shape, not the tightest; 0 without geometry."""
    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    return 0.0 if box.IsVoid() else float(np.sqrt(box.SquareExtent()))


def _area(face: object) -> float:
    properties = GProp_GProps()
    if _is_elementary(face):
        BRepGProp.SurfaceProperties_s(face, properties)
    else:
        BRepGProp.SurfaceProperties_s(face, properties, _AREA_ERROR)
    return float(properties.Mass())


def _is_elementary(face: object) -> bool:
    return BRepAdaptor_Surface(face).GetType() in _ELEMENTARY
