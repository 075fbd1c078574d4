"""The flat ground on either side of a curved band: which points belong together.

A band of curved patches separates the points beside it into sides. Only the
ground near the band counts, so that a feature that ends inside the surface has
two sides although they are one surface farther away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage.morphology import skeletonize
from skimage.segmentation import watershed

from crispline.grid.lattice import Lattice, Mask

Index = NDArray[np.int64]

_RING = 2
"""Width of the strip beside the band that tells the sides apart, points."""
_MIN_RING = 4
"""Strips with fewer points are no side."""
_TWIG = 5
"""Branches of the band that end inside the surface are features if longer than this."""
_EIGHT = np.ones((3, 3), dtype=bool)


def in_band(is_curved: Mask) -> Mask:
    """Points that a curved patch touches, shape ``(m, n)`` from ``(m - 1, n - 1)``."""
    touched = np.zeros((is_curved.shape[0] + 1, is_curved.shape[1] + 1), dtype=bool)
    for i in (0, 1):
        for j in (0, 1):
            touched[i : i + is_curved.shape[0], j : j + is_curved.shape[1]] |= is_curved
    return touched


def collars(lattice: Lattice, is_curved: Mask, reach: int) -> tuple[Index, Mask]:
    """Sides of the band.

    Parameters
    ----------
    lattice : the points.
    is_curved : the band, shape ``(m - 1, n - 1)``.
    reach : how far from the band a side goes, points.

    Returns
    -------
    side : a number from 1 for every point of a side, 0 elsewhere (in the band, far
        from it, invalid), shape ``(m, n)``.
    is_curved : the band without twigs, shape ``(m - 1, n - 1)``.
    """
    is_curved, ends = trunk(lattice, is_curved)
    band = in_band(is_curved)
    flat = lattice.is_valid & ~band
    ring = flat & ndimage.binary_dilation(band, _EIGHT, iterations=_RING)
    ring &= ~_ahead_of(ends, is_curved)
    number, _ = ndimage.label(ring)
    size = np.bincount(number.ravel())
    number[size[number] < _MIN_RING] = 0
    if not number.any():
        return np.zeros(flat.shape, dtype=np.int64), is_curved
    ground = flat & (ndimage.distance_transform_cdt(~band) <= reach)
    # Flooding from the ring goes round the band, never across it.
    side = watershed(np.zeros(flat.shape), number, mask=ground)
    return np.asarray(side, dtype=np.int64), is_curved


def trunk(lattice: Lattice, is_curved: Mask) -> tuple[Mask, Mask]:
    """The band without twigs, and the cells where it ends inside the surface.

    A twig is a branch of the band's skeleton that ends within the surface and is
    shorter than :data:`_TWIG`; a piece of the band with nothing longer is noise.
    """
    margin = _TWIG + 2
    # Beyond the border, and over invalid pixels, the band goes on as it reaches them.
    outside = ~np.pad(lattice.has_patch, margin)
    nearest = ndimage.distance_transform_edt(outside, return_distances=False, return_indices=True)
    skeleton = skeletonize(np.pad(is_curved, margin)[tuple(nearest)])
    leaves_surface = ndimage.binary_dilation(outside, _EIGHT)
    short = skeleton
    for _ in range(_TWIG):
        short = short & ~(_ends(short) & ~leaves_surface)
    long = short
    for _ in range(_TWIG):
        # Back along what was cut, from the ends of what is left.
        tips = _ends(long) if long.any() else long
        long = long | (ndimage.binary_dilation(tips, _EIGHT) & skeleton)
    inner = (slice(margin, -margin),) * 2
    kept = watershed(np.zeros(is_curved.shape), _numbered(skeleton, long)[inner], mask=is_curved)
    end = _ends(long) & ~leaves_surface
    return kept == 1, end[inner]


def _numbered(skeleton: Mask, long: Mask) -> Index:
    """1 where the skeleton stays, 2 where it is a twig, 0 elsewhere."""
    return np.asarray(np.where(long, 1, np.where(skeleton, 2, 0)))


def _ends(skeleton: Mask) -> Mask:
    """Cells of a skeleton with at most one neighbour."""
    count = ndimage.convolve(skeleton.astype(np.int8), _EIGHT.astype(np.int8), mode="constant")
    return np.asarray(skeleton & (count <= 2))


def _ahead_of(ends: Mask, is_curved: Mask) -> Mask:
    """Points near where the band ends inside the surface, shape ``(m, n)``."""
    m, n = ends.shape
    ahead = np.zeros((m + 1, n + 1), dtype=bool)
    depth = ndimage.distance_transform_cdt(np.pad(is_curved, 1, mode="edge"))[1:-1, 1:-1]
    for i, j in np.argwhere(ends):
        r = int(depth[i, j]) + _RING + 1
        ahead[max(i - r, 0) : i + r + 2, max(j - r, 0) : j + r + 2] = True
    return ahead
