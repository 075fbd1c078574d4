"""Step four as the paper has it: planes from the flat patches among the eight neighbours."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.grid.centres import grid_centres
from crispline.grid.corners import Corners
from crispline.grid.crossings import Crossings
from crispline.grid.detect import Detection, cell_normals
from crispline.grid.isolines import IsoLine
from crispline.grid.lattice import Lattice
from crispline.grid.localfit import Sides
from crispline.grid.models import EXPONENTS
from crispline.surface.base import Array, perpendicular_frame
from crispline.surface.intersect import newton_step

Index = NDArray[np.int64]

_SAME = np.cos(np.radians(20.0))
"""Flat patches whose normals differ by less are on one plane."""
_AROUND = np.array([(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)])


@dataclass(frozen=True)
class _Planes:
    """Up to three planes at each sharp patch.

    Attributes
    ----------
    cells : shape ``(k, 2)``.
    points, normals : shape ``(k, 3, 3)``; a zero normal is no plane.
    offset : mean row and column of the patches of each plane from the cell, ``(k, 3, 2)``.
    """

    cells: Index
    points: Array
    normals: Array
    offset: Array

    def __getitem__(self, rows: Index) -> _Planes:
        return _Planes(self.cells[rows], self.points[rows], self.normals[rows], self.offset[rows])


def locate_on_planes(
    lattice: Lattice, detection: Detection
) -> tuple[Crossings, Corners, tuple[IsoLine, ...] | None]:
    """A point for every sharp patch, on the planes of the flat patches around it.

    The paper leaves open how patches become planes: here the two whose normals
    differ most are the seeds, a patch more than 20 degrees from both is the seed of
    a third, every patch goes to the seed nearest to its normal, and a plane is fitted
    to the four points that each of its patches represents (the tangent planes at
    their centres lean towards the edge). Sharp patches with one plane only get no
    point.

    Returns
    -------
    Crossings between neighbouring sharp patches, halfway between their points; the
    points; and the edges as lines of constant parameter, if all are.
    """
    centre, normal = _centres(lattice)
    planes = _planes(lattice, detection, normal)
    is_found = (np.linalg.norm(planes.normals, axis=2) > 0.0).sum(axis=1) >= 2
    planes = planes[np.flatnonzero(is_found)]
    start = centre[tuple(planes.cells.T)]
    points = start + newton_step(start, [_Plane(planes, k) for k in range(3)])
    is_corner = (np.linalg.norm(planes.normals, axis=2) > 0.0).all(axis=1)
    corners = Corners(planes.cells, points, is_corner, np.full(len(points), -1))
    crossings = _between(corners, detection.has_patch.shape)
    lines = _lines(planes, points, lattice) if detection.has_patch.all() else None
    return crossings, corners, lines


@dataclass(frozen=True)
class _Plane:
    """The ``index``-th plane of every cell, as a constraint of Newton's method."""

    planes: _Planes
    index: int

    def project(self, points: Array) -> tuple[Array, Array]:
        normal = self.planes.normals[:, self.index]
        height = np.einsum("ki,ki->k", points - self.planes.points[:, self.index], normal)
        return points - height[:, None] * normal, normal


def _centres(lattice: Lattice) -> tuple[Array, Array]:
    """Centres and unit normals of all patches, shape ``(m - 1, n - 1, 3)``."""
    if lattice.is_measured:
        centres = grid_centres(lattice.points, lattice.is_valid)
        return centres.point, centres.normal
    p = lattice.points
    i, j = np.indices(lattice.has_patch.shape)
    normal = cell_normals(lattice, i.ravel(), j.ravel()).reshape(*i.shape, 3)
    return 0.25 * (p[:-1, :-1] + p[1:, :-1] + p[:-1, 1:] + p[1:, 1:]), normal


