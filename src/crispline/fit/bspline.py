"""Free-form region to tensor-product B-spline surface."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crispline.fit.residual import (
    clipped,
    means_over,
    neighbourhoods,
    residual_limit,
    rms,
    rms_limit,
)
from crispline.fit.robust import robust_scale, tukey_weights
from crispline.fit.spline_system import (
    bending_energy,
    smoothing_weight,
    solve_control_points,
    tensor_rows,
)
from crispline.options import FitOptions
from crispline.surface import BSplineSurface
from crispline.surface.base import Array, perpendicular_frame, unit
from crispline.surface.basis import uniform_knots

N_SPANS = (3, 5, 7, 10, 14, 20, 28, 40)
"""Spans tried across a region, as the geometric mean of both directions."""
DOMAIN_MARGIN = 0.12
"""The surface reaches this fraction of the data's extent beyond the data on every side."""
PARAMETER_CORRECTIONS = 3
MAX_NORMAL_ANGLE = np.radians(75.0)
"""Farthest that normals may lean from their mean for a region to be a height field."""

_QUANTILE = 0.02
_POINTS_PER_CONTROL_POINT = 2.5
_TRIAL_CORRECTIONS = 1
_POLISH_CORRECTIONS = 7  # parameters settle slowly, and only the last fit gets so many
_PASS_WEIGHT = 1e4
STALLED = 2
_CORE_DISTANCE = 2.5
_RIM_DISTANCES = (1.5, -np.inf)
_MIN_CORE_POINTS = 40
_MIN_CORE_FRACTION = 0.25
_RIM_SLACK = 0.1
# Stricter than acceptance, for a finer spline is still at hand. In sigmas of a local mean,
# plus a share of the tolerance; the worst places, mostly corners, have a limit of their own.
_MEAN_LIMIT = (1.3, 0.3)
_WORST_LIMIT = (3.3, 1.0)
_WORST_QUANTILE = 0.99


@dataclass(frozen=True)
class PassThrough:
    """What a surface has to meet besides its points.

    Attributes
    ----------
    positions : points on the surface, shape ``(m, 3)``.
    tangent_points : points a little beside the border in a neighbour's tangent
        plane, shape ``(k, 3)``; passing through them too makes the join G1.
    """

    positions: Array
    tangent_points: Array

    @property
    def points(self) -> Array:
        """All of them, shape ``(m + k, 3)``."""
        return np.concatenate([self.positions, self.tangent_points])


@dataclass(frozen=True)
class _Data:
    """Points with their current parameters; the last ``n_fixed`` are constraints."""

    points: Array
    u: Array
    v: Array
    is_used: NDArray[np.bool_]
    n_fixed: int

    @property
    def n_free(self) -> int:
        return len(self.points) - self.n_fixed


@dataclass(frozen=True, eq=False)
class _Trial:
    """One number of spans and how much structure it left in the residuals."""

    drift: float
    n_spans: int
    knots: tuple[Array, Array]
    surface: BSplineSurface
    data: _Data


class Structure(NamedTuple):
    """What is left in the residuals of a trial: their drift, and whether it is only noise."""

    drift: float
    is_noise: bool


def is_height_field(normals: Array) -> bool:
    """Whether normals ``(n, 3)`` stay within 75 degrees of their mean (98 % of them)."""
    cosines = normals @ unit(normals.mean(axis=0))
    return bool(np.quantile(cosines, _QUANTILE) > np.cos(MAX_NORMAL_ANGLE))


