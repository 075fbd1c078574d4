"""Noise that neighbouring points share."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.cloud.scale import evenly
from crispline.surface.base import Array

_N_SAMPLES = 400
_SIZES = (100, 200, 600, 1800)  # points of a place: 6 to 24 spacings from its middle to its end
_MIN_SIZES = 2  # on small parts the smallest hold what their edges have rounded
_MIN_FLAT = 0.4  # share of the places, for flat ones to tell the noise; of a casting 0.35 are
_MAX_RMS = 0.6  # of a flat place, spacings: what lies farther off a plane is no noise
_MIN_LEFT = 0.7  # share of it that a quadric leaves, or the place is bent
_LEAST = 1.2  # growth in three quarters of them; white noise and creases make 1.02


def noise_growth(points: Array, tree: cKDTree, noise: Array, threads: int = -1) -> float:
    """Noise of flat places hundreds of points wide over that of 24 points; 1 for white noise.

    Range cameras and laser trackers smooth what they see, count depth in steps, and their
    lenses bend: points err together with those near them, and a table comes out with ripples. Two
    dozen neighbours do not show that; a plane through hundreds does. A curved face is told from a
    rippled one by a quadric, which explains the former. Noise is shared if it grows in three
    quarters of the flat places of two sizes, so that creases and litter, which few places have,
    do not count; then their median tells by how much, and the largest over the sizes, as
    ripples may be long.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    tree : search tree over them.
    noise : of each point as its neighbours tell it, shape ``(n,)``, spacings.
    threads : threads for neighbour queries; the result does not depend on it.

    Returns
    -------
    1, or 1.2 and more. 1 also unless two fifths of the places of two
    sizes are flat.
    """
    places = evenly(len(points), _N_SAMPLES)
    growth = [1.0]
    for size in _SIZES:
        if size > len(points):
            break
        around = nearest(tree, points[places], size, threads)[1]
        flat, bent = _left(points[around])
        is_flat = (flat < _MAX_RMS) & (bent > _MIN_LEFT * flat)
        if is_flat.mean() < _MIN_FLAT:
            continue
        ratio = flat[is_flat] / np.median(noise[around[is_flat]], axis=1)
        if np.quantile(ratio, 0.25) < _LEAST:
            return 1.0
        growth.append(float(np.median(ratio)))
    return max(growth) if len(growth) > _MIN_SIZES else 1.0


def _left(local: Array) -> tuple[Array, Array]:
    """Rms residuals of planes and of quadrics through neighbourhoods ``(m, k, 3)``."""
    local = local - local.mean(axis=1, keepdims=True)
    _, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", local, local))
    z, y, x = np.moveaxis(np.einsum("nki,nij->nkj", local, axes), 2, 0)
    design = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=2)
    q, _ = np.linalg.qr(design)
    bent = z - np.einsum("nkc,nc->nk", q, np.einsum("nkc,nk->nc", q, z))
    return _rms(z), _rms(bent)


def _rms(heights: Array) -> Array:
    return np.asarray(np.sqrt(np.square(heights).mean(axis=1)))
