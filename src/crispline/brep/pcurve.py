"""Edges in the parameter plane of a face, with the parameter of the curve itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from crispline import occt
from crispline.brep.arcs import sample_parameters
from crispline.brep.chart import TURN, Chart
from crispline.curve import Curve
from crispline.surface.base import Array

_EXACT = 1e-9
"""A curve is a straight line in (u, v) if it deviates less, relative to the surface's extent."""
_INTERPOLATION_ERROR = 1e-8
"""Interpolation is refined until it is this close to the projected curve (length unit)."""
_MAX_REFINEMENTS = 5


@dataclass(frozen=True)
class PCurve:
    """A curve on a surface.

    Attributes
    ----------
    geometry : ``Geom2d_Curve`` over the parameter interval of the curve in space.
    deviation : largest distance between the two at equal parameters.
    start, end : surface points where it begins and ends, shape ``(3,)``.
    """

    geometry: Any
    deviation: float
    start: Array
    end: Array


def pcurve(curve: Curve, chart: Chart, border: Array) -> PCurve:
    """The projection of a curve on a surface.

    Parameters
    ----------
    border : (u, v) along the curve, shape ``(n, 2)``: tells the period that it lies in,
        and the angle under which it reaches a pole, where a projection has none.
    """
    t = sample_parameters(curve)
    uv = _projected(curve, t, chart, border)
    slope = (uv[-1] - uv[0]) / (t[-1] - t[0])
    straight = uv[0] + (t - t[0])[:, None] * slope
    miss = chart.points(straight) - chart.points(uv)
    if np.abs(miss).max() < _EXACT * (1.0 + np.abs(curve.evaluate(t)).max()):
        if abs(np.linalg.norm(slope) - 1.0) < _EXACT:
            slope = _on_axis(slope)
            geometry = occt.line_2d(uv[0] - t[0] * slope, slope)
        else:
            geometry = occt.bspline_2d(t[[0, 0, -1, -1]], uv[[0, -1]], 1)
        return _measured(geometry, curve, chart, t, straight)

    for _ in range(_MAX_REFINEMENTS):
        spline = make_interp_spline(t, uv, k=3)
        finer = np.sort(np.concatenate([t, 0.5 * (t[:-1] + t[1:])]))
        target = _projected(curve, finer, chart, border)
        error = np.abs(chart.points(spline(finer)) - chart.points(target)).max()
        if error < _INTERPOLATION_ERROR:
            break
        t, uv = finer, target
    geometry = occt.bspline_2d(np.asarray(spline.t), np.asarray(spline.c), 3)
    return _measured(geometry, curve, chart, finer, np.asarray(spline(finer)))


def _projected(curve: Curve, t: Array, chart: Chart, border: Array) -> Array:
    """(u, v) at the curve parameters, moved by whole periods to the border."""
    uv = chart.trace(curve.evaluate(t), t)
    turns = np.round((border[len(border) // 2] - uv[len(uv) // 2]) / TURN) * TURN
    uv += np.where(chart.is_periodic, turns, 0.0)
    for end in (0, -1):
        if chart.is_pole(border[end]):
            uv[end] = border[end]
    return uv


def _on_axis(slope: Array) -> Array:
    """A heading along a parameter axis without its rounding error."""
    rounded = np.round(slope)
    return rounded if np.abs(slope - rounded).max() < _EXACT else slope / np.linalg.norm(slope)


def _measured(geometry: Any, curve: Curve, chart: Chart, t: Array, uv: Array) -> PCurve:
    on_surface = chart.points(uv)
    deviation = float(np.linalg.norm(on_surface - curve.evaluate(t), axis=1).max())
    return PCurve(geometry, deviation, on_surface[0], on_surface[-1])
