"""Robust orthogonal-distance least squares, shared by all primitive fits.

A fit minimises the sum of Tukey's biweight of the signed distances, so that a
few per cent of foreign points do not count, by reweighted Levenberg-Marquardt
steps. Each step is solved from a QR factorisation of the weighted Jacobian;
normal equations are never formed.

References: Huber and Ronchetti, Robust Statistics, 2nd ed., sections 4.8 and
7.8; More (1978), The Levenberg-Marquardt algorithm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np
from scipy.linalg.lapack import dgels, dgeqrf

from crispline.surface.base import Array

Shape = TypeVar("Shape")

TUKEY_CUT = 4.685
"""Residuals beyond this many sigmas have no weight; 95 % efficiency under Gaussian noise."""
MAD_TO_SIGMA = 1.4826
"""Standard deviation of Gaussian data over its median absolute deviation."""
CONVERGED = 1e-10
"""A fit has converged when a step moves the surface by less than this many sigmas (rms)."""

_MAX_STEPS = 40
_N_COARSE = 250
_COARSE_STEPS = 8
_DRAFT_STEPS = 16
_COARSE_CONVERGED = 1e-2
_COARSE_STARTS = 3
_CLEARLY_LARGER = 1.5
_MAX_DAMPING = 1e8
_UPPER = tuple(np.triu(np.ones((p, p))) for p in range(16))  # np.triu itself takes longer


@dataclass(frozen=True)
class DistanceModel(Generic[Shape]):
    """How a shape's distances depend on its free parameters.

    Attributes
    ----------
    linearise : maps a shape and points ``(n, 3)`` to the signed distances
        ``(n,)`` and their derivatives ``(n, p)`` at a zero step.
    move : the shape after a step ``(p,)``.
    """

    linearise: Callable[[Shape, Array], tuple[Array, Array]]
    move: Callable[[Shape, Array], Shape]


def fit_distances(
    model: DistanceModel[Shape],
    starts: Iterable[Shape],
    points: Array,
    sigma: float,
    is_draft: bool = False,
) -> Shape | None:
    """The shape of least robust distance to the points, from the best of several starts.

    Parameters
    ----------
    model : distances and moves.
    starts : start values; the one that leads lowest on a subset is refined on all points.
    points : shape ``(n, 3)``, spacings.
    sigma : noise along the normal, spacings: the scale of the weights. Where the
        residuals are clearly larger their median magnitude is, so that a poor
        start is not cut away.
    is_draft : stop as soon as a step moves the surface by 1 % of sigma: near
        enough to compare shapes by, at a fraction of the cost.

    Returns
    -------
    The converged shape; None without a start or if the problem is singular.
    """
    subset = points[coarse(len(points))]
    ranked = sorted(
        (
            (spread, index, start)
            for index, start in enumerate(starts)
            if np.isfinite(spread := _spread(model, start, subset, sigma))
        ),
        key=lambda item: item[:2],
    )[:_COARSE_STARTS]
    if not ranked:
        return None
    best = ranked[0][2]
    if len(ranked) > 1:
        improved = [
            _minimised(model, start, subset, sigma, _COARSE_STEPS, _COARSE_CONVERGED)
            for _, _, start in ranked
        ]
        best = min(improved, key=lambda shape: _spread(model, shape, subset, sigma))
    if is_draft:
        return _minimised(model, best, points, sigma, _DRAFT_STEPS, _COARSE_CONVERGED)
    return _minimised(model, best, points, sigma, _MAX_STEPS, CONVERGED)


def coarse(n_points: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """The subset of points that start values are made from and compared on."""
    return thinned(n_points, _N_COARSE)


def thinned(n_points: int, n_kept: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Sorted indices of a reproducible random subset; random, because strides alias with grids."""
    if n_points <= n_kept:
        return np.arange(n_points)
    return np.sort(np.random.default_rng(0).choice(n_points, n_kept, replace=False))


def robust_scale(residuals: Array) -> float:
    """Standard deviation of the residuals about zero, from their median magnitude."""
    middle = len(residuals) // 2
    return MAD_TO_SIGMA * float(np.partition(np.abs(residuals), middle)[middle])


def tukey_weights(residuals: Array, scale: float) -> Array:
    """Biweight ``(1 - u^2)^2`` of ``u = residual / (4.685 scale)``, zero beyond the cut."""
    return np.square(np.maximum(1.0 - np.square(residuals / (TUKEY_CUT * scale)), 0.0))


