"""Shapes as triangles: GLB, STL, OBJ, PLY."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from crispline.cadfile.units import MILLIMETRES
from crispline.errors import ReconstructionError
from crispline.exchange.mesh import write_mesh
from crispline.exchange.palette import kind_colour
from crispline.files import atomic_path
from crispline.occt.measure import Tessellation, tessellate
from crispline.surface.base import Array

_WELD = 1e-9
"""Vertices nearer than this share of the size of the model are one."""


def write_triangles(
    shape: Any, path: Path, unit: str, tolerance: float, kinds: Sequence[str]
) -> None:
    """Write the triangles of a shape whole or not at all; the suffix tells the format.

    PLY and OBJ are in double precision, STL in single by its definition; in the
    three, faces share the vertices of their common edges, so a closed solid
    gives a closed mesh. GLB has one mesh a kind of face in its colour, about the
    middle of the model; its scene is in metres with y up, as glTF demands.

    Parameters
    ----------
    shape : ``TopoDS_Shape``.
    unit : of the shape's numbers; only GLB has a use for it.
    tolerance : largest distance of the triangles from the faces, in the same unit.
    kinds : of the surface of every face.

    Raises
    ------
    ReconstructionError
        OCCT cannot triangulate a face.
    """
    mesh = tessellate(shape, tolerance)
    if len(np.unique(mesh.faces)) < len(kinds):
        raise ReconstructionError(
            f"cannot write '{path}': a face of the shape cannot be triangulated; write STEP"
        )
    if path.suffix.lower() == ".glb":
        content = _glb(mesh, kinds, MILLIMETRES[unit])
    else:
        vertices, triangles = welded(mesh)
        if path.suffix.lower() in (".ply", ".obj"):
            write_mesh(path, vertices, triangles)
            return
        from trimesh import Trimesh

        solid = Trimesh(vertices, triangles, process=False)
        content = cast(bytes, solid.export(file_type="stl"))
    with atomic_path(path) as draft:
        draft.write_bytes(content)


def welded(mesh: Tessellation) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and triangles with the vertices of neighbouring faces made one.

    Returns
    -------
    vertices : shape ``(n, 3)``.
    triangles : shape ``(m, 3)``; those that have become a line are left out.
    """
    points = mesh.vertices
    size = float(np.ptp(points, axis=0).max())
    pairs = cKDTree(points).query_pairs(_WELD * size, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), tuple(pairs.T)), shape=(len(points),) * 2)
    _, label = connected_components(links, directed=False)
    _, first = np.unique(label, return_index=True)
    triangles = label[mesh.triangles].astype(np.int64)
    is_proper = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
    return points[first], triangles[is_proper]


def _glb(mesh: Tessellation, kinds: Sequence[str], millimetres: float) -> bytes:
    from trimesh import Scene, Trimesh
    from trimesh.visual import TextureVisuals
    from trimesh.visual.material import PBRMaterial

    # Single precision has to do for the vertices, not for where the part lies.
    middle = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    metres = 1e-3 * millimetres
    to_world = np.eye(4)
    to_world[:3, :3] = metres * np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    to_world[:3, 3] = to_world[:3, :3] @ middle
    scene = Scene()
    kind_of_triangle = np.array(kinds)[mesh.faces]
    for kind in sorted(set(kinds)):
        corners, local = np.unique(mesh.triangles[kind_of_triangle == kind], return_inverse=True)
        colour = np.append(np.round(255.0 * np.array(kind_colour(kind))), 255).astype(np.uint8)
        material = PBRMaterial(
            name=kind, baseColorFactor=colour, metallicFactor=0.0, roughnessFactor=0.6
        )
        part = Trimesh(
            mesh.vertices[corners] - middle,
            local.reshape(-1, 3),
            process=False,
            visual=TextureVisuals(material=material),
        )
        scene.add_geometry(part, node_name=kind, geom_name=kind, transform=to_world)
    return cast(bytes, scene.export(file_type="glb", include_normals=True))
