"""Surfaces as triangles, for display and measurement."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.files import atomic_path
from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array

_BLOCK = 100_000


def tessellate(spline: TensorSpline, per_span: int = 4) -> tuple[Array, NDArray[np.int64]]:
    """Triangles over a surface, counter-clockwise seen from the side of ``S_u x S_v``.

    Every knot line is a line of triangle edges, so that a crease stays sharp.

    Parameters
    ----------
    per_span : pieces of each span between knots, both ways.

    Returns
    -------
    vertices : points of the surface, shape ``(k, 3)``; ``v`` runs fastest.
    triangles : shape ``(m, 3)``.
    """
    if per_span < 1:
        raise InputError(f"expected at least 1 piece for each span, got {per_span}; raise it")
    domain_u, domain_v = spline.domain
    u = _places(spline.knots_u, domain_u, per_span)
    v = _places(spline.knots_v, domain_v, per_span)
    vertices = spline.evaluate(np.repeat(u, len(v)), np.tile(v, len(u)))
    number = np.arange(len(vertices)).reshape(len(u), len(v))
    a, b, c, d = (
        part.ravel()
        for part in (number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:])
    )
    return vertices, np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])


def _places(knots: Array, domain: tuple[float, float], per_span: int) -> Array:
    low, high = domain
    inner = np.unique(knots[(knots >= low) & (knots <= high)])
    share = np.arange(per_span) / per_span
    places = inner[:-1, None] + np.diff(inner)[:, None] * share
    return np.append(places.ravel(), high)


def write_mesh(path: Path, vertices: Array, triangles: NDArray[np.int64]) -> None:
    """Write triangles as PLY or OBJ, in double precision; the suffix tells which.

    Parameters
    ----------
    vertices : shape ``(k, 3)``.
    triangles : rows of vertices, counted from 0, shape ``(m, 3)``.

    Raises
    ------
    InputError
        The file cannot be written.
    """
    with atomic_path(path) as draft:
        if path.suffix.lower() == ".ply":
            draft.write_bytes(_ply(vertices, triangles))
            return
        with draft.open("w", encoding="ascii") as file:
            file.writelines(_rows("v %.17g %.17g %.17g\n", vertices))
            file.writelines(_rows("f %d %d %d\n", triangles + 1))


def _rows(line: str, values: NDArray[np.generic]) -> Iterator[str]:
    """Rows of an array as text, in blocks: several times faster than `numpy.savetxt`."""
    for first in range(0, len(values), _BLOCK):
        block = values[first : first + _BLOCK]
        yield (line * len(block)) % tuple(block.ravel().tolist())


def _ply(vertices: Array, triangles: NDArray[np.int64]) -> bytes:
    header = (
        "ply",
        "format binary_little_endian 1.0",
        f"element vertex {len(vertices)}",
        *(f"property double {axis}" for axis in "xyz"),
        f"element face {len(triangles)}",
        "property list uchar int vertex_indices",
        "end_header",
    )
    faces = np.empty(len(triangles), dtype=[("count", "u1"), ("vertices", "<i4", (3,))])
    faces["count"], faces["vertices"] = 3, triangles
    text = "".join(f"{line}\n" for line in header).encode("ascii")
    return text + vertices.astype("<f8").tobytes() + faces.tobytes()