def fit_bspline_surface(
    points: Array,
    normals: Array,
    sigma: float,
    options: FitOptions,
    constraints: PassThrough | None = None,
    border_distance: Array | None = None,
    within: tuple[float, float] | None = None,
    is_promising: Callable[[BSplineSurface], bool] | None = None,
) -> BSplineSurface | None:
    """The coarsest bicubic B-spline that leaves nothing but noise.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : oriented unit normals, shape ``(n, 3)``.
    sigma : noise along the normal, spacings.
    options : thresholds of the residual test that chooses the number of spans.
    constraints : points to pass through.
    border_distance : distance of each point from the region's border, shape
        ``(n,)``, spacings. Given it, the fit starts from points well inside and
        takes in the rim where it agrees; the rim holds a neighbour's points.
    within : fewest and most coordinates of control points; coarser and finer surfaces are
        not tried, and one that leaves structure well inside is not fitted to the rim.
    is_promising : asked of the surface whose parameters are nearly right; the others are not
        corrected to the end, which takes as long as all before.

    Returns
    -------
    The surface, with ``S_u x S_v`` on the normals' side; the one of least drift
    if none passes the test. None if the region is no height field: split it. None also if the
    surface is not promising.
    """
    if len(points) < 4 or not is_height_field(normals):
        return None
    data = _parametrised(points, normals, constraints)
    core = core_points(border_distance, len(points))
    sizes = (0.0, np.inf) if within is None else (within[0] / 3.0, within[1] / 3.0)
    best, passes = _coarsest(_using(data, core), sigma, options, N_SPANS, sizes)
    if core.all() or border_distance is None or (within is not None and not passes):
        return _polished(best, sigma, is_promising)
    for distance in _RIM_DISTANCES:
        limit = residual_limit(sigma, options) + _RIM_SLACK
        agrees = np.abs(_residuals(best.surface, best.data)[: data.n_free]) < limit
        used = best.data.is_used[: data.n_free] | ((border_distance >= distance) & agrees)
        finer = tuple(n for n in N_SPANS if n >= best.n_spans)
        best, _ = _coarsest(_using(best.data, used), sigma, options, finer, sizes)
    return _polished(best, sigma, is_promising)


def structure(points: Array, residuals: Array, sigma: float, options: FitOptions) -> Structure:
    """What residuals ``(n,)`` at points ``(n, 3)`` leave to be explained by a finer spline."""
    return structure_over(neighbourhoods(points), residuals, sigma, options)


def structure_over(
    neighbours: NDArray[np.int64], residuals: Array, sigma: float, options: FitOptions
) -> Structure:
    """The same where the :func:`neighbourhoods` of the points are known, trial after trial."""
    averaged = sigma / np.sqrt(max(neighbours.shape[1], 1))
    limit, worst_limit = (
        a * averaged + b * options.tolerance for a, b in (_MEAN_LIMIT, _WORST_LIMIT)
    )
    within = clipped(residuals, sigma, options)
    means = np.abs(means_over(neighbours, within))
    drift = rms(means)
    is_noise = bool(
        drift < limit
        and np.quantile(means, _WORST_QUANTILE) < worst_limit
        and rms(within) < rms_limit(sigma, options)
    )
    return Structure(drift, is_noise)


def _parametrised(points: Array, normals: Array, constraints: PassThrough | None) -> _Data:
    """Project on the plane across the mean normal, along its principal directions."""
    z = unit(normals.mean(axis=0))
    plane = np.stack(perpendicular_frame(z))
    centroid = points.mean(axis=0)
    _, _, turn = np.linalg.svd((points - centroid) @ plane.T, full_matrices=False)
    x = turn[0] @ plane
    fixed = np.empty((0, 3)) if constraints is None else constraints.points
    everything = np.concatenate([points, fixed])
    u, v = ((everything - centroid) @ np.stack([x, np.cross(z, x)]).T).T
    return _Data(everything, u, v, np.ones(len(everything), dtype=bool), len(fixed))


def core_points(border_distance: Array | None, n_points: int) -> NDArray[np.bool_]:
    """Points well inside, or all where too few are."""
    if border_distance is not None:
        inside = border_distance >= _CORE_DISTANCE
        if inside.sum() >= max(_MIN_CORE_POINTS, _MIN_CORE_FRACTION * n_points):
            return inside
    return np.ones(n_points, dtype=bool)


def _using(data: _Data, used: NDArray[np.bool_]) -> _Data:
    return replace(data, is_used=np.concatenate([used, np.ones(data.n_fixed, dtype=bool)]))


