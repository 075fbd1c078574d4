"""Edges that end where their vertex is, so that borders close on every surface.

Where surfaces have no common point, each edge ends nearest to the vertex on its
own curve, and the ends lie apart. A border made of such edges crosses itself or
stays open once it is projected on a surface, and it is projected anew by
whoever reads the file, as STEP files hold no parameter curves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import make_interp_spline

from crispline.curve import BSplineCurve, Curve
from crispline.model import Edge, Model
from crispline.surface.base import Array

_JOINED = 1e-5
"""Ends this close to each other are one point (length unit)."""
_REACH = 5.0
"""How far from its end a curve gives way when the end is moved (length unit)."""
_MAX_PULL = 3.0
"""Ends farther from their vertex are left alone: the checks will tell (length unit)."""
_STEP = 0.25
_MIN_SAMPLES = 33


def meet_at_vertices(model: Model) -> Model:
    """The same model with curves that end exactly at their vertices, where they miss them.

    A vertex moves to the end of the one line or circle that misses it, if there
    is just one; other curves are bent near their ends and become B-splines.

    Parameters
    ----------
    model : in a unit where the point spacing is about 1.
    """
    vertices = np.array(model.vertices)
    ends = [
        edge.curve.evaluate(np.array([edge.curve.start, edge.curve.end])) for edge in model.edges
    ]
    exact: dict[int, list[Array]] = {}
    missed: set[int] = set()
    for edge, places in zip(model.edges, ends, strict=True):
        for vertex, place in zip((edge.start, edge.end), places, strict=True):
            if np.linalg.norm(place - vertices[vertex]) > _JOINED:
                missed.add(vertex)
            if edge.curve.kind != "bspline":
                exact.setdefault(vertex, []).append(place)
    for vertex in missed & set(exact):
        first, *others = exact[vertex]
        if all(np.linalg.norm(place - first) <= _JOINED for place in others):
            vertices[vertex] = first
    edges = tuple(
        _pulled(edge, places, vertices) for edge, places in zip(model.edges, ends, strict=True)
    )
    return replace(model, vertices=vertices, edges=edges)


def _pulled(edge: Edge, places: Array, vertices: Array) -> Edge:
    """The edge with its ends at their vertices."""
    shifts = vertices[[edge.start, edge.end]] - places
    sizes = np.linalg.norm(shifts, axis=1)
    if sizes.max() <= _JOINED or sizes.max() > _MAX_PULL:
        return edge
    return replace(edge, curve=_bent(edge.curve, shifts))


def _bent(curve: Curve, shifts: Array) -> BSplineCurve:
    """The curve moved by ``shifts`` (2, 3) at its ends, fading out along it."""
    length = np.linalg.norm(np.diff(curve.samples(_MIN_SAMPLES), axis=0), axis=1).sum()
    t = np.linspace(curve.start, curve.end, max(_MIN_SAMPLES, int(length / _STEP)))
    share = np.linspace(0.0, 1.0, len(t))
    points = curve.evaluate(t)
    for shift, along in zip(shifts, (share, share[::-1]), strict=True):
        rest = np.maximum(1.0 - along * max(1.0, length / _REACH), 0.0)
        points = points + (rest * rest * (3.0 - 2.0 * rest))[:, None] * shift
    spline = make_interp_spline(t, points, k=3)
    return BSplineCurve(np.asarray(spline.t), np.asarray(spline.c))
