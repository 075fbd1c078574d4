"""A scene as text for the page: typed arrays in base64, positions in 16 bits."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crispline.report.scene import Cloud, Scene
from crispline.surface.base import Array

MAX_POINTS = 200_000
"""Points shown; of larger clouds every k-th."""
_STEPS = 65535
_MARGIN = 0.05
"""Room round the model for points beside it, share of its largest side."""
_TYPES = {"f": "Float32Array", "B": "Uint8Array", "H": "Uint16Array", "I": "Uint32Array"}
NO_FACE = 65535
"""Stands for -1 in the arrays of face rows."""


def encoded(scene: Scene) -> dict[str, Any]:
    """Arrays of a scene, ready for JSON.

    Positions are whole numbers from 0 to 65535 on the cube at ``origin`` with the
    side ``extent``; a step of it is finer than a pixel. Points outside it are left
    out and counted.

    Returns
    -------
    ``origin``, ``extent``, ``n_outside``, ``n_skipped`` and ``arrays``: for every
    name the type of a JavaScript typed array and its little-endian bytes in base64.
    """
    low, high = scene.box()
    side = float((high - low).max()) or 1.0
    extent = side * (1.0 + 2.0 * _MARGIN)
    origin = 0.5 * (low + high) - 0.5 * extent

    def steps(points: Array) -> NDArray[np.uint16]:
        return np.rint(np.clip((points - origin) / extent, 0.0, 1.0) * _STEPS).astype(np.uint16)

    shown, n_outside, n_skipped = _shown(scene.cloud, origin, extent)
    mesh = scene.mesh
    vertices, triangles, rows = _welded(steps(mesh.vertices), mesh.triangles, mesh.faces)
    arrays: dict[str, NDArray[Any]] = {
        "points": steps(shown.points),
        "deviations": np.nan_to_num(shown.deviations, nan=1e30).astype(np.float32),
        "point_faces": _rows(shown.faces),
        "vertices": vertices,
        "triangles": triangles.astype(np.uint32),
        "vertex_faces": _rows(rows),
        "sharp_edges": _segments(scene.sharp_edges, steps),
        "tangent_edges": _segments(scene.tangent_edges, steps),
        "corners": steps(scene.corners),
    }
    if scene.patches is not None:
        arrays |= {
            "quads": _three_bytes(scene.patches.quads),
            "plain": steps(scene.patches.plain),
            "sharp": steps(scene.patches.sharp),
            "patch_kinds": scene.patches.kinds.astype(np.uint8),
        }
    return {
        "origin": origin.tolist(),
        "extent": extent,
        "n_outside": n_outside,
        "n_skipped": n_skipped,
        "arrays": {name: _text(array) for name, array in arrays.items()},
    }


def _shown(cloud: Cloud, origin: Array, extent: float) -> tuple[Cloud, int, int]:
    """The points inside the cube, evenly thinned; how many are outside and how many skipped."""
    offset = (cloud.points - origin) / extent
    inside = np.flatnonzero(((offset >= 0.0) & (offset <= 1.0)).all(axis=1))
    chosen = inside[:: max(1, -(-len(inside) // MAX_POINTS))]
    kept = Cloud(cloud.points[chosen], cloud.deviations[chosen], cloud.faces[chosen])
    return kept, len(cloud.points) - len(inside), len(inside) - len(chosen)


def _welded(
    vertices: NDArray[np.uint16], triangles: NDArray[np.int64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.uint16], NDArray[np.int64], NDArray[np.int64]]:
    """One vertex where a face has several in one place, as along its seam; and its face."""
    owner = np.full(len(vertices), -1, dtype=np.int64)
    owner[triangles] = faces[:, None]
    keys = np.column_stack([owner, vertices.astype(np.int64)])
    unique, index = np.unique(keys, axis=0, return_inverse=True)
    return unique[:, 1:].astype(np.uint16), index.reshape(-1)[triangles], unique[:, 0]


def _rows(faces: NDArray[np.int64]) -> NDArray[np.uint16]:
    return np.where((faces < 0) | (faces >= NO_FACE), NO_FACE, faces).astype(np.uint16)


def _three_bytes(index: NDArray[np.int64]) -> NDArray[np.uint8]:
    """Whole numbers below 2^24 as three bytes each, the lowest first, shape ``(..., 3)``."""
    return index.astype("<u4")[..., None].view(np.uint8)[..., :3]


def _segments(polylines: tuple[Array, ...], steps: Any) -> NDArray[np.uint16]:
    """Ends of all segments, shape ``(s, 2, 3)``."""
    pieces = [np.zeros((0, 2, 3), dtype=np.uint16)]
    for line in map(steps, polylines):
        pieces.append(np.stack([line[:-1], line[1:]], axis=1))
    return np.concatenate(pieces)


def _text(array: NDArray[Any]) -> dict[str, str]:
    little = np.ascontiguousarray(array, dtype=array.dtype.newbyteorder("<"))
    return {
        "type": _TYPES[array.dtype.char],
        "base64": base64.b64encode(little.tobytes()).decode("ascii"),
    }