def _coarsest(
    data: _Data,
    sigma: float,
    options: FitOptions,
    n_spans: tuple[int, ...],
    sizes: tuple[float, float],
) -> tuple[_Trial, bool]:
    """Refine until the residuals are noise, or the drift no longer falls.

    Returns the trial of least drift, and whether its residuals are noise.
    """
    free = data.is_used[: data.n_free]
    neighbours = neighbourhoods(data.points[: data.n_free][free])
    trials: list[_Trial] = []
    for n, knots in _knot_choices(data, n_spans, sizes):
        surface, data = _fit_on_knots(data, knots, sigma, _TRIAL_CORRECTIONS)
        remaining = _residuals(surface, data)[: data.n_free][free]
        left = structure_over(neighbours, remaining, sigma, options)
        trials.append(_Trial(left.drift, n, knots, surface, data))
        if left.is_noise:
            return trials[-1], True
        best = min(trials, key=lambda trial: trial.drift)
        if len(trials) - trials.index(best) > STALLED:
            break
    return best, False


def _polished(
    trial: _Trial, sigma: float, is_promising: Callable[[BSplineSurface], bool] | None
) -> BSplineSurface | None:
    """The surface of a trial with its parameters corrected to the end; None if not promising."""
    if is_promising is not None and not is_promising(trial.surface):
        return None
    return _fit_on_knots(trial.data, trial.knots, sigma, _POLISH_CORRECTIONS)[0]


def _knot_choices(
    data: _Data, n_spans: tuple[int, ...], sizes: tuple[float, float]
) -> Iterator[tuple[int, tuple[Array, Array]]]:
    """Uniform knots with nearly square spans and from ``sizes[0]`` to ``sizes[1]`` control points.

    Stops where the points cannot determine more; there is one choice at least.
    """
    low = np.array([data.u.min(), data.v.min()])
    size = np.maximum(np.array([data.u.max(), data.v.max()]) - low, 1e-9)
    margin = DOMAIN_MARGIN * size
    aspect = np.sqrt(size[0] / size[1])
    most = min(sizes[1], data.is_used.sum() / _POINTS_PER_CONTROL_POINT)
    counts = [(max(round(n * aspect), 1), max(round(n / aspect), 1)) for n in n_spans]
    n_controls = [(n_u + 3) * (n_v + 3) for n_u, n_v in counts]
    allowed = [index for index, n in enumerate(n_controls) if n <= most] or [0]
    wanted = [index for index in allowed if n_controls[index] >= sizes[0]] or allowed[-1:]
    for index in wanted:
        n_u, n_v = counts[index]
        yield (
            n_spans[index],
            (
                uniform_knots(low[0] - margin[0], low[0] + size[0] + margin[0], n_u),
                uniform_knots(low[1] - margin[1], low[1] + size[1] + margin[1], n_v),
            ),
        )


def _fit_on_knots(
    data: _Data, knots: tuple[Array, Array], sigma: float, n_corrections: int
) -> tuple[BSplineSurface, _Data]:
    """Robust least squares on given knots, with parameter corrections by foot points.

    Parameter correction: Hoschek (1988), Intrinsic parametrization for approximation.
    """
    weights = np.where(data.is_used, 1.0, 0.0)
    weights[data.n_free :] = _PASS_WEIGHT
    area = np.prod([k[-1] - k[0] for k in knots]) / (1.0 + 2.0 * DOMAIN_MARGIN) ** 2
    roughness = smoothing_weight(knots, float(data.is_used.sum() / area)) * bending_energy(*knots)
    robust = np.ones(data.n_free)
    for _ in range(n_corrections + 1):
        all_weights = weights * np.concatenate([robust, np.ones(data.n_fixed)])
        surface = solve_control_points(
            knots, tensor_rows(knots, data.u, data.v), data.points, all_weights, roughness
        )
        u, v = surface.refined_parameters(data.points, data.u, data.v, n_steps=1)
        data = replace(data, u=u, v=v)
        residuals = _residuals(surface, data)[: data.n_free]
        used = data.is_used[: data.n_free]
        robust = tukey_weights(residuals, max(sigma, robust_scale(residuals[used])))
    return surface, data


def _residuals(surface: BSplineSurface, data: _Data) -> Array:
    """Signed distances ``(n,)`` at the current parameters."""
    feet, normals = surface.evaluate_with_normals(data.u, data.v)
    return np.asarray(np.einsum("ij,ij->i", data.points - feet, normals))
