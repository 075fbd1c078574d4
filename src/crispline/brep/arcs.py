"""Face borders in the parameter plane."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from crispline.brep.chart import TURN, Chart
from crispline.curve import BSplineCurve, Curve
from crispline.model import Face, Model
from crispline.surface.base import Array

N_SAMPLES = 65
"""Samples of an edge: enough that no angle turns by half a turn between two of them."""


@dataclass(frozen=True)
class Arc:
    """One use of an edge in a loop, sampled in the parameter plane along the loop.

    Attributes
    ----------
    edge : index into ``Model.edges``.
    sign : +1 if the loop runs along the curve, -1 if against it.
    t : curve parameters, shape ``(n,)``.
    uv : surface parameters, shape ``(n, 2)``, unwrapped; the first and last are
        those of the vertices, so that arcs which share a vertex agree there.
    """

    edge: int
    sign: int
    t: Array
    uv: Array


def trace_loops(model: Model, face: Face, chart: Chart) -> list[list[Arc]]:
    """The loops of a face with its surface normal up: interior on the left in (u, v).

    Model loops have the interior on the left seen from outside the part, so they
    run backwards where the surface normal points inwards.
    """
    loops = []
    for loop in face.loops:
        turned = [(e, s * face.orientation) for e, s in loop[:: face.orientation]]
        loops.append([_trace(model, e, s, chart) for e, s in turned])
    return loops


def sample_parameters(curve: Curve) -> Array:
    """Curve parameters that follow every bend of a curve, ascending."""
    grid = np.linspace(curve.start, curve.end, N_SAMPLES)
    if not isinstance(curve, BSplineCurve):
        return grid
    spans = np.unique(curve.knots)
    within = spans[:-1, None] + np.diff(spans)[:, None] * np.linspace(0, 1, 4, endpoint=False)
    t = np.unique(np.concatenate([grid, within.ravel()]))
    # Keep grid places and knots apart that are the same but for rounding, and both ends.
    is_apart = np.diff(t[:-1], prepend=-np.inf) > 1e-9 * (t[-1] - t[0])
    return np.append(t[:-1][is_apart], t[-1])


def _trace(model: Model, index: int, sign: int, chart: Chart) -> Arc:
    edge = model.edges[index]
    t = sample_parameters(edge.curve)[::sign]
    points = edge.curve.evaluate(t)
    first, last = (edge.start, edge.end)[::sign]
    points[0], points[-1] = model.vertices[first], model.vertices[last]
    return Arc(index, sign, t, chart.trace(points, t))


def is_inside(loops: Sequence[Sequence[Arc]], chart: Chart, axis: int, value: float) -> bool:
    """Whether a parameter line that no loop meets runs in the interior of the face.

    From the line one goes in the positive direction to the first border; the face
    is on that border's left, so its heading tells the side that the line is on.

    Parameters
    ----------
    loops : the loops of the face, interior on the left. Without any, all is inside.
    chart : of a surface that is periodic in ``axis``.
    axis : 0 for the line ``u = value``, 1 for ``v = value``.
    """
    arcs = [arc.uv for loop in loops for arc in loop]
    if not arcs:
        return True
    start = np.concatenate([uv[:-1] for uv in arcs])
    end = np.concatenate([uv[1:] for uv in arcs])
    other = 1 - axis
    longest = int(np.abs(end[:, other] - start[:, other]).argmax())
    level = 0.5 * (start[longest, other] + end[longest, other])
    before, after = start[:, other] - level, end[:, other] - level
    if chart.is_periodic[other]:
        turns = np.round(before / TURN) * TURN
        before, after = before - turns, after - turns
    meets = (before < 0.0) != (after < 0.0)
    if not meets.any():
        return False
    share = before[meets] / (before[meets] - after[meets])
    at = start[meets, axis] + share * (end[meets, axis] - start[meets, axis])
    nearest = int(np.mod(at - value, TURN).argmin())
    is_rising = bool(after[meets][nearest] > before[meets][nearest])
    return is_rising if axis == 0 else not is_rising


def wrapped(angle: Array) -> Array:
    """Angles in ``[-pi, pi)``."""
    return np.mod(angle + np.pi, TURN) - np.pi
