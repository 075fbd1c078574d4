"""Take back from a moved mesh what the move has folded or torn."""

from __future__ import annotations

import numpy as np

from crispline.net.mesh import TriangleMesh
from crispline.surface.base import Array, unit

_LONGEST = 1.5  # times the longest side before the move: torn between two sheets
_RINGS = 2  # of vertices that go back as well, so that nothing tears beside them
_ROUNDS = 4


def restrained(mesh: TriangleMesh, moved: Array) -> TriangleMesh:
    """The mesh with its vertices moved, but not where triangles would turn over or tear.

    A projection pulls every vertex to the sheet of points nearest to it. Where a wall is
    thinner than the mesh can tell, it pulls neighbours to different ones, and the mesh crosses
    itself there. A level set does not, so there it stays as it was.

    Parameters
    ----------
    mesh : before the move; its triangles are about equally large.
    moved : the vertices after it, shape ``(n, 3)``.
    """
    longest = _LONGEST * float(_sides(mesh).max(initial=0.0))
    facing, links = _facing(mesh), mesh.links()
    found, goes_back = TriangleMesh(moved, mesh.triangles), np.zeros(len(moved), dtype=bool)
    for _ in range(_ROUNDS):
        is_bad = np.einsum("ij,ij->i", _facing(found), facing) < 0.0
        is_bad |= _sides(found) > longest
        is_bad &= ~goes_back[mesh.triangles].all(axis=1)
        if not is_bad.any():
            break
        more = np.zeros(len(moved))
        more[mesh.triangles[is_bad]] = 1.0
        for _ in range(_RINGS):
            more += links @ more
        goes_back |= more > 0.0
        kept = np.where(goes_back[:, None], mesh.vertices, moved)
        found = TriangleMesh(kept, mesh.triangles)
    return found


def _sides(mesh: TriangleMesh) -> Array:
    """The longest side of every triangle, shape ``(m,)``."""
    corner = mesh.vertices[mesh.triangles]
    sides = np.linalg.norm(corner - np.roll(corner, -1, axis=1), axis=2)
    return np.asarray(sides.max(axis=1))


def _facing(mesh: TriangleMesh) -> Array:
    """Unit normals of the triangles, shape ``(m, 3)``."""
    a, b, c = (mesh.vertices[mesh.triangles[:, i]] for i in range(3))
    return unit(np.cross(b - a, c - a))
