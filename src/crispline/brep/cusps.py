"""Edges that leave a vertex side by side: they are one, or cross once more, next to it.

Where two borders of a face meet at a small angle, OCCT calls the wire self-intersecting unless
the vertex covers the stretch on which it cannot tell them apart.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from crispline.curve import Curve
from crispline.model import Model
from crispline.surface.base import Array

_REACH = 1.0
"""Edges that are one farther from their vertex are a fault; in the unit of the model, spacings."""
_APART = 1e-4
"""Edges closer than this are one, in that unit."""
_N_SAMPLES = 200
_SIDE_BY_SIDE = np.cos(np.radians(30.0))


def cusp_gaps(model: Model, faces: Iterable[int]) -> Array:
    """How far from each vertex two edges of a face that meet there are one or cross.

    Parameters
    ----------
    faces : indices of those that count.

    Returns
    -------
    Shape ``(n,)``, zero where none leave it side by side.
    """
    gaps = np.zeros(len(model.vertices))
    for face in (model.faces[index] for index in faces):
        for loop in face.loops:
            for (first, way), (second, onward) in zip(loop, loop[1:] + loop[:1], strict=True):
                edges = model.edges[first], model.edges[second]
                vertex = edges[0].end if way > 0 else edges[0].start
                back = _leaving(edges[0].curve, way < 0)
                ahead = _leaving(edges[1].curve, onward > 0)
                place = model.vertices[vertex]
                normal = face.surface.project(place[None])[1][0]
                if first != second:
                    gaps[vertex] = max(gaps[vertex], _together(place, back, ahead, normal))
    return gaps


def _leaving(curve: Curve, is_forward: bool) -> Array:
    """Points along the part of a curve next to its start, or its end, shape ``(k, 3)``."""
    whole = curve.samples(_N_SAMPLES)
    length = float(np.linalg.norm(np.diff(whole, axis=0), axis=1).sum())
    part = min(0.5, _REACH / max(length, _REACH)) * (curve.end - curve.start)
    steps = np.linspace(0.0, part, _N_SAMPLES)
    return curve.evaluate(curve.start + steps if is_forward else curve.end - steps)


def _together(vertex: Array, first: Array, second: Array, normal: Array) -> float:
    """Distance from a vertex to the last place at which two polylines are one or cross.

    They are seen along a normal.
    """
    chords = first[-1] - first[0], second[-1] - second[0]
    cosine = chords[0] @ chords[1] / (np.linalg.norm(chords[0]) * np.linalg.norm(chords[1]))
    if not cosine > _SIDE_BY_SIDE:
        return 0.0
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
    rows = np.flatnonzero((is_one | crosses).any(axis=1))
    return float(np.linalg.norm(first[rows + 1] - vertex, axis=1).max(initial=0.0))


def _cross(first: Array, second: Array) -> Array:
    return np.asarray(first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0])
