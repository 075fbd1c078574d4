"""Outward normals as the file of a cloud tells them: by its normals, or by where the scanner stood.

A file knows which side of the surface is outside, and so which of two near points lie on
different sheets. How the surface lies is taken from the points all the same: normals in files
are smoothed, rounded or noisy, and a scanner position is no normal at all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from crispline.cloud.nearest import nearest
from crispline.cloud.normals import principal_normals
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.scale import N_NEIGHBOURS, local_noise
from crispline.cloud.working import WorkingCloud
from crispline.surface.base import Array, unit

_N_NEAR = 2 * N_NEIGHBOURS
"""Two sheets that lie close to each other share these neighbours evenly."""
OPPOSITE = -0.5
"""Cosine between the outward directions of points on two sheets; at an edge it is larger."""
_SAME_STATION = 0.9
"""Cosine between the directions in which one scanner sees neighbours."""
_MIN_SHEET = 9
"""Fewer neighbours on the own sheet do not tell its normal: stray directions."""
_MIN_NOISE_SAMPLES = 100
_LEVEL = 0.5  # neighbours vote that lie this near to the tangent plane, in spacings ...
_PARALLEL = 0.9  # ... and whose normals make at least this cosine with the voted for one's
_CLEAR = 0.2
"""A direction that makes a smaller cosine with the normal says nothing: seen at a glance."""
_MIN_RANGE = 1.0
"""No scanner stands nearer to what it sees, in spacings."""
_CHUNK = 50_000


@dataclass(frozen=True)
class Hint:
    """What a file says of the outside.

    Attributes
    ----------
    source : ``normals`` or ``scanner positions``.
    directions : unit vectors that point outward in the working frame, shape ``(n, 3)``; zero
        where nothing is known.
    is_normal : whether they are normals, or directions in which the surface was seen.
    """

    source: str
    directions: Array
    is_normal: bool

    @property
    def missing(self) -> float:
        """Share of the points of which nothing is known."""
        return float(np.mean(~self.directions.any(axis=1)))


@dataclass(frozen=True)
class Facing:
    """Normals that follow a hint.

    Attributes
    ----------
    cloud : the cloud, with neighbours of each point on its own sheet only.
    normals : outward unit normals, shape ``(n, 3)``.
    contradiction : share of the points whose hint denies that of their neighbours on the same
        sheet; the majority decided.
    """

    cloud: WorkingCloud
    normals: Array
    contradiction: float


def hints(given: PointCloud, cloud: WorkingCloud) -> Iterator[Hint]:
    """What the file of a cloud says of the outside, its normals first.

    Parameters
    ----------
    given : the cloud as it was read.
    cloud : what was made of it.
    """
    to_working = cloud.to_user.inverse()
    if given.normals is not None:
        yield Hint("normals", to_working.directions(given.normals[cloud.kept]), True)
    if given.viewpoints is not None:
        towards = to_working.points(given.viewpoints[cloud.kept]) - cloud.points
        is_away = np.linalg.norm(towards, axis=1, keepdims=True) > _MIN_RANGE
        yield Hint("scanner positions", np.where(is_away, unit(towards), 0.0), False)


def facing(cloud: WorkingCloud, hint: Hint, k: int, threads: int = -1) -> Facing:
    """Normals by principal components of each sheet, on the side that the file tells.

    Parameters
    ----------
    cloud : ``n`` points.
    hint : for each of them.
    k : neighbours that a normal is made from.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    sides = hint.directions
    if not hint.is_normal:  # one station never sees both sides of a wall
        station = separated(cloud, hint.directions, _SAME_STATION, threads)
        normals = principal_normals(cloud.points, station.neighbours, k)
        seen = np.einsum("ni,ni->n", normals, hint.directions)
        sides = normals * np.where(np.abs(seen) > _CLEAR, np.sign(seen), 0.0)[:, None]
    around = cloud.neighbours
    cloud = separated(cloud, sides, OPPOSITE, threads)
    normals = principal_normals(cloud.points, cloud.neighbours, k)
    own = np.einsum("ni,ni->n", normals, hint.directions)
    own = np.where(np.abs(own) > _CLEAR, own, 0.0)
    vote = np.empty(len(normals))
    for begin in range(0, len(normals), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        voters = around[rows]
        offset = cloud.points[voters] - cloud.points[rows, None]
        level = np.abs(np.einsum("nki,ni->nk", offset, normals[rows])) < _LEVEL
        cosine = np.einsum("nki,ni->nk", normals[voters], normals[rows])
        is_voter = level & (np.abs(cosine) > _PARALLEL)
        vote[rows] = np.einsum("nk,nk->n", is_voter * np.sign(cosine), own[voters])
    decided = np.where(vote != 0.0, vote, own)
    outward = normals * np.where(decided < 0.0, -1.0, 1.0)[:, None]
    return Facing(cloud, outward, float(np.mean(own * decided < 0.0)))


def separated(
    cloud: WorkingCloud, directions: Array, limit: float = OPPOSITE, threads: int = -1
) -> WorkingCloud:
    """The cloud with neighbours on the own sheet only, and its noise estimated from these.

    Neighbours on a sheet that faces the other way, as the far side of a thin wall does, make
    way for the next ones on the own sheet, the nearest 48 being looked at.

    Parameters
    ----------
    cloud : ``n`` points.
    directions : outward unit vectors, shape ``(n, 3)``; zero where nothing is known.
    limit : points whose directions make a smaller cosine lie on two sheets.
    threads : threads for neighbour queries; the result does not depend on it.
    """
    points, n = cloud.points, len(cloud.points)
    is_known = np.asarray(directions.any(axis=1))
    neighbours, distances = cloud.neighbours.copy(), cloud.distances.copy()
    is_whole = np.ones(n, dtype=bool)
    across = np.einsum("nki,ni->nk", directions[neighbours], directions) < limit
    across &= is_known[neighbours] & is_known[:, None]
    mixed = np.flatnonzero(across.any(axis=1))
    for begin in range(0, len(mixed), _CHUNK):
        rows = mixed[begin : begin + _CHUNK]
        distance, index = nearest(cloud.tree, points[rows], min(_N_NEAR, n), threads)
        across = np.einsum("nki,ni->nk", directions[index], directions[rows]) < limit
        across &= is_known[index] & is_known[rows, None]
        n_own = np.count_nonzero(~across, axis=1)
        is_whole[rows] = n_own >= N_NEIGHBOURS
        known = n_own >= _MIN_SHEET
        # The own sheet first; where it has too few of them, its farthest neighbour fills up.
        place = np.minimum(np.arange(N_NEIGHBOURS), n_own[known, None] - 1)
        order = np.argsort(across[known], axis=1, kind="stable")
        order = np.take_along_axis(order, place, axis=1)
        neighbours[rows[known]] = np.take_along_axis(index[known], order, axis=1)
        distances[rows[known]] = np.take_along_axis(distance[known], order, axis=1)
    whole = neighbours[is_whole]
    sigma = local_noise(points, whole) if len(whole) >= _MIN_NOISE_SAMPLES else cloud.sigma
    return replace(cloud, neighbours=neighbours, distances=distances, sigma=sigma)
