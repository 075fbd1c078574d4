"""Points to a surface of extrusion: a B-spline profile and the direction that sweeps it.

What a saw, a wire or an extrusion press makes has straight parallel rulings. Along these the
noise of all points averages out, so that a profile with many control points is still held
well, and the surface goes on beyond its points as straight as it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.bspline import (
    N_SPANS,
    PARAMETER_CORRECTIONS,
    STALLED,
    PassThrough,
    core_points,
    structure,
)
from crispline.fit.frame import frame_about, tilted
from crispline.fit.profile import basis_rows, bending_rows, profile_knots, start_parameters
from crispline.fit.residual import residual_limit
from crispline.fit.robust import robust_scale, tukey_weights
from crispline.options import FitOptions
from crispline.surface import ExtrudedSurface, Profile
from crispline.surface.base import Array
from crispline.surface.basis import DEGREE

MIN_TURN = np.radians(10.0)
"""Normals that turn less about the rulings leave their direction open."""

_MIN_RATIO = 3.0  # of the spread of the normals round the rulings to that along them
_PASS_WEIGHT = 100.0
_HEIGHT_MARGIN = 0.5  # straight rulings may go on far beyond the points, in their extent
_RIM_SLACK = 0.1


@dataclass(frozen=True)
class _Fit:
    """A profile, the direction that sweeps it, and the parameters of the points."""

    frame: Array
    profile: Profile
    t: Array
    residuals: Array


def fit_extrusion(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    constraints: PassThrough | None = None,
    border_distance: Array | None = None,
) -> ExtrudedSurface | None:
    """The surface of extrusion with the coarsest profile that leaves nothing but noise.

    Parameters
    ----------
    points, normals, sigma, options, constraints, border_distance : see
        :func:`crispline.fit.bspline.fit_bspline_surface`.

    Returns
    -------
    The surface, with ``S_u x S_v`` on the normals' side. None if the normals do not turn about
    one direction, the profile is closed, or no profile leaves only noise.
    """
    if len(points) < 4:
        return None
    sigma = max(sigma, options.sigma_floor)
    core = core_points(border_distance, len(points))
    direction = _ruling(normals[core])
    if direction is None:
        return None
    fixed = np.empty((0, 3)) if constraints is None else constraints.points
    everything = np.concatenate([points, fixed])
    middle = points.mean(axis=0)
    local = everything - middle
    frame = frame_about(direction)
    start = start_parameters(local @ frame[:2].T, normals @ frame[:2].T)
    if start is None:
        return None
    n = len(points)
    held = np.ones(len(fixed), dtype=bool)
    drifts: list[float] = []
    for n_spans in N_SPANS:
        is_stalled = drifts and len(drifts) - int(np.argmin(drifts)) > STALLED
        if is_stalled or n_spans + DEGREE > np.count_nonzero(core):
            return None
        used = np.concatenate([core, held])
        found = _fitted(local, n, start, frame, n_spans, sigma, used)
        left = structure(points[core], found.residuals[:n][core], sigma, options)
        drifts.append(left.drift)
        if not left.is_noise:
            continue
        limit = residual_limit(sigma, options) + _RIM_SLACK
        agrees = np.concatenate([np.abs(found.residuals[:n]) < limit, held])
        found = _fitted(local, n, found.t, found.frame, n_spans, sigma, agrees)
        return _surface(found, middle, local, normals)
    return None


def _ruling(normals: Array) -> Array | None:
    """The direction across all normals ``(n, 3)``; None if they tell none."""
    spread, axes = np.linalg.eigh(normals.T @ normals / len(normals))
    across = np.sqrt(np.maximum(spread, 0.0))
    is_told = across[1] > max(_MIN_RATIO * across[0], MIN_TURN / np.sqrt(12.0))
    return np.asarray(axes[:, 0]) if is_told else None


def _fitted(
    local: Array,
    n_free: int,
    t: Array,
    frame: Array,
    n_spans: int,
    sigma: float,
    used: NDArray[np.bool_],
) -> _Fit:
    """Robust least squares for profile and direction, with parameter corrections by foot points.

    A tilt of the direction moves a point across it by its height times the tilt, to first order:
    one more column in the linear system of the profile.

    Parameters
    ----------
    local : points about their middle, shape ``(n, 3)``; those after ``n_free`` are constraints.
    t : along the profile.
    frame : rows across and along the direction, shape ``(3, 3)``.
    used : which points to fit, shape ``(n,)``.
    """
    weights = np.where(used, 1.0, 0.0)
    weights[n_free:] = _PASS_WEIGHT
    robust = np.ones(n_free)
    for _ in range(PARAMETER_CORRECTIONS + 1):
        knots = profile_knots(t[used], n_spans)
        roots = weights * np.concatenate([np.sqrt(robust), np.ones(len(local) - n_free)])
        control_points, tilt = _solved(knots, t, local @ frame.T, roots)
        turned = frame_about(tilted(frame, *tilt.tolist()))
        profile = Profile(knots, control_points @ frame[:2] @ turned[:2].T)
        frame = turned
        flat = local @ frame[:2].T
        t = profile.corrected(flat, t)
        residuals = profile.distances(flat, t)
        inner = residuals[:n_free]
        robust = tukey_weights(inner, max(sigma, robust_scale(inner[used[:n_free]])))
    return _Fit(frame, profile, t, residuals)


def _solved(knots: Array, t: Array, local: Array, roots: Array) -> tuple[Array, Array]:
    """Control points ``(m, 2)`` and tilt ``(2,)`` of least weighted squares and bending.

    ``local`` are coordinates across and along the direction, ``roots`` those of the weights.
    """
    rows = np.column_stack([basis_rows(knots, t, 0), local[:, 2]]) * roots[:, None]
    bending = np.pad(bending_rows(knots, float(np.square(roots).sum())), ((0, 0), (0, 1)))
    system = np.concatenate([rows, bending])
    right = np.concatenate([local[:, :2] * roots[:, None], np.zeros((len(bending), 2))])
    solution = np.linalg.lstsq(system, right, rcond=None)[0]
    return solution[:-1], solution[-1]


def _surface(found: _Fit, middle: Array, local: Array, normals: Array) -> ExtrudedSurface:
    """The fit as a surface that faces as the normals ``(n, 3)`` do."""
    height = local @ found.frame[2]
    margin = _HEIGHT_MARGIN * float(np.ptp(height))
    interval = (float(height.min()) - margin, float(height.max()) + margin)
    profile = middle + found.profile.control_points @ found.frame[:2]
    knots, direction = found.profile.knots, found.frame[2]
    surface = ExtrudedSurface.of(knots, profile, direction, interval)
    facing = surface.project(local[: len(normals)] + middle)[1]
    if np.einsum("ij,ij->", facing, normals) < 0.0:
        low, high = interval
        surface = ExtrudedSurface.of(knots, profile, -direction, (-high, -low))
    return surface
