"""The cloud as the method sees it: spacing 1, centred, along its principal axes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.cloud.outliers import inliers
from crispline.cloud.scale import N_NEIGHBOURS, local_noise, point_spacing
from crispline.errors import InputError
from crispline.options import CloudOptions
from crispline.surface.base import Array, Similarity

ROUNDING = 2.0**-24
"""Coordinates in the working frame are rounded to this grid, so that a part in metres and the same
part in micrometres become the same numbers, bit by bit; spacings."""

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
    scan : what ``points`` were before they were averaged, the same unless the scan is
        noisy, shape ``(m, 3)``.
    scan_noise : noise of the scan over that of ``points``, 1 unless these are averages.
    """

    points: Array
    neighbours: NDArray[np.int64]
    distances: Array
    sigma: float
    to_user: Similarity
    n_duplicates: int
    n_outliers: int
    kept: NDArray[np.int64]
    scan: Array
    scan_noise: float = 1.0

    @cached_property
    def tree(self) -> cKDTree:
        """Search tree over the points."""
        return cKDTree(self.points)

    @property
    def spacing(self) -> float:
        """Point spacing in the user's unit."""
        return self.to_user.scale

    def warnings(self, n_dropped: int = 0) -> tuple[str, ...]:
        """A sentence for every kind of point that was left out, and one on averages."""
        counts = (
            (n_dropped, "with coordinates that are not finite"),
            (self.n_duplicates, "that repeat another point"),
            (self.n_outliers, "far from all others (outliers)"),
        )
        left_out = tuple(f"{n} points {what} were left out" for n, what in counts if n > 0)
        is_averaged = len(self.points) < len(self.scan)
        return (*left_out, self._averages()) if is_averaged else left_out

    def _averages(self) -> str:
        """What was done about noise and size, see :mod:`crispline.cloud.average`."""
        noise = self.sigma * self.spacing
        return (
            f"averages of about {len(self.scan) / len(self.points):.2g} points each stand for the "
            f"scan, {self.spacing:.3g} apart with a noise of {noise:.3g} instead of "
            f"{self.scan_noise * noise:.3g}: it is noisy for its spacing, or very large; faces "
            "narrower than 3 of these spacings are lost"
        )


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
    refuse_too_few(n_given)
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
    distances, neighbours = nearest(cKDTree(aligned), aligned, N_NEIGHBOURS, threads)
    spacing = point_spacing(distances)
    working = np.round(aligned / spacing / ROUNDING) * ROUNDING
    return WorkingCloud(
        points=working,
        neighbours=neighbours,
        distances=distances / spacing,
        sigma=local_noise(working, neighbours),
        to_user=Similarity(spacing, rotation.T, origin + middle),
        n_duplicates=n_duplicates,
        n_outliers=n_outliers,
        kept=first[kept],
        scan=working,
    )


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


def refuse_too_few(n_points: int) -> None:
    """Raise an `InputError` for fewer points than a neighbourhood needs."""
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
    refuse_too_few(len(centred))
    extents = np.linalg.svd(centred - centred.mean(axis=0), compute_uv=False)
    for flat, what in ((extents[1], "on one line"), (extents[2], "in one plane")):
        if flat <= 1e-6 * extents[0]:
            raise InputError(
                f"a reconstruction needs points around a part, all points of the cloud lie {what}; "
                "check the columns of the file, or scan the part from more sides"
            )
