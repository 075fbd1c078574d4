"""Simulated scans of a shape: uniform by area, Gaussian noise."""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.BRepTools import BRepTools
from OCP.TopLoc import TopLoc_Location

from crispline import occt
from crispline.occt.measure import face_areas
from crispline.surface.base import Array
from parts.features import FaceNormals, shape_features
from parts.truth import Truth

_DEFLECTION = 1e-4
"""Distance of the triangles from the shape, over the square root of its area."""


def scan(shape: Any, n_points: int, noise: float = 0.0, seed: int = 0) -> tuple[Truth, float]:
    """Scan a shape.

    Parameters
    ----------
    shape : any ``TopoDS_Shape`` with faces.
    n_points : how many points; uniform by area, on the exact surface.
    noise : standard deviation of each coordinate, over the diagonal of the bounding box.
    seed : of the generator; positions and noise draw from streams of their own, so a
        noisier scan has the same clean points.

    Returns
    -------
    The truth, and the area of the shape.
    """
    place_stream, noise_stream = np.random.default_rng(seed).spawn(2)
    faces = occt.subshapes(shape, occt.FACE)
    parameters, corners, owners = _triangles(shape, faces)
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    chosen = np.sort(place_stream.choice(len(areas), n_points, p=areas / areas.sum()))
    a, b = place_stream.random((2, n_points))
    weights = np.column_stack([1.0 - np.sqrt(a), np.sqrt(a) * (1.0 - b), np.sqrt(a) * b])
    places = np.einsum("nk,nkd->nd", weights, parameters[chosen])
    face_ids = owners[chosen]  # triangles come face by face, and so do the points
    evaluated = [FaceNormals(face).at(places[face_ids == i]) for i, face in enumerate(faces)]
    clean = np.concatenate([points for points, _ in evaluated])
    normals = np.concatenate([normals for _, normals in evaluated])

    diagonal = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    features = shape_features(shape, diagonal)
    truth = Truth(
        points=clean + noise_stream.normal(scale=noise * diagonal, size=clean.shape),
        clean=clean,
        normals=normals,
        face_ids=face_ids,
        features=features,
        n_faces=len(faces),
        spacing=float(np.sqrt(areas.sum() / n_points)),
        diagonal=diagonal,
        noise=noise,
        is_open="boundary" in features.kinds,
    )
    return truth, float(areas.sum())


def _triangles(shape: Any, faces: list[Any]) -> tuple[Array, Array, Any]:
    """Fine triangles: surface parameters ``(m, 3, 2)`` and places ``(m, 3, 3)`` of their
    corners, and the face of each ``(m,)``.
    """
    BRepTools.Clean_s(shape)
    size = float(np.sqrt(face_areas(shape).sum()))
    BRepMesh_IncrementalMesh(shape, _DEFLECTION * size, False, 0.15, False)
    parameters, corners, owners = [], [], []
    for index, face in enumerate(faces):
        location = TopLoc_Location()
        mesh = BRep_Tool.Triangulation_s(face, location)
        if mesh is None:
            raise RuntimeError(f"face {index} of the part cannot be triangulated")
        move = location.Transformation()
        count = range(1, mesh.NbNodes() + 1)
        uv = np.array([(q.X(), q.Y()) for q in (mesh.UVNode(i) for i in count)])
        nodes = (mesh.Node(i).Transformed(move) for i in count)
        xyz = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
        cells = (mesh.Triangle(i) for i in range(1, mesh.NbTriangles() + 1))
        rows = np.array([[cell.Value(j) for j in (1, 2, 3)] for cell in cells]) - 1
        parameters.append(uv[rows])
        corners.append(xyz[rows])
        owners.append(np.full(len(rows), index))
    return np.concatenate(parameters), np.concatenate(corners), np.concatenate(owners)
