"""Edges that leave a vertex side by side: they are one, or cross once more, next to it.

Where two borders of a face touch, OCCT calls the wire self-intersecting, as it cannot tell them
apart for a stretch. A vertex that covers the stretch cures that in memory only: no STEP file says
how much a vertex covers. So one of the two goes straight to the vertex, and arrives at an angle.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from crispline.curve import Curve, arc_length, interpolated, straight_at
from crispline.model import Edge, Model
from crispline.surface.base import Array

_REACH = 1.0
"""Edges that are one farther from their vertex are a fault; in the unit of the model, spacings."""
_APART = 1e-4
"""Edges closer than this are one, in that unit."""
_STRAIGHT = 2.0
"""So near to the vertex an edge is drawn straight to it, in that unit."""
_STEP = 0.5
"""Between the points that it is drawn through, in that unit."""
_MIN_NODES, _N_DENSE = 9, 2000
_N_SAMPLES = 200
_SIDE_BY_SIDE = np.cos(np.radians(30.0))


def with_cusps_opened(model: Model, faces: Iterable[int]) -> Model:
    """Draw one of two edges of a face straight to their vertex where they leave it as one.

    It is the one that is then farther from the other, as a rule the more bent one.

    Parameters
    ----------
    model : in a unit of about a spacing.
    faces : indices of those that count.

    Returns
    -------
    The model with some curves replaced, and the gaps which that makes; the same one where no
    edges leave a vertex side by side.
    """
    edges = list(model.edges)
    for face in (model.faces[index] for index in faces):
        for loop in face.loops:
            for (first, way), (second, onward) in zip(loop, loop[1:] + loop[:1], strict=True):
                if first == second:
                    continue
                sides = ((first, way < 0), (second, onward > 0))
                back, ahead = (_leaving(edges[index].curve, forward) for index, forward in sides)
                normal = face.surface.project(back[:1])[1][0]
                if not _part_late(back, ahead, normal):
                    continue
                opened = [_straight_to_end(edges[index].curve, forward) for index, forward in sides]
                apart = [
                    _apart(_leaving(curve, forward), other)
                    for curve, (_, forward), other in zip(opened, sides, (ahead, back), strict=True)
                ]
                which = int(np.argmax(apart))
                index = sides[which][0]
                edges[index] = _redrawn(edges[index], opened[which])
    return replace(model, edges=tuple(edges))


def _redrawn(edge: Edge, curve: Curve) -> Edge:
    """An edge with another curve, and the gap of it."""
    away, _ = cKDTree(edge.curve.samples(_N_DENSE)).query(curve.samples(_N_DENSE))
    return replace(edge, curve=curve, gap=edge.gap + float(np.max(away)))


def _straight_to_end(curve: Curve, at_start: bool) -> Curve:
    """A curve drawn straight to its start, or its end."""
    length = arc_length(curve.samples(_N_DENSE))[-1]
    nodes = curve.samples(int(np.clip(length / _STEP, _MIN_NODES, _N_DENSE)))
    nodes, direction = straight_at(nodes, at_start, min(_STRAIGHT, 0.5 * length))
    slopes = np.zeros((2, 3))
    slopes[0 if at_start else 1] = direction
    return interpolated(nodes, False, slopes)


def _apart(curve: Array, other: Array) -> float:
    """How far a polyline is from another near their common start."""
    near = curve[_N_SAMPLES // 4 : _N_SAMPLES // 2]
    return float(np.min(cKDTree(other).query(near)[0]))


def _leaving(curve: Curve, is_forward: bool) -> Array:
    """Points along the part of a curve next to its start, or its end, shape ``(k, 3)``."""
    length = arc_length(curve.samples(_N_SAMPLES))[-1]
    part = min(0.5, _REACH / max(length, _REACH)) * (curve.end - curve.start)
    steps = np.linspace(0.0, part, _N_SAMPLES)
    return curve.evaluate(curve.start + steps if is_forward else curve.end - steps)


def _part_late(first: Array, second: Array, normal: Array) -> bool:
    """Whether two polylines from a common start are one next to it, or cross.

    They are seen along a normal.
    """
    chords = first[-1] - first[0], second[-1] - second[0]
    cosine = chords[0] @ chords[1] / (np.linalg.norm(chords[0]) * np.linalg.norm(chords[1]))
    if not cosine > _SIDE_BY_SIDE:
        return False
    flat = np.linalg.svd(normal[None])[2][1:].T
    a, b = first @ flat, second @ flat
    start, step = a[:-1, None], np.diff(a, axis=0)[:, None]
    other, stride = b[None, :-1], np.diff(b, axis=0)[None]
    with np.errstate(divide="ignore", invalid="ignore"):
        across = _cross(step, stride)
        along = _cross(other - start, stride) / across
        beyond = _cross(other - start, step) / across
        foot = np.einsum("ijk,ijk->ij", start - other, stride) / (stride**2).sum(axis=2)
    crosses = (along >= 0.0) & (along <= 1.0) & (beyond >= 0.0) & (beyond <= 1.0)
    crosses[0, 0] = False  # where they start
    to_segment = start - other - np.clip(foot, 0.0, 1.0)[..., None] * stride
    is_one = np.linalg.norm(to_segment, axis=2) < _APART
    is_one[0, 0] = False
    return bool((is_one | crosses).any())


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
