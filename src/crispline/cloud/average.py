"""Averages that stand for the points of a scan whose noise drowns their spacing, or too many."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.cloud.normals import principal_normals
from crispline.cloud.scale import N_NEIGHBOURS, local_noise, point_spacing
from crispline.cloud.thin import thin_walls
from crispline.cloud.waves import noise_growth
from crispline.cloud.working import ROUNDING, WorkingCloud, refuse_too_few
from crispline.options import CloudOptions
from crispline.surface.base import Array

_REACH = 2.0
"""Radius in which the sheet through a point is told, in spacings and in sigmas each."""
_PACKING = 0.64
"""Square of the least distance of points picked from a random sampling until no more fits, for
each point beyond one that goes with every picked one: measured, for 2 to 20 of them."""
_LEAST = 1.5
_LEAST_NOISE = 0.05  # spacings; what is less is none
_SLACK = 1.2  # cells are not all of one size
_MAX_ROUNDS = 2  # noise that neighbouring points share falls more slowly
_MAX_THIN = 0.07  # share of the points that see the other side of a wall; depth in steps makes 0.05
_BLOCK = 20_000  # points whose neighbourhoods are held at a time


def averaged(cloud: WorkingCloud, options: CloudOptions, threads: int = -1) -> WorkingCloud:
    """The cloud, or where it is noisy or very large a cloud of the means of cells of its points.

    The mean of `m` points has a `sqrt(m)`-th of their noise, and means lie `sqrt(m)` times as
    far apart: in their own spacings the noise falls by `m`. Cells must not part the points of
    a sheet by height, or the means would lie in layers: they are drawn on the sheet, to which
    every point is moved along its normal for that. They share no point, so the noise of
    neighbouring means is independent.

    Noise that neighbours share does not fall so. But what is finer than it is hidden in it, and
    means are as good as the points.

    What looks like noise may be the other side of a wall: a cloud of thin walls stays.

    Parameters
    ----------
    cloud : as it was scanned.
    options : the noise and the number of points from which on, and the noise of the means.
    threads : threads for neighbour queries; the result does not depend on it.

    Raises
    ------
    InputError
        If too few means are left.
    """
    for _ in range(_MAX_ROUNDS):
        noise = np.full(len(cloud.points), max(cloud.sigma, _LEAST_NOISE))
        sigma = cloud.sigma * noise_growth(cloud.points, cloud.tree, noise, threads)
        per_mean = points_per_mean(len(cloud.points), sigma, options)
        if per_mean == 1.0 or thin_walls(cloud).share > _MAX_THIN:
            break
        cloud = _averaged(cloud, per_mean, threads)
    return cloud


def points_per_mean(n_points: int, sigma: float, options: CloudOptions) -> float:
    """How many points one mean has to stand for; 1 for a clean cloud of moderate size.

    Parameters
    ----------
    n_points : of the cloud.
    sigma : noise of the points, spacings.
    """
    for_noise = sigma / options.average_noise if sigma > options.max_noise else 1.0
    for_size = _SLACK * n_points / options.max_points if n_points > options.max_points else 1.0
    wanted = max(for_noise, for_size)
    return 1.0 if wanted == 1.0 else max(wanted, _LEAST)


def _averaged(cloud: WorkingCloud, per_mean: float, threads: int) -> WorkingCloud:
    """The means of one round of cells."""
    on_sheet = _on_sheet(cloud.points, cloud.sigma, threads)
    # Heights lengthen the distances of points: the sheet itself tells their spacing.
    distances, _ = nearest(cKDTree(on_sheet), on_sheet, N_NEIGHBOURS, threads)
    spacing = point_spacing(distances)
    beyond_one = max(per_mean / spacing, _LEAST) - 1.0
    distance = spacing * float(np.sqrt(_PACKING * beyond_one))
    centre = _packed(on_sheet, distance)
    refuse_too_few(len(centre))
    _, cell = nearest(cKDTree(on_sheet[centre]), on_sheet, 1, threads)
    size = np.bincount(cell[:, 0])
    sums = [np.bincount(cell[:, 0], weights=column) for column in cloud.points.T]
    means = np.stack(sums, axis=1) / size[:, None]

    distances, neighbours = nearest(cKDTree(means), means, N_NEIGHBOURS, threads)
    spacing = point_spacing(distances)
    points = np.round(means / spacing / ROUNDING) * ROUNDING
    sigma = local_noise(points, neighbours)
    return replace(
        cloud,
        points=points,
        neighbours=neighbours,
        distances=distances / spacing,
        sigma=sigma,
        to_user=replace(cloud.to_user, scale=spacing * cloud.to_user.scale),
        kept=cloud.kept[centre],
        scan=cloud.scan / spacing,
        scan_noise=cloud.scan_noise * cloud.sigma / (sigma * spacing) if sigma > 0.0 else 1.0,
    )


def _on_sheet(points: Array, sigma: float, threads: int) -> Array:
    """Every point moved along its normal to the plane through its neighbours."""
    k = int(np.ceil(np.pi * (_REACH * (1.0 + sigma)) ** 2))
    k = min(max(k, N_NEIGHBOURS), len(points))
    tree = cKDTree(points)
    moved = np.empty_like(points)
    for start in range(0, len(points), _BLOCK):
        block = slice(start, start + _BLOCK)
        around = nearest(tree, points[block], k, threads)[1]
        normal = principal_normals(points, around, k)
        height = np.einsum("ni,ni->n", points[block] - points[around].mean(axis=1), normal)
        moved[block] = points[block] - height[:, None] * normal
    return moved


def _packed(points: Array, distance: float) -> NDArray[np.int64]:
    """Indices of points no nearer to each other than a distance, to which none can be added.

    In rounds, every undecided point that comes before its undecided neighbours in a random
    order is taken and they are not (Luby 1986): the result of going through that order one
    by one. It does not depend on the order in which the points are given.
    """
    rank = np.empty(len(points), dtype=np.int64)
    rank[np.lexsort(points.T)] = np.random.default_rng(0).permutation(len(points))
    pairs = cKDTree(points).query_pairs(distance, output_type="ndarray")
    swapped = rank[pairs[:, 0]] > rank[pairs[:, 1]]
    pairs[swapped] = pairs[swapped, ::-1]
    is_open = np.ones(len(points), dtype=np.bool_)
    is_taken = np.zeros(len(points), dtype=np.bool_)
    while is_open.any():
        is_first = is_open.copy()
        is_first[pairs[:, 1]] = False
        is_taken |= is_first
        is_open &= ~is_first
        is_open[pairs[is_first[pairs[:, 0]], 1]] = False
        pairs = pairs[is_open[pairs].all(axis=1)]
    return np.flatnonzero(is_taken)
