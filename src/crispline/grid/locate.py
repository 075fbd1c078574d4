"""Step four on a grid or a B-spline surface: where the edges and corners are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from crispline.grid.assign import Candidates, assign, candidates
from crispline.grid.collar import collars, in_band
from crispline.grid.corners import Corners, locate_corners
from crispline.grid.crossings import Crossings, locate_crossings
from crispline.grid.detect import Detection
from crispline.grid.isolines import IsoLine, iso_lines
from crispline.grid.lattice import Lattice, Mask, Surface, as_lattice
from crispline.grid.localfit import Support
from crispline.grid.planes import locate_on_planes
from crispline.options import SharpenOptions
from crispline.surface.base import Array

Index = NDArray[np.int64]

_ROUNDS = 2
_ROUNDED = 2
"""Control points this many links from those beside an edge of a given surface are rounded."""
_NEAR = 6
"""Sides within this of a point of the band may hold it, points."""
_ROUNDED_SAMPLES = 0.3
"""What a smooth surface that is to be sharpened lies off an edge, beyond what points may."""
_SURE, _ON_POINT, _MAX_SLACK = 1.0, 1e-6, 0.15


@dataclass(frozen=True)
class Located:
    """Edges and corners of a grid; points in spacings, see :class:`Lattice`.

    Attributes
    ----------
    crossings : where edges cross the links of the grid.
    corners : cells in which edges meet, and where.
    lines : the edges as lines of constant parameter, if all are; else None.
    side : of every point, 0 for none or far from a feature, shape ``(m, n)``.
    is_sharp : cells that an edge runs through, shape ``(m - 1, n - 1)``.
    continued : where the points near an edge would be if their sides went on, NaN
        for others, shape ``(m, n, 3)``.
    """

    crossings: Crossings
    corners: Corners
    lines: tuple[IsoLine, ...] | None
    side: Index
    is_sharp: Mask
    continued: Array


def locate(
    surface: Surface | Lattice, detection: Detection, options: SharpenOptions | None = None
) -> Located:
    """Locate the edges and corners at the patches that were detected.

    The paper's rule: for each sharp patch planes from the flat ones of its eight
    neighbours; two make an edge, three or more a corner. The robust rule: the ground
    on either side of the curved band is one smooth surface each, fitted to all points
    that belong to it nearby; points of the band belong to the side within which they
    lie when both are continued; edges and corners are where two, three or more
    sides meet.
    """
    options = options or SharpenOptions()
    lattice = as_lattice(surface)
    if options.rule == "paper":
        crossings, corners, lines = locate_on_planes(lattice, detection)
        nowhere = np.zeros(lattice.is_valid.shape, dtype=np.int64)
        nothing = np.full(lattice.points.shape, np.nan)
        return Located(crossings, corners, lines, nowhere, detection.is_sharp, nothing)
    sigma = detection.noise.normal
    side, support, ground, continued = _sides(lattice, detection, options)
    crossings = locate_crossings(side, support, options)
    limit = options.max_rounding + 2.0 * sigma
    if not lattice.is_measured:
        limit += _ROUNDED_SAMPLES
    misfit = np.linalg.norm(ground - lattice.points, axis=2)
    crossings = crossings[_rounding_at(crossings, misfit) < limit]
    slack = float(np.clip(_SURE * sigma, _ON_POINT, _MAX_SLACK))
    return Located(
        crossings,
        locate_corners(crossings, side, support, options),
        iso_lines(crossings, support, options) if lattice.has_patch.all() else None,
        side,
        crossed_cells(crossings, lattice.has_patch, slack),
        _near_edges(continued, crossings),
    )


def _sides(
    lattice: Lattice, detection: Detection, options: SharpenOptions
) -> tuple[Index, Support, Array, Array]:
    """The side of every point near the band, what the sides are fitted to, and feet.

    The foot of a point is the nearest point of its side along the normal there, NaN
    where no side was looked for, shape ``(m, n, 3)``: first on the sides as the flat
    ground alone continues them, then on the sides as they were fitted last.
    """
    flat, band = collars(lattice, detection.is_curved, options.support + _NEAR // 2)
    sigma = (detection.noise.normal, detection.noise.tangential)
    support = Support(lattice, flat, options.support, sigma)
    near = ndimage.binary_dilation(in_band(band), np.ones((3, 3), dtype=bool)) & lattice.is_valid
    sites = np.argwhere(near)
    side, feet = flat, []
    for _ in range(_ROUNDS):
        found = candidates(support, sites, flat, _NEAR)
        names = assign(found, support)
        side = flat.copy()
        side[tuple(sites.T)] = names
        feet.append(np.full(lattice.points.shape, np.nan))
        feet[-1][tuple(sites.T)] = _feet(found, names, lattice)
        # Samples of a rounded surface near its edges belong to no side.
        if not lattice.is_measured:
            break
        support = replace(support, side=side)
    return side, support, feet[0], feet[-1]


def _feet(found: Candidates, names: Index, lattice: Lattice) -> Array:
    """Where the side of every site has it, along the side's normal; NaN without, ``(k, 3)``."""
    i, j = found.sites.T
    uv = np.stack([lattice.u[i], lattice.v[j]], axis=1)
    slot = np.argmax(found.names == names[:, None], axis=1)
    row = found.row[np.arange(len(names)), slot]
    known = np.flatnonzero((row >= 0) & (names > 0))
    shape = found.shape[row[known]]
    points = lattice.points[i[known], j[known]]
    if not lattice.is_measured:
        # A rounded point lies off its side along the side, too.
        points = found.course[row[known]].at(uv[known])[0]
    normal = shape.normals(uv[known])
    height = np.einsum("ki,ki->k", shape.at(uv[known])[0] - points, normal)
    feet = np.full((len(names), 3), np.nan)
    feet[known] = points + height[:, None] * normal
    return feet


