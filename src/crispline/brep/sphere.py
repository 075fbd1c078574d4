"""The axis of a spherical face: the one direction that a sphere leaves open."""

from __future__ import annotations

import numpy as np

from crispline.brep.arcs import trace_loops
from crispline.brep.chart import TURN
from crispline.brep.revolved import SphereChart
from crispline.curve import Circle
from crispline.model import Face, Model
from crispline.surface import Sphere, perpendicular_frame
from crispline.surface.base import Array

_CLEARANCE = 0.1
"""Smallest angle between a pole and a border of the face, radians."""
_N_DIRECTIONS = 64


def sphere_axis(model: Model, face: Face, sphere: Sphere) -> Array:
    """Axis for the parameters of a spherical face, a unit vector of shape ``(3,)``.

    A rim that is a full circle gives the axis: it is then a line ``v = const`` and
    exact in every CAD format. Otherwise the poles are kept out of the face and as
    far from its border as possible, since borders are distorted close to a pole.
    """
    if not face.loops:
        return np.array([0.0, 0.0, 1.0])
    uses = [e for loop in face.loops for e, _ in loop]
    border = np.concatenate([model.edges[e].curve.samples(65) for e in uses]) - sphere.centre
    border /= np.linalg.norm(border, axis=1, keepdims=True)

    def clearance(axis: Array) -> float:
        return float(np.arccos(np.clip(np.abs(border @ axis), 0.0, 1.0)).min())

    for loop in face.loops:
        curve = model.edges[loop[0][0]].curve
        if len(loop) == 1 and isinstance(curve, Circle) and clearance(curve.normal) > _CLEARANCE:
            return curve.normal
    # Directions in the border's own frame, so that the choice follows a rotation.
    own = np.linalg.svd(border.T @ border)[0]
    candidates = sorted(_hemisphere(_N_DIRECTIONS) @ own.T, key=clearance, reverse=True)
    clear = [axis for axis in candidates if clearance(axis) > _CLEARANCE]
    outside = (axis for axis in clear if _n_poles_inside(model, face, sphere, axis) == 0)
    return next(outside, candidates[0])


def _n_poles_inside(model: Model, face: Face, sphere: Sphere, axis: Array) -> int:
    """How many of the two poles lie in the face.

    Along a meridian that meets the border, the last border before a pole tells: the
    face lies on its left.
    """
    chart = SphereChart(sphere.centre, axis, perpendicular_frame(axis)[0], sphere.radius)
    arcs = [arc.uv for loop in trace_loops(model, face, chart) for arc in loop]
    start = np.concatenate([uv[:-1] for uv in arcs])
    end = np.concatenate([uv[1:] for uv in arcs])
    longest = int(np.abs(end[:, 0] - start[:, 0]).argmax())
    before = start[:, 0] - 0.5 * (start[longest, 0] + end[longest, 0])
    turns = np.round(before / TURN) * TURN
    before, after = before - turns, end[:, 0] - start[:, 0] + before - turns
    meets = np.flatnonzero((before < 0.0) != (after < 0.0))
    heights = start[meets, 1]
    is_eastward = after[meets] > before[meets]
    north, south = int(heights.argmax()), int(heights.argmin())
    return int(is_eastward[north]) + int(not is_eastward[south])


def _hemisphere(n: int) -> Array:
    """``n`` evenly spread unit vectors with z >= 0 (a Fibonacci lattice), shape ``(n, 3)``."""
    z = (np.arange(n) + 0.5) / n
    angle = np.arange(n) * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - z * z)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), z])
