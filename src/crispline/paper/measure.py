"""What the experiment measures: feature errors, reverse distances, detection of sharp patches.

Lengths are over the spacing of the window.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from crispline.paper.patches import Patches
from crispline.paper.windows import REACH, Window
from crispline.shapes.box_cylinder import distance_to_box_cylinder
from crispline.surface.base import Array

Index = NDArray[np.int64]
Mask = NDArray[np.bool_]

N_REVERSE = 4
"""Samples per patch and direction for the reverse distance."""

_REVERSE_SHARE = 0.99
_ON_BORDER = 1e-9
"""A feature this close to the border of a cell runs on it, in cells."""
_MAX_SLACK = 0.25


@dataclass(frozen=True)
class Deviation:
    """How far a surface and the truth are apart, in spacings.

    Attributes
    ----------
    error : mean distance of the feature's samples to the surface (the paper's measure).
    reverse_mean, reverse_p99 : distance of the surface to the true model, by area.
    """

    error: float
    reverse_mean: float
    reverse_p99: float


@dataclass(frozen=True)
class Hits:
    """Counts of sharp patches; precision is ``n_true / n_sharp``, recall ``n_found / n_pieces``.

    Attributes
    ----------
    n_sharp : patches that were found sharp.
    n_true : those of them that the feature runs through.
    n_pieces : short pieces of the feature, of equal length, inside the window.
    n_found : those of them that run through a patch that was found sharp.
    """

    n_sharp: int
    n_true: int
    n_pieces: int
    n_found: int


def deviation(surface: Patches, window: Window) -> Deviation:
    """Both directions of the distance between a surface and the truth."""
    error = float(surface.distances(window.samples).mean() / window.spacing)
    points, areas = surface.samples(N_REVERSE)
    away = distance_to_box_cylinder(points / window.spacing)
    return Deviation(error, *mean_and_p99(away, areas))


def mean_and_p99(away: Array, areas: Array) -> tuple[float, float]:
    """Mean and 99 % quantile of distances ``(k,)`` that stand for areas ``(k,)``."""
    order = np.argsort(away)
    below = np.cumsum(areas[order])
    p99 = away[order][np.searchsorted(below, _REVERSE_SHARE * below[-1])]
    return float(np.average(away, weights=areas)), float(p99)


def hits(is_sharp: Mask, window: Window, level: float) -> Hits:
    """Compare the patches found sharp with the cells that the feature runs through.

    Parameters
    ----------
    is_sharp : one for every cell of the grid, shape ``(m - 1, n - 1)``; a cell's patch
        represents the four points at its corners.
    window : the grid without noise.
    level : the noise level. A feature on the border of a cell counts for either side,
        and noise moves the points at that border; so a feature within the length of the
        noise step (at most a quarter of a cell) of a border counts as on it.
    """
    step = level * REACH * window.spacing / window.cell
    slack = min(max(step, _ON_BORDER), _MAX_SLACK)
    is_true = np.zeros_like(window.is_patch)
    is_inside, is_found = np.zeros((2, len(window.course)), dtype=bool)
    for row, column, exists in _cells_at(window, slack):
        is_true[row[exists], column[exists]] = True
        is_found[exists] |= is_sharp[row[exists], column[exists]]
    for _, _, exists in _cells_at(window, _ON_BORDER):
        is_inside |= exists
    return Hits(
        n_sharp=int(is_sharp.sum()),
        n_true=int((is_sharp & is_true).sum()),
        n_pieces=int(is_inside.sum()),
        n_found=int((is_inside & is_found).sum()),
    )


def _cells_at(window: Window, slack: float) -> Iterator[tuple[Index, Index, Mask]]:
    """Row, column and existence of up to four cells within ``slack`` of each piece."""
    patch = window.is_patch
    first = np.ceil(window.course - 1.0 - slack).astype(np.int64)
    last = np.floor(window.course + slack).astype(np.int64)
    for row, column in product((first[:, 0], last[:, 0]), (first[:, 1], last[:, 1])):
        exists = (row >= 0) & (row < patch.shape[0]) & (column >= 0) & (column < patch.shape[1])
        exists[exists] = patch[row[exists], column[exists]]
        yield row, column, exists