def _planes(lattice: Lattice, detection: Detection, normal: Array) -> _Planes:
    cells = np.argwhere(detection.is_sharp)
    is_flat = np.pad(detection.has_patch & ~detection.is_curved, 1)
    near = cells[:, None] + _AROUND
    flat = is_flat[near[..., 0] + 1, near[..., 1] + 1]
    m, n = detection.has_patch.shape
    i, j = np.clip(near[..., 0], 0, m - 1), np.clip(near[..., 1], 0, n - 1)
    d = normal[i, j]
    rows = np.arange(len(cells))
    cosine = np.where(flat[:, :, None] & flat[:, None], np.einsum("kai,kbi->kab", d, d), 2.0)
    widest = cosine.reshape(len(cells), 64).argmin(axis=1)
    first, second = widest // 8, widest % 8
    has_two = cosine[rows, first, second] < _SAME
    nearest = np.maximum(cosine[rows, first], cosine[rows, second])
    third = np.where(flat, nearest, 2.0).argmin(axis=1)
    has_third = has_two & (nearest[rows, third] < _SAME)
    seeds = np.stack([cosine[rows, seed] for seed in (first, second, third)], axis=1)
    seeds[:, 0] = np.where(flat, seeds[:, 0], -2.0)
    seeds[~has_two, 1] = -2.0
    seeds[~has_third, 2] = -2.0
    group = np.where(flat, np.argmax(np.where(seeds > 1.5, -2.0, seeds), axis=1), -1)
    x = lattice.points
    inner = np.stack([x[i, j], x[i + 1, j], x[i, j + 1], x[i + 1, j + 1]], axis=2)
    points, normals, offset = (np.zeros((len(cells), 3, size)) for size in (3, 3, 2))
    for index in range(3):
        share = (group == index).astype(float)
        share /= np.maximum(share.sum(axis=1), 1.0)[:, None]
        middle = 0.25 * np.einsum("ka,kapi->ki", share, inner)
        local = inner - middle[:, None, None]
        spread = np.einsum("ka,kapi,kapj->kij", share, local, local)
        across = np.linalg.eigh(spread)[1][:, :, 0]
        outward = np.sign(np.einsum("ka,kai,ki->k", share, d, across))
        points[:, index] = middle
        normals[:, index] = np.where(share.any(axis=1)[:, None], outward[:, None] * across, 0.0)
        offset[:, index] = share @ _AROUND
    return _Planes(cells, points, normals, offset)


def _between(corners: Corners, shape: tuple[int, ...]) -> Crossings:
    """Crossings of the links between cells with points that share a side."""
    number = np.full(shape, -1, dtype=np.int64)
    number[tuple(corners.cells.T)] = np.arange(len(corners.cells))
    one, two, start, axis = [], [], [], []
    # Cells next to each other in a row share a link along the rows, and the other way.
    for across, (first, second) in enumerate(
        ((number[:, :-1], number[:, 1:]), (number[:-1], number[1:]))
    ):
        both = np.argwhere((first >= 0) & (second >= 0))
        one.append(first[tuple(both.T)])
        two.append(second[tuple(both.T)])
        start.append(both + np.eye(2, dtype=np.int64)[1 - across])
        axis.append(np.full(len(both), across, dtype=np.int64))
    a, b = np.concatenate(one), np.concatenate(two)
    k = len(a)
    points = 0.5 * (corners.points[a] + corners.points[b])
    nothing = np.zeros((k, 2), dtype=np.int64)
    return Crossings(
        np.concatenate(start), np.concatenate(axis), np.full(k, 0.5), points, nothing,
        np.zeros((k, 2, 3)),
    )  # fmt: skip


def _lines(planes: _Planes, points: Array, lattice: Lattice) -> tuple[IsoLine, ...] | None:
    """The bands as lines, if every one is a full row or column of patches, one patch wide."""
    m, n = lattice.has_patch.shape
    if not len(points):
        return None
    for axis, count in ((1, m), (0, n)):
        level, index = np.unique(planes.cells[:, axis], return_inverse=True)
        is_full = (np.bincount(index) == count).all()
        if is_full and (np.diff(level) > 2).all():
            return tuple(
                _line(planes, points, np.flatnonzero(index == k), axis, lattice)
                for k in range(len(level))
            )
    return None


def _line(planes: _Planes, points: Array, rows: Index, axis: int, lattice: Lattice) -> IsoLine:
    part = planes[rows]
    levels, lines = (lattice.u, lattice.v)[axis], (lattice.v, lattice.u)[axis]
    at = float(part.cells[0, axis]) + 0.5
    along = 0.5 * (lines[:-1] + lines[1:])
    uv = np.empty((len(rows), 2))
    uv[:, axis], uv[:, 1 - axis] = np.interp(at, np.arange(len(levels)), levels), along
    below = np.where(np.linalg.norm(part.normals, axis=2) > 0.0, part.offset[:, :, axis], np.nan)
    sides = [
        _as_sides(part, chosen, uv)
        for chosen in (np.nanargmin(below, axis=1), np.nanargmax(below, axis=1))
    ]
    return IsoLine(axis, at, along, points[rows], sides[0], sides[1])


def _as_sides(planes: _Planes, chosen: Index, uv: Array) -> Sides:
    """One plane of each cell as a polynomial of degree one."""
    k = np.arange(len(chosen))
    coefficients = np.zeros((len(chosen), len(EXPONENTS), 3))
    coefficients[:, 0] = planes.points[k, chosen]
    frames = [perpendicular_frame(normal) for normal in planes.normals[k, chosen]]
    coefficients[:, 1] = [x for x, _ in frames]
    coefficients[:, 2] = [y for _, y in frames]
    return Sides(uv, np.ones_like(uv), coefficients)
