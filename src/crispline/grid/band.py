"""Step three on a grid: flat, curved and sharp patches."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from crispline.grid.centres import grid_curvature
from crispline.grid.lattice import Mask
from crispline.options import SharpenOptions
from crispline.surface.base import Array

_MAX_PASSES = 5
_QUIET = 0.08
"""A threshold that misses no edge of 45 degrees or more, at any position, after any smoothing."""
_LOW = 0.6
_BLOCK = 16
"""Side of the blocks of patches that tell how curved the ground is."""
_BORDER = 5
"""Patches from the border at which the border is no longer felt."""


@cache
def curvature_noise(n_passes: int) -> tuple[float, ...]:
    """Standard deviation of ``H s`` on flat ground, over that of the points, in spacings.

    One value for every distance from the border of the grid, in patches; the
    last holds from there on. Beside the border the missing points and the
    one-sided smoothing make more of the noise.

    >>> round(curvature_noise(0)[-1], 3)
    0.579
    """
    n = _BORDER + n_passes + 4
    i, j = np.mgrid[:n, : 2 * n].astype(float)
    tiny, square = 1e-6, np.zeros(n - 1)
    for row in range(n):
        # The response to one point moved; its square summed along the border is the variance.
        height = np.zeros_like(i)
        height[row, n] = tiny
        bend = grid_curvature(np.stack([i, j, height], axis=2)).mean
        response = smoothed(bend / tiny, np.ones(bend.shape, dtype=bool), n_passes)
        square += np.sum(response**2, axis=1)
    return tuple(float(x) for x in np.sqrt(square[: _BORDER + 1]))


def curved_band(
    bend: Array, has_patch: Mask, sigma: float, options: SharpenOptions
) -> tuple[Mask, Array, float]:
    """Patches that are curved by more than noise explains.

    Curvature that noise makes changes its sign from patch to patch, that of a
    feature does not along it: a few passes of smoothing tell them apart, and take
    out the dependence on where the feature lies between two rows.

    Parameters
    ----------
    bend : signed mean curvature in 1/spacing, shape ``(m, n)``.
    has_patch : shape ``(m, n)``.
    sigma : noise of the points along the normals, spacings.

    Returns
    -------
    is_curved : shape ``(m, n)``. Components above the lower threshold that hold two
        patches above the higher one.
    smooth : curvature as it was judged, 1/spacing, same shape.
    threshold : the higher one, 1/spacing.
    """
    n_passes = 0
    while (
        n_passes < _MAX_PASSES
        and options.noise_quantile * curvature_noise(n_passes)[-1] * sigma > _QUIET
    ):
        n_passes += 1
    gain = np.array(curvature_noise(n_passes))
    noise = options.noise_quantile * gain[-1] * sigma
    high = max(options.curved_floor, noise) if options.eps is None else options.eps
    smooth = np.abs(smoothed(bend, has_patch, n_passes))
    candidate = (smooth > _LOW * high) & has_patch
    if not candidate.any():
        return candidate, smooth, high
    # Ground that is curved all over, such as a thin cylinder, is no feature.
    smooth[candidate] /= np.maximum(_background(smooth, candidate) / high, 1.0)
    candidate &= smooth > _LOW * high
    if noise > 0.0:
        # Only candidates are weighed: there are few of them.
        depth = ndimage.distance_transform_cdt(np.pad(has_patch, 1))[1:-1, 1:-1] - 1
        weight = np.minimum(gain[-1] / gain, 1.0)
        smooth[candidate] *= weight[np.minimum(depth[candidate], _BORDER)]
        candidate &= smooth > _LOW * high
        candidate = _up_to_border(candidate, has_patch, depth, (n_passes + 1) // 2)
    piece, n_pieces = ndimage.label(candidate, np.ones((3, 3)))
    strong = np.bincount(piece[candidate & (smooth > high)], minlength=n_pieces + 1)
    return candidate & (strong[piece] >= 2), smooth, high


def _background(smooth: Array, candidate: Mask) -> Array:
    """Twice the median over the block of patches around each candidate, shape ``(k,)``."""
    m, n = smooth.shape
    rows, columns = (np.arange(size) // min(_BLOCK, size) for size in (m, n))
    rows, columns = (np.minimum(x, max(x[-1] - 1, 0)) for x in (rows, columns))
    block = rows[:, None] * (columns[-1] + 1) + columns
    wanted = np.unique(block[candidate])
    member = np.isin(block, wanted)
    order = np.argsort(block[member], kind="stable")
    values, names = smooth[member][order], block[member][order]
    first = np.searchsorted(names, wanted)
    stop = np.append(first[1:], len(names))
    middle = np.array([np.median(values[a:b]) for a, b in zip(first, stop, strict=True)])
    return np.asarray(2.0 * middle[np.searchsorted(wanted, block[candidate])])


def _up_to_border(candidate: Mask, has_patch: Mask, depth: NDArray[np.int32], width: int) -> Mask:
    """The band as it arrives at a margin of some patches, carried on across the margin.

    In the margin, beside the border and invalid pixels, noise leaves too little of
    a feature to follow it.
    """
    inside = depth >= width
    if width == 0 or not inside.any():
        return candidate
    m, n = candidate.shape
    if has_patch.all():
        inner = candidate[width : m - width, width : n - width]
        return np.pad(inner, width, mode="edge")
    nearest = ndimage.distance_transform_edt(~inside, return_distances=False, return_indices=True)
    return np.asarray(candidate[tuple(nearest)] & has_patch)


def smoothed(values: Array, ok: Mask, n_passes: int) -> Array:
    """Binomial smoothing over the valid cells, which shares the weight of the others."""
    if n_passes == 0:
        return values
    if ok.all():
        for _ in range(n_passes):
            values = _binomial(values)
        return values
    weight = ok.astype(float)
    values = values * weight
    for _ in range(n_passes):
        values, weight = _binomial(values), _binomial(weight)
    return np.where(weight > 0.0, values / np.where(weight > 0.0, weight, 1.0), 0.0)


def _binomial(values: Array) -> Array:
    padded = np.pad(values, ((1, 1), (0, 0)), mode="edge")
    rows = padded[:-2] + padded[2:]
    rows += 2.0 * values
    padded = np.pad(rows, ((0, 0), (1, 1)), mode="edge")
    result = padded[:, :-2] + padded[:, 2:]
    rows *= 2.0
    result += rows
    result /= 16.0
    return np.asarray(result)


def paper_rule(bend: Array, has_patch: Mask, eps: float) -> tuple[Mask, Mask]:
    """Curved patches, and sharp ones: curved with four or more flat of the eight around.

    Beyond the border, and at cells without a patch, the nearest patch counts
    again, so that a feature that runs into the border is found up to it.

    Parameters
    ----------
    bend : mean curvature in 1/spacing, shape ``(m, n)``.
    has_patch : shape ``(m, n)``.
    eps : the threshold, 1/spacing.
    """
    is_curved = (np.abs(bend) >= eps) & has_patch
    is_flat = ~is_curved
    if not has_patch.all():
        nearest = ndimage.distance_transform_edt(
            ~has_patch, return_distances=False, return_indices=True
        )
        is_flat = is_flat[tuple(nearest)]
    m, n = bend.shape
    padded = np.pad(is_flat, 1, mode="edge").astype(np.int8)
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    around = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] - padded[1 : m + 1, 1 : n + 1]
    return is_curved, is_curved & (around >= 4)