def _spread(model: DistanceModel[Shape], shape: Shape, points: Array, sigma: float) -> float:
    """Pseudo-Huber mean of the residuals: robust, yet tells bad from worse."""
    residuals, _ = model.linearise(shape, points)
    return float(np.mean(np.sqrt(1.0 + np.square(residuals / sigma))))


def _minimised(
    model: DistanceModel[Shape],
    shape: Shape,
    points: Array,
    sigma: float,
    n_steps: int,
    converged: float,
) -> Shape:
    """Levenberg-Marquardt on Tukey's loss; stops at steps below ``converged`` sigmas (rms).

    The scale of the loss follows the residuals down to the noise and never
    grows: only a loss that comes to rest has a minimum to converge to.
    """
    residuals, jacobian = model.linearise(shape, points)
    scale = _loss_scale(residuals, sigma)
    loss = _tukey_loss(residuals, scale)
    damping = 1e-3
    for count in range(n_steps):
        step, displacement = _step(residuals, jacobian, scale, damping)
        if displacement < converged * scale and count:
            break
        trial = model.move(shape, step)
        trial_residuals, trial_jacobian = model.linearise(trial, points)
        trial_loss = _tukey_loss(trial_residuals, scale)
        # Near the optimum the loss is flat to rounding; such a step is as good as a lower one.
        if trial_loss <= loss * (1.0 + 1e-13) and np.isfinite(trial_jacobian).all():
            shape, residuals, jacobian, loss = trial, trial_residuals, trial_jacobian, trial_loss
            damping = 0.1 * damping if damping > 1e-12 else 0.0
            smaller = min(scale, _loss_scale(residuals, sigma))
            if smaller != scale:
                scale, loss = smaller, _tukey_loss(residuals, smaller)
        else:
            damping = max(10.0 * damping, 1e-6)
            if damping > _MAX_DAMPING:
                break
    return shape


def _loss_scale(residuals: Array, sigma: float) -> float:
    """The noise, unless the residuals are clearly larger.

    Exactly the noise, not the larger of both: the minimum then does not depend
    on the path that led to it.
    """
    scale = robust_scale(residuals)
    return scale if scale > _CLEARLY_LARGER * sigma else sigma


def _step(residuals: Array, jacobian: Array, scale: float, damping: float) -> tuple[Array, float]:
    """Damped step ``(p,)`` and the rms distance by which it moves the surface."""
    squared = np.minimum(np.square(residuals * (1.0 / (TUKEY_CUT * scale))), 1.0)
    root = 1.0 - squared
    p = jacobian.shape[1]
    # LAPACK's own order and no copies: a fit takes this step hundreds of times.
    weighted = np.empty((len(residuals), p + 1), order="F")
    np.multiply(jacobian, root[:, None], out=weighted[:, :p])
    np.multiply(residuals, root, out=weighted[:, p])
    # The last column of the factor is Q' times the residuals: Q itself is not needed.
    factor = dgeqrf(weighted, overwrite_a=1)[0]
    r = factor[:p, :p] * _UPPER[p]
    damped = np.zeros((2 * p, p), order="F")
    damped[:p] = r
    np.fill_diagonal(damped[p:], np.sqrt(damping * np.einsum("ij,ij->j", r, r)))
    right = np.concatenate([-factor[:p, p], np.zeros(p)])
    _, solution, singular = dgels(damped.copy(order="F"), right, overwrite_a=1)
    if singular:
        solution = np.linalg.lstsq(damped, right, rcond=1e-14)[0]
    step = solution[:p]
    # Weights that fall with the residual make plain reweighting undershoot by the
    # ratio of the mean weight to the mean slope of the influence function.
    total, slope = float(root @ root), float(root @ (1.0 - 5.0 * squared))
    step = step * total / max(slope, 0.5 * total) if total > 0.0 else 0.0 * step
    return step, float(np.linalg.norm(r @ step) / np.sqrt(max(total, 1.0)))


def _tukey_loss(residuals: Array, scale: float) -> float:
    """Sum of Tukey's loss, in units of scale squared; bounded by ``n cut^2 / 6``."""
    squared = np.minimum(np.square(residuals / (TUKEY_CUT * scale)), 1.0)
    # The expanded cubic keeps full precision where 1 - (1 - u^2)^3 would cancel.
    return float(TUKEY_CUT**2 / 6.0 * np.sum(squared * (3.0 - squared * (3.0 - squared))))
