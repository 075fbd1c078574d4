"""Points to a surface of revolution: a B-spline profile and the axis that it turns about.

What a lathe makes is round about one line. Along its circles the noise of all points averages
out, so that a profile with many control points is still held well, and the surface closes on
itself, which no height field does.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.fit.bspline import (
    N_SPANS,
    PARAMETER_CORRECTIONS,
    STALLED,
    core_points,
    structure,
)
from crispline.fit.frame import frame_about, tilted
from crispline.fit.profile import basis_rows, bending_rows, profile_knots, start_parameters
from crispline.fit.residual import clipped, residual_limit
from crispline.fit.robust import robust_scale, tukey_weights
from crispline.fit.starts import axis_of_revolution, extent
from crispline.options import FitOptions
from crispline.surface import Profile, RevolvedSurface
from crispline.surface.base import Array, unit
from crispline.surface.basis import DEGREE

MIN_TURN = np.radians(120.0)
"""Points that go round less of the axis may be a piece of any free form."""
MAX_RADIUS = 3.0
"""In extents of the data; a larger radius belongs to a surface of extrusion."""
MIN_RADIUS = 2.0
"""Spacings; a profile that comes nearer to the axis goes through it, which none of ours does."""
MIN_SPAN = 4.0
"""Of a profile between two knots, spacings; a finer one goes round every sharp edge, too."""

MIN_BEND = 3.0
"""Radius of curvature of a profile, spacings; what bends more sharply is an edge."""

_MIN_POINTS = 12
_MAX_TWIST = 0.2  # part of the normals that passes the axis by, their median
_ALONG = 0.1  # weight of the distance along the profile over that across it
_MAX_AXIS_ERROR = 0.5  # standard error anywhere beside the points, spacings
_RIM_SLACK = 0.1
_CLEARANCE = 0.5  # of the least radius: as near as the profile may come beyond its points


@dataclass(frozen=True)
class _Fit:
    """A profile and the axis that it turns about.

    Attributes
    ----------
    origin, frame : a point of the axis, and rows across and along it, shape ``(3, 3)``.
    t, residuals : of the points along the profile and across it, shape ``(n,)``.
    axis_error : largest standard error of the axis' place beside the points, spacings.
    """

    origin: Array
    frame: Array
    profile: Profile
    t: Array
    residuals: Array
    axis_error: float


def fit_revolution(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    border_distance: Array | None = None,
) -> RevolvedSurface | None:
    """The surface of revolution of least description length that leaves nothing but noise.

    The profile is refined until it leaves nothing but noise, and on as long as what it explains
    pays for its control points.

    Parameters
    ----------
    points, normals, sigma, options, border_distance : see
        :func:`crispline.fit.bspline.fit_bspline_surface`.

    Returns
    -------
    The surface, with ``S_u x S_v`` on the normals' side. None if the normals do not meet one
    line, the points leave that line open, the profile is closed, comes to the axis or has an
    edge, or no profile leaves only noise.
    """
    if len(points) < _MIN_POINTS:
        return None
    sigma = max(sigma, options.sigma_floor)
    core = core_points(border_distance, len(points))
    axis = _axis(points[core], normals[core])
    if axis is None:
        return None
    middle = points.mean(axis=0)
    local = points - middle
    origin, frame = axis[0] - middle, frame_about(axis[1])
    spoke, flat = _flattened(local, origin, frame)
    t = start_parameters(flat, _meridian(normals, spoke, frame))
    if t is None:
        return None
    drifts: list[float] = []
    best: _Fit | None = None
    cost = np.inf
    for n_spans in N_SPANS:
        is_stalled = drifts and len(drifts) - int(np.argmin(drifts)) > STALLED
        is_fine = n_spans > N_SPANS[0] and float(np.ptp(t[core])) < MIN_SPAN * n_spans
        if is_stalled or is_fine or n_spans + DEGREE > np.count_nonzero(core):
            break
        found = _fitted(local, t, origin, frame, n_spans, sigma, core)
        if found.axis_error > _MAX_AXIS_ERROR:
            break
        left = structure(points[core], found.residuals[core], sigma, options)
        drifts.append(left.drift)
        if not left.is_noise and best is None:
            continue
        description = _description(found, core, sigma, options)
        if description >= cost:
            break
        best, cost = found, description
    if best is None:
        return None
    limit = residual_limit(sigma, options) + _RIM_SLACK
    agrees = np.abs(best.residuals) < limit
    n_spans = len(best.profile.control_points) - DEGREE
    best = _fitted(local, best.t, best.origin, best.frame, n_spans, sigma, agrees)
    is_edge = best.profile.sharpest_bend(best.t[agrees]) * MIN_BEND > 1.0
    return None if is_edge else _surface(best, middle, local, normals, agrees)


def _description(found: _Fit, used: NDArray[np.bool_], sigma: float, options: FitOptions) -> float:
    """Residuals and control points together, as a description length (Schwarz 1978)."""
    squared = np.square(clipped(found.residuals[used], sigma, options) / sigma)
    n_numbers = len(found.profile.control_points)
    return float(squared.sum() + n_numbers * np.log(len(squared)))


def _axis(points: Array, normals: Array) -> tuple[Array, Array] | None:
    """A point and the direction of the line that the normals meet; None if they meet none."""
    origin, axis = axis_of_revolution(points, normals)
    twist = _twist(points, normals, origin, axis)
    kept = twist <= np.quantile(twist, 0.8)  # strips of neighbours bend it
    origin, axis = axis_of_revolution(points[kept], normals[kept])
    if np.median(_twist(points, normals, origin, axis)) > _MAX_TWIST:
        return None
    frame = frame_about(axis)
    spoke, flat = _flattened(points, origin, frame)
    if not MIN_RADIUS < float(np.median(flat[:, 0])) < MAX_RADIUS * extent(points):
        return None
    return (origin, axis) if _turn(spoke) >= MIN_TURN else None


def _twist(points: Array, normals: Array, origin: Array, axis: Array) -> Array:
    """Part of unit normals that points round the axis, shape ``(n,)``."""
    around = unit(np.cross(axis, points - origin))
    return np.asarray(np.abs(np.einsum("ij,ij->i", normals, around)))


def _turn(spoke: Array) -> float:
    """Angle about the axis that unit vectors ``(n, 2)`` take up."""
    angles = np.sort(np.arctan2(spoke[:, 1], spoke[:, 0]))
    gaps = np.diff(np.append(angles, angles[0] + 2.0 * np.pi))
    return float(2.0 * np.pi - gaps.max())


def _flattened(local: Array, origin: Array, frame: Array) -> tuple[Array, Array]:
    """Unit vectors away from the axis, and radius and height, both shape ``(n, 2)``."""
    place = (local - origin) @ frame.T
    radius = np.linalg.norm(place[:, :2], axis=1)
    spoke = place[:, :2] / np.where(radius > 0.0, radius, 1.0)[:, None]
    return spoke, np.column_stack([radius, place[:, 2]])


def _meridian(normals: Array, spoke: Array, frame: Array) -> Array:
    """Normals ``(n, 3)`` in the half plane of the axis, shape ``(n, 2)``."""
    seen = normals @ frame.T
    outward = np.einsum("ij,ij->i", seen[:, :2], spoke)
    return np.asarray(unit(np.column_stack([outward, seen[:, 2]])))


def _fitted(
    local: Array,
    t: Array,
    origin: Array,
    frame: Array,
    n_spans: int,
    sigma: float,
    used: NDArray[np.bool_],
) -> _Fit:
    """Robust least squares for profile and axis, with parameter corrections by foot points.

    A shift and a tilt of the axis change the radius and height of a point linearly, to first
    order: four more columns in the linear system of the profile. Distances count across the
    profile and hardly along it (tangent distance minimisation: Wang, Pottmann and Liu 2006,
    Fitting B-spline curves to point clouds), so that axis and profile settle together.

    Parameters
    ----------
    local : points about their middle, shape ``(n, 3)``.
    t : along the profile.
    origin, frame : of the axis, see :class:`_Fit`.
    used : which points to fit, shape ``(n,)``.
    """
    robust = np.ones(len(local))
    heading: Array | None = None
    for _ in range(PARAMETER_CORRECTIONS + 1):
        knots = profile_knots(t[used], n_spans)
        spoke, flat = _flattened(local, origin, frame)
        roots = np.where(used, np.sqrt(robust), 0.0)
        control_points, step, axis_error = _solved(knots, t, spoke, flat, heading, roots)
        origin = origin + step[:2] @ frame[:2]
        frame = frame_about(tilted(frame, *step[2:].tolist()))
        profile = Profile(knots, control_points)
        _, flat = _flattened(local, origin, frame)
        t = profile.corrected(flat, t)
        residuals, heading = profile.distances(flat, t), profile.normals(t)
        scale = max(sigma, robust_scale(residuals[used]))
        robust = tukey_weights(residuals, scale)
    return _Fit(origin, frame, profile, t, residuals, scale * axis_error)


def _solved(
    knots: Array, t: Array, spoke: Array, flat: Array, normals: Array | None, roots: Array
) -> tuple[Array, Array, float]:
    """Control points ``(m, 2)`` and step of the axis of least weighted squares and bending.

    Parameters
    ----------
    spoke, flat : of the points, see :func:`_flattened`.
    normals : of the profile at the points, shape ``(n, 2)``; None to count all distances alike.
    roots : of the weights, shape ``(n,)``.

    Returns
    -------
    Control points, shift and tilt of the axis across itself (shape ``(4,)``), and the largest
    standard error of its place beside the points if these have noise 1.
    """
    basis = basis_rows(knots, t, 0)
    n_controls = basis.shape[1]
    radius, height = flat.T
    across = np.column_stack([spoke, height[:, None] * spoke])
    along = np.column_stack([np.zeros_like(spoke), -radius[:, None] * spoke])

    def rows(x: Array, y: Array, weights: Array) -> tuple[Array, Array]:
        """Of the components of the distances in some directions, with their right side."""
        axis = x[:, None] * across + y[:, None] * along
        left = np.column_stack([x[:, None] * basis, y[:, None] * basis, axis])
        return left * weights[:, None], (x * radius + y * height) * weights

    x, y = (np.ones(len(t)), np.zeros(len(t))) if normals is None else normals.T
    first, first_right = rows(x, y, roots)
    second, second_right = rows(-y, x, (1.0 if normals is None else _ALONG) * roots)
    bending = bending_rows(knots, float(np.square(roots).sum()))
    smooth = np.zeros((2 * len(bending), 2 * n_controls + 4))
    smooth[: len(bending), :n_controls] = bending
    smooth[len(bending) :, n_controls : 2 * n_controls] = bending
    system = np.concatenate([first, second, smooth])
    right = np.concatenate([first_right, second_right, np.zeros(len(smooth))])
    # The axis comes last: the corner of the triangle is what the profile leaves open of it.
    triangle = np.asarray(np.linalg.qr(np.column_stack([system, right]), mode="r"))
    solution = np.linalg.lstsq(triangle[:-1, :-1], triangle[:-1, -1], rcond=None)[0]
    controls = solution[: 2 * n_controls].reshape(2, n_controls).T
    return controls, solution[2 * n_controls :], _axis_error(triangle[-5:-1, -5:-1], height)


def _axis_error(factor: Array, height: Array) -> float:
    """Largest standard error of the axis at the ends of the heights, for noise 1.

    ``factor`` is the triangle ``(4, 4)`` of its shifts and tilts.
    """
    diagonal = np.abs(np.diag(factor))
    if diagonal.min() <= 1e-9 * diagonal.max():
        return np.inf
    spread = np.linalg.inv(factor)
    ends = [
        np.linalg.norm(spread[:2] + end * spread[2:], axis=1)
        for end in (height.min(), height.max())
    ]
    return float(np.max(ends))


def _surface(
    found: _Fit, middle: Array, local: Array, normals: Array, used: NDArray[np.bool_]
) -> RevolvedSurface | None:
    """The fit as a surface that faces as the normals ``(n, 3)`` do; None if it has a pole."""
    spoke, flat = _flattened(local, found.origin, found.frame)
    least = float(flat[used, 0].min())
    if least < MIN_RADIUS:
        return None
    profile = found.profile.clear_of(_CLEARANCE * least, float(np.median(found.t[used])))
    facing = profile.normals(found.t)
    if np.einsum("ij,ij->", facing, _meridian(normals, spoke, found.frame)) > 0.0:
        profile = profile.reversed()  # its surface faces to the right of its heading
    return RevolvedSurface(middle + found.origin, found.frame[2], profile)
