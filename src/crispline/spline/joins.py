"""How well the surfaces of a quilt meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.spline.quilt import EdgeSide, Quilt
from crispline.surface.base import Array, unit

_SAMPLES_PER_SIDE = 9


@dataclass(frozen=True)
class Joins:
    """Measured along every edge of a quilt.

    Attributes
    ----------
    gap : per edge, the largest distance between its curve and its surfaces, and
        between the surfaces, shape ``(n_edges,)``; in the unit of the quilt.
    angle : per edge, the largest angle between the normals of its two surfaces,
        radians, shape ``(n_edges,)``; 0 on an open border.
    is_sharp : creases, where an angle is meant to be, shape ``(n_edges,)``.
    """

    gap: Array
    angle: Array
    is_sharp: NDArray[np.bool_]

    @property
    def largest_gap(self) -> float:
        """Largest gap of all edges."""
        return float(self.gap.max(initial=0.0))

    @property
    def largest_kink(self) -> float:
        """Largest angle across an edge that is no crease, radians."""
        return float(self.angle[~self.is_sharp].max(initial=0.0))


def measure_joins(quilt: Quilt) -> Joins:
    """Sample both sides of every edge, at nine places for each side of the net."""
    counts = np.array([_n_samples(edge.left) for edge in quilt.edges])
    first = np.cumsum(counts) - counts
    rows = [np.arange(a, a + n) for a, n in zip(first, counts, strict=True)]
    n_rows = int(counts.sum())
    curve = np.empty((n_rows, 3))
    points, normals = np.full((2, n_rows, 3), np.nan), np.full((2, n_rows, 3), np.nan)
    uses: list[list[tuple[int, int, EdgeSide]]] = [[] for _ in quilt.faces]
    for index, edge in enumerate(quilt.edges):
        t = np.linspace(edge.curve.start, edge.curve.end, counts[index])
        curve[rows[index]] = edge.curve.evaluate(t)
        for which, side in enumerate((edge.left, edge.right)):
            if side is not None:
                uses[side.face].append((which, index, side))
    for face, border in zip(quilt.faces, uses, strict=True):
        lines = [np.linspace(side.start, side.end, counts[index]) for _, index, side in border]
        u, v = np.concatenate(lines).T
        row = np.concatenate([rows[index] for _, index, _ in border])
        at = np.repeat([which for which, _, _ in border], [len(line) for line in lines]), row
        points[at] = face.evaluate(u, v)
        normals[at] = unit(np.cross(face.evaluate(u, v, 1, 0), face.evaluate(u, v, 0, 1)))

    pairs = [curve - points[0], curve - points[1], points[0] - points[1]]
    gaps = np.fmax.reduce([np.linalg.norm(pair, axis=1) for pair in pairs])
    sine = np.linalg.norm(np.cross(*normals), axis=1)
    angles = np.nan_to_num(np.arctan2(sine, np.einsum("ij,ij->i", *normals)))
    is_sharp = np.array([edge.is_sharp for edge in quilt.edges])
    return Joins(np.maximum.reduceat(gaps, first), np.maximum.reduceat(angles, first), is_sharp)


def _n_samples(side: EdgeSide) -> int:
    """Nine for each side of the net that an edge runs along."""
    (u0, v0), (u1, v1) = side.start, side.end
    return _SAMPLES_PER_SIDE * int(max(abs(u1 - u0), abs(v1 - v0)))
