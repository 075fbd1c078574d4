"""Nearest edges of a shape, and on which side of the edges of its face a foot lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.gauge.borders import Borders
from crispline.surface.base import Array, unit

Index = NDArray[np.int64]

_N_SEGMENTS = 16
"""Nearest middles of segments among which the nearest segment is sought."""
_SAME = 1e-6
"""Distances that differ by less are one, in segment lengths: segments that meet in a vertex."""


@dataclass(frozen=True)
class EdgeFeet:
    """Nearest points on edges, a row per point.

    Attributes
    ----------
    distance : not negative, shape ``(n,)``.
    is_behind : whether the point lies on the inner side of the shape, shape ``(n,)``.
    face : the face beside the edge that faces the point most, shape ``(n,)``.
    foot : shape ``(n, 3)``.
    """

    distance: Array
    is_behind: NDArray[np.bool_]
    face: Index
    foot: Array


@dataclass(frozen=True)
class BorderSearch:
    """Segments along the edges, ready for many points.

    Attributes
    ----------
    start, end, middle : of the segments, shape ``(k, 3)``.
    face : the face that each bounds, shape ``(k,)``; an edge has a segment for either face.
    normal : outward normal of that face in the middle, shape ``(k, 3)``.
    inward : along the face, away from the edge, shape ``(k, 3)``.
    length : of the longest segment that may be.
    tree : over the middles; None without any edge.
    own_tree : over the middles with ``reach`` times the face as a fourth coordinate.
    """

    start: Array
    end: Array
    middle: Array
    face: Index
    normal: Array
    inward: Array
    length: float
    tree: cKDTree | None
    own_tree: cKDTree | None
    reach: float

    def lower_bounds(self, points: Array) -> Array:
        """A distance that no edge is nearer than, shape ``(n,)``; infinite without edges."""
        if self.tree is None:
            return np.full(len(points), np.inf)
        return np.asarray(self.tree.query(points)[0] - 0.5 * self.length)

    def near(self, points: Array) -> Index:
        """Segments that may be nearest to each point, shape ``(n, m)``."""
        if self.tree is None:
            return np.empty((len(points), 0), dtype=np.int64)
        count = min(_N_SEGMENTS, len(self.face))
        return np.asarray(self.tree.query(points, count)[1], dtype=np.int64).reshape(-1, count)

    def nearest(self, points: Array) -> EdgeFeet:
        """The nearest points on all edges."""
        if self.tree is None or not len(points):
            none = np.empty(0, dtype=np.int64)
            return EdgeFeet(np.empty(0), none.astype(bool), none, np.empty((0, 3)))
        segment = self.near(points)
        offset, distance = self._offsets(points, segment)
        height = np.einsum("nkd,nkd->nk", offset, self.normal[segment])
        chosen = self._clearest(distance, height)
        row = np.arange(len(points))
        return EdgeFeet(
            distance[row, chosen],
            height[row, chosen] < 0.0,
            self.face[segment[row, chosen]],
            points - offset[row, chosen],
        )

    def has_inside(self, feet: Array, face: Index, room: Array) -> NDArray[np.bool_]:
        """Whether points on the surface of a face lie within its borders, shape ``(n,)``.

        Parameters
        ----------
        feet : shape ``(n, 3)``.
        face : the face of each, shape ``(n,)``.
        room : points farther from every edge than this are known to lie inside, ``(n,)``.
        """
        is_inside = self.lower_bounds(feet) > room
        open_ = np.flatnonzero(~is_inside)
        if self.own_tree is None or not len(open_):
            return is_inside
        count = min(_N_SEGMENTS, len(self.face))
        places = np.column_stack([feet[open_], self.reach * face[open_]])
        segment = np.asarray(self.own_tree.query(places, count)[1]).reshape(-1, count)
        is_own = self.face[segment] == face[open_, None]
        offset, distance = self._offsets(feet[open_], segment)
        distance[~is_own] = np.inf
        depth = np.einsum("nkd,nkd->nk", offset, self.inward[segment])
        chosen = self._clearest(distance, depth)
        row = np.arange(len(open_))
        is_inside[open_] = ~is_own.any(axis=1) | (depth[row, chosen] >= -_SAME * self.length)
        return is_inside

    def _offsets(self, points: Array, segment: Index) -> tuple[Array, Array]:
        """From the nearest points on segments ``(n, m)`` to the points, and their lengths."""
        start = self.start[segment]
        along = self.end[segment] - start
        offset = points[:, None, :] - start
        squared = np.einsum("nkd,nkd->nk", along, along)
        share = np.einsum("nkd,nkd->nk", offset, along) / np.where(squared > 0.0, squared, 1.0)
        offset -= np.clip(share, 0.0, 1.0)[:, :, None] * along
        return offset, np.asarray(np.linalg.norm(offset, axis=2))

    def _clearest(self, distance: Array, measure: Array) -> Index:
        """The nearest segment of each row; where several meet in the nearest point, the one
        whose measure is largest in size: its sign is right for the whole corner.
        """
        nearest = distance.min(axis=1, keepdims=True)
        ties = distance <= nearest + _SAME * self.length
        return np.asarray(np.argmax(np.where(ties, np.abs(measure), -1.0), axis=1))


def border_search(lines: Borders, normal: Array, length: float) -> BorderSearch:
    """Make borders ready for many points.

    Parameters
    ----------
    normal : outward normal of the face beside the middle of each segment, shape ``(k, 3)``.
    length : of the longest segment that may be.
    """
    middle = 0.5 * (lines.start + lines.end)
    has_edges = len(middle) > 0
    # Farther than any two places of the shape's surroundings are apart.
    reach = 10.0 * float(np.ptp(middle, axis=0).sum()) if has_edges else 1.0
    own = np.column_stack([middle, reach * lines.face])
    return BorderSearch(
        lines.start,
        lines.end,
        middle,
        lines.face,
        normal,
        unit(np.cross(normal, lines.end - lines.start)),
        length,
        cKDTree(middle) if has_edges else None,
        cKDTree(own) if has_edges else None,
        reach,
    )