def _near_edges(feet: Array, crossings: Crossings) -> Array:
    """The feet of points within two links of a crossing, NaN elsewhere."""
    near = np.zeros(feet.shape[:2], dtype=bool)
    end = crossings.start + np.eye(2, dtype=np.int64)[crossings.axis]
    near[tuple(crossings.start.T)] = True
    near[tuple(end.T)] = True
    near = ndimage.binary_dilation(near, np.ones((3, 3), dtype=bool), iterations=_ROUNDED)
    return np.where(near[:, :, None], feet, np.nan)


def _rounding_at(crossings: Crossings, misfit: Array) -> Array:
    """Mean misfit of the points around each crossing, shape ``(k,)``."""
    known = np.isfinite(misfit)
    share = ndimage.uniform_filter(known.astype(float), 3, mode="constant")
    total = ndimage.uniform_filter(np.where(known, misfit, 0.0), 3, mode="constant")
    mean = np.where(share > 1e-9, total / np.where(share > 1e-9, share, 1.0), 0.0)
    end = crossings.start + np.eye(2, dtype=np.int64)[crossings.axis]
    return np.asarray(0.5 * (mean[tuple(crossings.start.T)] + mean[tuple(end.T)]))


def crossed_cells(crossings: Crossings, has_patch: Mask, slack: float) -> Mask:
    """Cells that an edge runs through, shape ``(m, n)``.

    Parameters
    ----------
    slack : an edge this near to a point of the grid, in links, may pass it on either
        side: then all four cells round the point count.
    """
    m, n = has_patch.shape
    crossed = np.zeros((m + 2, n + 2), dtype=bool)
    i, j = crossings.start.T + 1
    across = (crossings.axis == 0).astype(np.int64)
    crossed[i, j] = True
    crossed[i - (1 - across), j - across] = True
    for at_point, step in ((crossings.share < slack, 0), (crossings.share > 1.0 - slack, 1)):
        p, q = i[at_point] + step * across[at_point], j[at_point] + step * (1 - across[at_point])
        for di in (-1, 0):
            for dj in (-1, 0):
                crossed[p + di, q + dj] = True
    return crossed[1:-1, 1:-1] & has_patch
