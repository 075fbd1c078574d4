"""Where two surfaces have the same normal: tangent joins and crossing creases.

Where two surfaces touch, their distances say nothing about where across the
border they do, but their normals do: the difference of the normals grows
linearly with the distance from the contact, at the rate of the difference of
the curvatures. This second-order information makes Newton's method regular
again at the two places where distances alone leave it singular.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from crispline.sharp.trace import MAX_MOVE, Guide
from crispline.surface import Surface
from crispline.surface.base import Array, unit
from crispline.surface.intersect import angles, distance, intersect

_DIFFERENCE = 0.05
_MIN_RATE = 2e-3
_LOOSE = 0.25  # share of the rate along most of a border below which it says nothing
_MAX_BRANCH_GAP = 0.05
_CONVERGED = 1e-3
_MAX_BRANCH_ANGLE = np.radians(30.0)


@dataclass(frozen=True)
class Contact:
    """The sheet of points at which two surfaces have the same normal, seen in one direction.

    The difference of the two normals in the tangent plane is, to first order, a
    symmetric matrix (the difference of the shape operators) times the offset
    from the contact. The sheet is the zero of its component along one
    eigenvector. Where the eigenvalue is negligible the normal returned by
    :meth:`project` is zero: no constraint.

    Attributes
    ----------
    first, second : the surfaces.
    sign : +1 if their own normals agree at the contact, -1 if they are opposed.
    is_steepest : whether to take the eigenvector of the larger eigenvalue (at a
        tangent join, the direction across) or the other one.
    min_rate : eigenvalues below this are negligible, 1 / spacing.
    """

    first: Surface
    second: Surface
    sign: int
    is_steepest: bool = True
    min_rate: float = _MIN_RATE

    def told_along(self, points: Array) -> Contact:
        """The same, negligible where it is far looser than at most of some points ``(n, 3)``.

        A cylinder and a torus that go on from it curve alike at the top of the round: there
        the least error of their normals moves the contact anywhere.
        """
        rates = np.abs(self.rates(points)[1][:, 1])
        return replace(self, min_rate=max(_MIN_RATE, _LOOSE * float(np.quantile(rates, 0.9))))

    def project(self, points: Array) -> tuple[Array, Array]:
        """Nearest points of the sheet, to first order, and its unit normals, ``(n, 3)``."""
        tilt, rates, directions = self.rates(points)
        choice = 1 if self.is_steepest else 0
        rate, across = rates[:, choice], directions[:, choice]
        is_known = np.abs(rate) > self.min_rate
        component = np.einsum("ni,ni->n", tilt, across)
        offset = np.where(is_known, -component / np.where(is_known, rate, 1.0), 0.0)
        return points + offset[:, None] * across, across * is_known[:, None]

    def rates(self, points: Array) -> tuple[Array, Array, Array]:
        """How fast the normals part.

        Returns
        -------
        tilt : difference of the normals, shape ``(n, 3)``.
        rates : eigenvalues of its derivative in the tangent plane, 1 / spacing,
            the smaller in magnitude first, shape ``(n, 2)``.
        directions : their unit eigenvectors, shape ``(n, 2, 3)``.
        """
        _, normals = self.first.project(points)
        helper = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
        x = unit(np.cross(normals, helper))
        frame = np.stack([x, np.cross(normals, x)], axis=1)
        steps = _DIFFERENCE * np.concatenate([np.zeros_like(frame[:, :1]), frame, -frame], axis=1)
        probes = (points[:, None] + steps).reshape(-1, 3)
        tilts = self.first.project(probes)[1] - self.sign * self.second.project(probes)[1]
        tilts = tilts.reshape(steps.shape)
        slopes = np.einsum("nij,nkj->nik", frame, tilts[:, 1:3] - tilts[:, 3:5])
        slopes /= 2.0 * _DIFFERENCE
        rates, vectors = np.linalg.eigh(0.5 * (slopes + np.swapaxes(slopes, 1, 2)))
        order = np.argsort(np.abs(rates), axis=1)
        rates = np.take_along_axis(rates, order, axis=1)
        vectors = np.take_along_axis(vectors, order[:, None], axis=2)
        return tilts[:, 0], rates, np.einsum("nji,njk->nik", vectors, frame)


@dataclass(frozen=True)
class Branch:
    """The point at which the intersection of two surfaces crosses itself.

    Equal cylinders whose axes meet are the usual case: they touch in two
    points, and their creases turn sharply there.

    Attributes
    ----------
    first, second, sign : as in :class:`Contact`.
    """

    first: Surface
    second: Surface
    sign: int

    @property
    def contacts(self) -> tuple[Contact, Contact]:
        """Constraints that, with the surfaces, hold the point."""
        steepest = Contact(self.first, self.second, self.sign)
        return steepest, replace(steepest, is_steepest=False)

    def near(self, starts: Array) -> tuple[Array, NDArray[np.bool_]]:
        """Branch points near start values ``(n, 3)``, and for which of them there is one."""
        surfaces = (self.first, self.second)
        points, _ = intersect(starts, [*surfaces, *self.contacts])
        tilt, rates, _ = self.contacts[0].rates(points)
        is_saddle = (rates[:, 0] * rates[:, 1] < 0.0) & (np.abs(rates[:, 0]) > _MIN_RATE)
        touches = distance(points, surfaces) <= _MAX_BRANCH_GAP
        is_near = np.linalg.norm(points - starts, axis=1) <= MAX_MOVE
        has_converged = np.linalg.norm(tilt, axis=1) < _CONVERGED
        return points, np.asarray(is_saddle & touches & is_near & has_converged)


def branch_points(
    guide: Guide, surfaces: tuple[Surface, Surface], orientations: tuple[int, int]
) -> Array:
    """Points near a guide where the intersection of two surfaces crosses itself.

    Parameters
    ----------
    guide : where the border of the surfaces runs.
    surfaces, orientations : as in :class:`crispline.region.regionfit.RegionFit`.

    Returns
    -------
    Shape ``(k, 3)``, in the order of the guide; mostly empty.
    """
    crossing, _ = intersect(guide.points, surfaces)
    is_shallow = angles(crossing, surfaces, orientations) < _MAX_BRANCH_ANGLE
    if not is_shallow.any() or is_shallow.mean() > 0.5:
        return np.empty((0, 3))
    branch = Branch(*surfaces, orientations[0] * orientations[1])
    points, is_found = branch.near(guide.points[is_shallow])
    distinct: list[Array] = []
    for point in points[is_found]:
        if all(np.linalg.norm(point - other) > 1.0 for other in distinct):
            distinct.append(point)
    return np.array(distinct).reshape(-1, 3)
