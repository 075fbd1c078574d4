"""The cloud as the method sees it: spacing 1, centred, along its principal axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.outliers import inliers
from crispline.errors import InputError
from crispline.options import CloudOptions
from crispline.surface.base import Array, Similarity

N_NEIGHBOURS = 24
"""Neighbours per point, itself included, that every local estimate draws from."""

# Coordinates in the working frame are rounded to this grid, so that a part in
# metres and the same part in micrometres become the same numbers, bit by bit.
_ROUNDING = 2.0**-24

# Lower quartile of the standard normal distribution.
_QUARTILE = -0.6744897501960817

# A step between heights wider than these parts two sheets of a wall: in ranges of the heights, in
# radii of the neighbourhood.
_SHEET_GAP = 0.35
_MIN_SHEET_GAP = 0.3
_MIN_SPLIT = 0.1  # share of the neighbourhoods, for thin walls to matter

# Points beyond the six that a quadric needs, for it to tell the noise.
_MIN_FREEDOM = 5

# Moments smaller than this share of the whole are rounding errors of the input.
_MOMENT_ROUNDING = 2.0**-30


@dataclass(frozen=True)
class WorkingCloud:
    """A clean cloud in the working frame, where the point spacing is 1.

    Attributes
    ----------
    points : shape ``(n, 3)``, spacings.
    neighbours : indices of the 24 nearest points, nearest (itself) first, shape ``(n, 24)``.
    distances : their distances, shape ``(n, 24)``, spacings.
    sigma : noise along the normal, spacings.
    to_user : the map from the working frame back to the user's units.
    n_duplicates, n_outliers : points removed.
    kept : the row of the given cloud that each point comes from, shape ``(n,)``.
    """

    points: Array
    neighbours: NDArray[np.int64]
    distances: Array
    sigma: float
    to_user: Similarity
    n_duplicates: int
    n_outliers: int
    kept: NDArray[np.int64]

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree over the points."""
        return cKDTree(self.points)

    @property
    def spacing(self) -> float:
        """Point spacing in the user's unit."""
        return self.to_user.scale

    def warnings(self, n_dropped: int = 0) -> tuple[str, ...]:
        """A sentence for every kind of point that was left out."""
        counts = (
            (n_dropped, "with coordinates that are not finite"),
            (self.n_duplicates, "that repeat another point"),
            (self.n_outliers, "far from all others (outliers)"),
        )
        return tuple(f"{n} points {what} were left out" for n, what in counts if n > 0)


def working_cloud(points: Array, options: CloudOptions, threads: int = -1) -> WorkingCloud:
    """Clean a cloud and bring it to the working frame.

    Duplicates and outliers (:func:`crispline.cloud.outliers.inliers`) are removed.

    Parameters
    ----------
    points : shape ``(n, 3)``, finite, any unit.
    threads : threads for neighbour queries; the result does not depend on it.

    Raises
    ------
    InputError
        If there are fewer points than one patch needs, or they all coincide,
        lie on a line or lie in a plane.
    """
    n_given = len(points)
    _refuse_too_few(n_given)
    origin = np.median(points, axis=0)
    centred = points - origin
    _, first = np.unique(centred, axis=0, return_index=True)
    first = np.sort(first)
    centred = centred[first]
    n_duplicates = n_given - len(centred)
    _refuse_degenerate(centred)

    kept = inliers(centred, options, threads)
    n_outliers = len(centred) - len(kept)
    centred = centred[kept]
    _refuse_degenerate(centred)

    middle, rotation = _principal_frame(centred)
    aligned = (centred - middle) @ rotation.T
    distances, neighbours = _nearest(aligned, N_NEIGHBOURS, threads)
    spacing = point_spacing(distances)
    working = np.round(aligned / spacing / _ROUNDING) * _ROUNDING
    to_user = Similarity(spacing, rotation.T, origin + middle)
    return WorkingCloud(
        points=working,
        neighbours=neighbours,
        distances=distances / spacing,
        sigma=local_noise(working, neighbours),
        to_user=to_user,
        n_duplicates=n_duplicates,
        n_outliers=n_outliers,
        kept=first[kept],
    )


def point_spacing(distances: Array) -> float:
    """Mean distance between neighbouring points of a surface sampling.

    A disc that holds ``k`` points of a surface with spacing ``s`` has area
    ``k s^2``, so ``s = d_k sqrt(pi / k)``; the median over the points is taken
    for ``k = 8 ... 16`` and averaged, which regular grids need.

    Parameters
    ----------
    distances : sorted neighbour distances, the point itself first, shape ``(n, >= 17)``.
    """
    k = np.arange(8, 17)
    return float(np.mean(np.median(distances[:, 8:17], axis=0) * np.sqrt(np.pi / k)))


def local_noise(points: Array, neighbours: NDArray[np.int64], n_samples: int = 3000) -> float:
    """Noise along the normal: lower quartile of the residuals of quadrics through 24 neighbours.

    The same unit as ``points``. Creased, narrow and littered neighbourhoods are outvoted as
    long as a quarter of the surface is smooth and clean; the median needs half of it, and
    came out up to three times too large on small clouds. In a thin wall nearly every
    neighbourhood holds points of the other side; they are left out.

    Parameters
    ----------
    points : shape ``(n, 3)``.
    neighbours : indices of the neighbours of some points or all, nearest first, shape
        ``(m, k)``, ``k`` over 6.
    n_samples : neighbourhoods that are used.

    References
    ----------
    Quantiles of chi-square: Wilson and Hilferty 1931.
    """
    variances = local_variances(points, neighbours[evenly(len(neighbours), n_samples)])
    return float(np.sqrt(np.quantile(variances[~np.isnan(variances)], 0.25)))


