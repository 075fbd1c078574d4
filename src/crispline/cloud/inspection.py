"""What a cloud is like, told before any work is done on it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from crispline.cloud.average import points_per_mean
from crispline.cloud.layout import is_in_scan_order, plane_noise, rim_share, wall_gaps
from crispline.cloud.outliers import inliers
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.scale import N_NEIGHBOURS, local_noise, point_spacing
from crispline.cloud.units import guess_unit
from crispline.errors import InputError
from crispline.options import CloudOptions
from crispline.surface.base import Array

_N_SAMPLES = 5000
"""Points whose surroundings are looked at."""
_N_SUBSET = 40_000
"""Points that outliers are sought among; the share holds for all."""

_MANY_OUTLIERS, _UNEVEN, _WALLS, _HEAVY = 0.1, 6.0, 0.01, 8.0

LOST, UNCERTAIN, WALL = 3.0, 5.0, 2.0
"""Resolution law, in spacings of what a model is made from: faces narrower than the first are
lost, than the second uncertain; walls thinner than the third may merge."""

_SECONDS = (5.0, 7e-4)
_GIGABYTES = (0.5, 1.3e-5)
"""What a run takes: a constant and so much per point. Parts of 50,000 points took 31 to 54
seconds on one idle core and about a gigabyte; the shape matters as much as the count."""


@dataclass(frozen=True)
class Inspection:
    """Lengths in the unit of the cloud.

    Attributes
    ----------
    n_points : finite points.
    n_dropped, n_duplicates : rows without finite coordinates, points that repeat another.
    outlier_share : of the distinct points; exact up to 40,000 of them, else from as many.
    low, high : corners of the box about all but the outliers, shape ``(3,)``.
    unit, unit_reason : a guess, and what it rests on.
    spacing : mean distance between neighbouring points.
    noise : standard deviation along the normal.
    density : 1 % and 99 % quantile of the local spacing.
    is_in_scan_order : whether the points follow one another in rows, as a scanner took them.
    has_normals, has_viewpoints : whether the file brings them.
    rim_share : share of the points at a rim or hole.
    wall_share, wall_gap : share of the points that face another sheet within 3 spacings, and
        the median distance to it; NaN if none does.
    points_per_mean : how many points one average stands for in a reconstruction, see
        :mod:`crispline.cloud.average`; 1 unless the noise is large or the cloud.
    seconds, gigabytes : rough needs of a reconstruction on 2 cores.
    warnings : what stands in the way of a good model, and what to do.
    """

    n_points: int
    n_dropped: int
    n_duplicates: int
    outlier_share: float
    low: Array
    high: Array
    unit: str
    unit_reason: str
    spacing: float
    noise: float
    density: tuple[float, float]
    is_in_scan_order: bool
    has_normals: bool
    has_viewpoints: bool
    rim_share: float
    wall_share: float
    wall_gap: float
    points_per_mean: float
    seconds: float
    gigabytes: float
    warnings: tuple[str, ...]

    @property
    def rim_share_of_open(self) -> float:
        """More rim points than this are a sign of an open scan: a row round the part."""
        return float(1.0 / np.sqrt(self.n_points))

    @property
    def working_spacing(self) -> float:
        """Distance between neighbouring points of what a model is made from."""
        return self.spacing * float(np.sqrt(self.points_per_mean))

    @property
    def lost_below(self) -> float:
        """Faces narrower than this are not found."""
        return LOST * self.working_spacing

    @property
    def uncertain_below(self) -> float:
        """Faces narrower than this are found now and then."""
        return UNCERTAIN * self.working_spacing

    @property
    def wall_below(self) -> float:
        """Walls thinner than this may merge."""
        return WALL * self.working_spacing


def inspect(cloud: PointCloud, options: CloudOptions | None = None, threads: int = 1) -> Inspection:
    """Look at a cloud: counts, scale, noise, density, gaps, walls, and what a run will take.

    Parameters
    ----------
    cloud : any unit.
    options : what counts as an outlier and as noisy.
    threads : threads for neighbour queries; the result does not depend on it.

    Raises
    ------
    InputError
        Fewer than 24 distinct points.
    """
    distinct = np.unique(cloud.points, axis=0)
    if len(distinct) < N_NEIGHBOURS:
        raise InputError(
            f"expected at least {N_NEIGHBOURS} distinct points, the cloud has {len(distinct)}; "
            "scan more densely or check that the right file was given"
        )
    # Spread over the file and the part: the points were sorted by `unique`.
    order = np.random.default_rng(0).permutation(len(distinct))
    subset = distinct[np.sort(order[:_N_SUBSET])]
    kept = subset[inliers(subset, options or CloudOptions(), threads)]
    if len(kept) < N_NEIGHBOURS:
        kept = subset
    tree = cKDTree(distinct)
    sample = _inner(kept, _N_SAMPLES)
    distances, neighbours = map(np.asarray, tree.query(sample, k=N_NEIGHBOURS, workers=threads))
    spacing = point_spacing(distances)
    noise = local_noise(distinct, neighbours, _N_SAMPLES)
    low, high = kept.min(axis=0), kept.max(axis=0)
    local = distances[:, -1] * np.sqrt(np.pi / (N_NEIGHBOURS - 1))
    density = (float(np.quantile(local, 0.01)), float(np.quantile(local, 0.99)))
    thin_noise = min(noise, plane_noise(distinct, neighbours))  # two sheets look like noise
    gaps = wall_gaps(sample, distinct, tree, spacing, thin_noise, threads)
    facing = gaps[np.isfinite(gaps)]
    unit, reason = guess_unit(low, high, spacing)
    n_points = len(distinct)
    per_mean = points_per_mean(n_points, thin_noise / spacing, options or CloudOptions())
    found = Inspection(
        n_points=len(cloud.points),
        n_dropped=cloud.n_dropped,
        n_duplicates=len(cloud.points) - n_points,
        outlier_share=1.0 - len(kept) / len(subset),
        low=low,
        high=high,
        unit=unit,
        unit_reason=reason,
        spacing=spacing,
        noise=noise,
        density=density,
        is_in_scan_order=is_in_scan_order(cloud.points, spacing),
        has_normals=cloud.normals is not None,
        has_viewpoints=cloud.viewpoints is not None,
        rim_share=rim_share(sample, distinct, tree, threads),
        wall_share=len(facing) / len(gaps),
        wall_gap=float(np.median(facing)) if len(facing) else float("nan"),
        points_per_mean=per_mean,
        seconds=_SECONDS[0] + _SECONDS[1] * n_points / per_mean,
        gigabytes=_GIGABYTES[0] + _GIGABYTES[1] * n_points / per_mean,
        warnings=(),
    )
    return replace(found, warnings=tuple(_warnings(found)))


def _warnings(found: Inspection) -> Iterator[str]:
    spacings = found.noise / found.spacing
    if found.outlier_share > _MANY_OUTLIERS:
        yield (
            f"{100.0 * found.outlier_share:.0f} % outliers: they are left out, but crop the scan "
            "to the part if they are its surroundings"
        )
    if found.points_per_mean > 1.0:
        yield (
            f"the noise is {spacings:.1f} spacings, the points are {found.n_points}: averages of "
            f"about {found.points_per_mean:.2g} points each will stand for them; edges stay exact "
            "on large faces, small ones are lost"
        )
    ratio = found.density[1] / found.density[0]
    if ratio > _UNEVEN:
        yield (
            f"the density varies {ratio:.0f} to 1: small features are found only where it is "
            "high; thin out the dense places or scan the others again"
        )
    if found.rim_share > found.rim_share_of_open:
        yield (
            f"{100.0 * found.rim_share:.1f} % of the points lie at rims or holes: the scan may be "
            "open, and then the model is a shell"
        )
    if found.wall_share > _WALLS:
        yield (
            f"{100.0 * found.wall_share:.0f} % of the points face another sheet "
            f"{found.wall_gap / found.spacing:.1f} spacings away: walls under {WALL:g} spacings "
            "merge; scan these places more densely"
        )
    if found.gigabytes > _HEAVY:
        yield (
            f"a run may need {found.gigabytes:.0f} GB of memory: thin out the cloud if you have "
            "less"
        )


def _inner(points: Array, count: int) -> Array:
    """About ``count`` of the points, evenly from the first to the last."""
    return points[np.unique(np.linspace(0, len(points) - 1, count).astype(np.int64))]
