"""Border loops of open meshes, and filling those that no scan left open on purpose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.net.mesh import TriangleMesh, compact
from crispline.surface.base import Array

Index = NDArray[np.int64]


def border_loops(polygons: Index) -> tuple[Index, ...]:
    """Closed loops of the sides that one polygon alone uses, in its direction.

    Parameters
    ----------
    polygons : vertex indices of a consistently oriented mesh, shape ``(m, k)``.

    Returns
    -------
    Vertices of each loop, the first not repeated. Sides about a vertex at which two
    loops touch belong to no loop, see :func:`without_pinches`.
    """
    tail, head = polygons.ravel(), np.roll(polygons, -1, axis=1).ravel()
    n = int(polygons.max(initial=0)) + 1
    is_border = ~np.isin(tail * n + head, head * n + tail)
    tail, head = tail[is_border], head[is_border]
    unique, uses = np.unique(tail, return_counts=True)
    simple = np.isin(tail, unique[uses == 1])
    following = dict(zip(tail[simple].tolist(), head[simple].tolist(), strict=True))
    loops = []
    for start in sorted(following):
        if start not in following:
            continue
        loop, vertex = [start], following.pop(start)
        while vertex != start and vertex in following:
            loop.append(vertex)
            vertex = following.pop(vertex)
        if vertex == start:
            loops.append(np.array(loop, dtype=np.int64))
    return tuple(loops)


def without_pinches(polygons: Index) -> Index:
    """The polygons without those round a vertex at which the mesh touches itself."""
    while True:
        tail, head = polygons.ravel(), np.roll(polygons, -1, axis=1).ravel()
        n = int(polygons.max(initial=0)) + 1
        is_border = ~np.isin(tail * n + head, head * n + tail)
        pinched = np.bincount(tail[is_border], minlength=n) > 1
        touches = pinched[polygons].any(axis=1)
        if not touches.any():
            return polygons
        polygons = polygons[~touches]


def with_small_holes_filled(mesh: TriangleMesh, max_width: float) -> TriangleMesh:
    """Close every border loop that a ball of a given width holds, with a fan.

    A lone piece whose only border is small is a crumb, and becomes a closed one.

    Parameters
    ----------
    max_width : in spacings.
    """
    vertices, triangles = [mesh.vertices], [mesh.triangles]
    n = len(mesh.vertices)
    for loop in border_loops(mesh.triangles):
        ring = mesh.vertices[loop]
        middle = ring.mean(axis=0)
        if 2.0 * np.linalg.norm(ring - middle, axis=1).max() > max_width:
            continue
        vertices.append(middle[None])
        apex = np.full(len(loop), n)
        triangles.append(np.stack([np.roll(loop, -1), loop, apex], axis=1))
        n += 1
    return compact(np.concatenate(vertices), np.concatenate(triangles))


def with_quad_holes_filled(
    vertices: Array, quads: Index, longest: int, widest: float = np.inf
) -> tuple[Array, Index]:
    """Close border loops of an even number of sides with quads round a new vertex.

    Parameters
    ----------
    vertices, quads : a quad net, shapes ``(n, 3)`` and ``(m, 4)``.
    longest : most sides of a loop that is closed.
    widest : a ball of this width, in spacings, holds every loop that is closed.

    Returns
    -------
    vertices, quads : with one quad for a loop of four sides, and half as many quads as
        sides about a vertex in the middle of a longer one. Loops of an odd number of
        sides stay open: no pure quads fill them.
    """
    new_vertices, new_quads = [vertices], [quads]
    n = len(vertices)
    for loop in border_loops(quads):
        ring = loop[::-1]
        if len(ring) % 2 or not 4 <= len(ring) <= longest:
            continue
        if (
            2.0 * np.linalg.norm(vertices[ring] - vertices[ring].mean(axis=0), axis=1).max()
            > widest
        ):
            continue
        if len(ring) == 4:
            new_quads.append(ring[None])
            continue
        # Every second vertex is joined to the middle.
        before, corner, after = ring[0::2], ring[1::2], np.roll(ring, -2)[0::2]
        new_quads.append(np.stack([before, corner, after, np.full(len(corner), n)], axis=1))
        new_vertices.append(vertices[ring].mean(axis=0)[None])
        n += 1
    return np.concatenate(new_vertices), np.concatenate(new_quads)