def evenly(n: int, n_samples: int) -> NDArray[np.int64]:
    """Up to ``n_samples`` of the indices 0 to ``n - 1``, evenly apart."""
    return np.unique(np.linspace(0, n - 1, n_samples).astype(np.int64))


def local_variances(points: Array, neighbours: NDArray[np.int64]) -> Array:
    """What quadrics leave of neighbourhoods ``(m, k)``, so scaled that noise has it as quartile.

    Variances of shape ``(m,)``; NaN for a neighbourhood with too few points on its own sheet.
    If all have, nothing tells the noise, and the mean squares of the residuals are returned.
    """
    local = points[neighbours]
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    z, y, x = np.moveaxis(np.einsum("nki,nij->nkj", local, axes), 2, 0)
    own = _own_sheet(z, np.hypot(x, y).max(axis=1))
    design = own[:, :, None] * np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    z = own * z
    q, _ = np.linalg.qr(design)
    residual = z - np.einsum("nkc,nc->nk", q, np.einsum("nkc,nk->nc", q, z))
    n_own = own.sum(axis=1)
    is_told = n_own > 6 + np.minimum(_MIN_FREEDOM, neighbours.shape[1] - 7)
    if not is_told.any():
        return np.asarray((residual**2).mean(axis=1))
    freedom = np.where(is_told, n_own - 6, np.nan)
    # A quantile of a chi-square with f degrees of freedom is about f (1 - g + z sqrt(g))^3 with
    # g = 2/(9 f) and z the same quantile of the normal distribution.
    g = 2.0 / (9.0 * freedom)
    factor = (1.0 - g + _QUARTILE * np.sqrt(g)) ** 3
    return np.asarray((residual**2).sum(axis=1) / (freedom * factor))


def _own_sheet(heights: Array, radius: Array) -> NDArray[np.bool_]:
    """Neighbours on the first one's side of a gap in the heights, shape ``(n, k)``.

    Heights fall into two sheets where the widest step between them is more than a share of
    their range and than a share of the neighbourhood's ``radius`` ``(n,)``.
    """
    order = np.argsort(heights, axis=1)
    ranked = np.take_along_axis(heights, order, axis=1)
    steps = np.diff(ranked, axis=1)
    widest = np.argmax(steps, axis=1)[:, None]
    step = np.take_along_axis(steps, widest, axis=1)[:, 0]
    is_split = step > np.maximum(
        _SHEET_GAP * (ranked[:, -1] - ranked[:, 0]), _MIN_SHEET_GAP * radius
    )
    middle = 0.5 * np.take_along_axis(ranked, widest, axis=1)
    middle += 0.5 * np.take_along_axis(ranked, widest + 1, axis=1)
    is_own = (heights > middle) == (heights[:, :1] > middle)
    if is_split.mean() < _MIN_SPLIT:  # edges and litter, which the quartile outvotes
        return np.ones(heights.shape, dtype=np.bool_)
    return np.asarray(is_own | ~is_split[:, None])


def _nearest(points: Array, k: int, threads: int) -> tuple[Array, NDArray[np.int64]]:
    """Distances and indices of each point's ``k`` nearest, itself first, shape ``(n, k)``."""
    distances, neighbours = cKDTree(points).query(points, k=k, workers=threads)
    return np.asarray(distances), np.asarray(neighbours, dtype=np.int64)


def _principal_frame(points: Array) -> tuple[Array, Array]:
    """Mean and principal axes (rows, right-handed, signs fixed by the skewness).

    Moments are rounded: on a symmetric part the axes and signs would otherwise
    follow the rounding errors of the coordinates, and with them the unit.
    """
    middle = points.mean(axis=0)
    offset = points - middle
    moments = offset.T @ offset
    quantum = _MOMENT_ROUNDING * np.trace(moments)
    _, axes = np.linalg.eigh(np.round(moments / quantum))
    rotation = axes.T[::-1].copy()
    cubes = (offset @ rotation.T) ** 3
    rotation[cubes.sum(axis=0) < -_MOMENT_ROUNDING * np.abs(cubes).sum(axis=0)] *= -1.0
    rotation[2] = np.cross(rotation[0], rotation[1])
    return middle, rotation


def _refuse_too_few(n_points: int) -> None:
    if n_points < N_NEIGHBOURS:
        raise InputError(
            f"a reconstruction needs at least {N_NEIGHBOURS} points, the cloud has {n_points}; "
            "scan more densely or check that the right file was given"
        )


def _refuse_degenerate(centred: Array) -> None:
    """Refuse clouds that span no volume; ``centred`` holds distinct points."""
    if len(centred) == 1:
        raise InputError(
            "a reconstruction needs points on a surface, all points of the cloud are equal; "
            "check the columns of the file"
        )
    _refuse_too_few(len(centred))
    extents = np.linalg.svd(centred - centred.mean(axis=0), compute_uv=False)
    for flat, what in ((extents[1], "on one line"), (extents[2], "in one plane")):
        if flat <= 1e-6 * extents[0]:
            raise InputError(
                f"a reconstruction needs points around a part, all points of the cloud lie {what}; "
                "check the columns of the file, or scan the part from more sides"
            )
