"""A bent tube through noisy points: straight, round an arc, and straight again.

Where a straight piece is short the whole tube is a torus to within little more than the noise,
and the torus leans to it. All pieces together have two unknowns more than the torus: where the
arc begins and where it ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from crispline.fit.robust import DistanceModel, fit_distances
from crispline.surface import Cylinder, Torus, unit
from crispline.surface.base import Array

_TRIMS = (0.0, 0.1, 0.25)
"""Shares of the extent of the points along the arc by which a start value shortens it."""
_MAX_ARC = np.radians(350.0)


@dataclass(frozen=True)
class Bend:
    """A torus from one angle to another, and the cylinders that go on from there.

    Attributes
    ----------
    torus : of the arc.
    middle : unit vector across the axis of the torus from which angles count, shape ``(3,)``.
    first, last : angles about the axis at which the arc begins and ends, radians.
    """

    torus: Torus
    middle: Array
    first: float
    last: float

    @property
    def limits(self) -> tuple[float, float]:
        """The angles at which the arc begins and ends, radians."""
        return self.first, self.last

    def angles(self, points: Array) -> Array:
        """Of points ``(n, 3)`` about the axis of the torus, from -pi to pi, shape ``(n,)``."""
        offset = points - self.torus.centre
        return np.asarray(
            np.arctan2(offset @ np.cross(self.torus.axis, self.middle), offset @ self.middle)
        )

    def outward(self, angles: Array) -> Array:
        """Unit vectors from the axis at angles ``(n,)``, shape ``(n, 3)``."""
        beside = np.cross(self.torus.axis, self.middle)
        return np.asarray(np.cos(angles)[:, None] * self.middle + np.sin(angles)[:, None] * beside)

    def straight(self, side: int) -> Cylinder:
        """The cylinder at the beginning (0) or the end (1) of the arc; its axis leads away."""
        outward = self.outward(np.array([self.limits[side]]))[0]
        along = np.cross(self.torus.axis, outward) * (-1.0, 1.0)[side]
        origin = self.torus.centre + self.torus.major_radius * outward
        return Cylinder(origin, along, self.torus.minor_radius)

    def is_on_straight(self, points: Array, side: int) -> NDArray[np.bool_]:
        """Which of the points ``(n, 3)`` are beyond the beginning (0) or the end (1) of the arc.

        On the far side of the torus there is neither.
        """
        straight = self.straight(side)
        beyond = (points - straight.origin) @ straight.axis
        angle = self.angles(points)
        past = self.first - angle if side == 0 else angle - self.last
        return np.asarray((beyond > 0.0) & (past > 0.0))


def fit_bend(points: Array, sigma: float, torus: Torus) -> Bend | None:
    """Robust orthogonal-distance bend.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    sigma : noise along the normal, spacings.
    torus : start value.

    Returns
    -------
    The bend; None if the points go all round the axis of the torus, or no arc is left.
    """
    offset = points - torus.centre
    across = unit(offset - np.outer(offset @ torus.axis, torus.axis))
    mean = across.mean(axis=0)
    if not np.linalg.norm(mean) > 0.0:
        return None
    about = Bend(torus, unit(mean - (mean @ torus.axis) * torus.axis), 0.0, 0.0)
    angle = np.sort(about.angles(points))
    if angle[-1] - angle[0] > _MAX_ARC:
        return None
    bend = fit_distances(MODEL, _starts(about, angle[0], angle[-1]), points, sigma)
    if bend is None or not 0.0 < bend.torus.minor_radius < bend.torus.major_radius:
        return None
    return bend if bend.first < bend.last else None


def _starts(about: Bend, lowest: float, highest: float) -> Iterator[Bend]:
    extent = highest - lowest
    for first, last in product(_TRIMS, _TRIMS):
        yield replace(about, first=lowest + first * extent, last=highest - last * extent)


def linearise(bend: Bend, points: Array) -> tuple[Array, Array]:
    """Signed distances; derivatives by shifts, tilts, both radii, first and last ``(n, 9)``."""
    torus = bend.torus
    angle = bend.angles(points)
    offset = points - torus.centre
    nearest = np.clip(angle, bend.first, bend.last)
    outward = bend.outward(nearest)
    along = np.cross(torus.axis, outward)
    beyond = np.where(angle == nearest, 0.0, np.einsum("ij,ij->i", offset, along))
    spine = torus.major_radius * outward + beyond[:, None] * along
    normal = offset - spine
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0.0, length, 1.0)[:, None]
    turn = np.cross(spine, normal)
    swing = beyond * np.einsum("ij,ij->i", normal, outward)
    frame = _frame(bend)
    jacobian = np.empty((len(points), 9))
    jacobian[:, :3] = -normal @ frame.T
    jacobian[:, 3:5] = -turn @ frame[:2].T
    jacobian[:, 5] = -np.einsum("ij,ij->i", normal, outward)
    jacobian[:, 6] = -1.0
    jacobian[:, 7] = np.where(angle < bend.first, swing, 0.0)
    jacobian[:, 8] = np.where(angle > bend.last, swing, 0.0)
    return length - torus.minor_radius, jacobian


def move(bend: Bend, step: Array) -> Bend:
    """Shift, turn about the centre, change both radii and where the arc begins and ends."""
    frame, torus = _frame(bend), bend.torus
    turn = step[3:5] @ frame[:2]
    axis = unit(torus.axis + np.cross(turn, torus.axis))
    middle = bend.middle + np.cross(turn, bend.middle)
    moved = Torus(
        torus.centre + step[:3] @ frame,
        axis,
        torus.major_radius + float(step[5]),
        torus.minor_radius + float(step[6]),
    )
    middle = unit(middle - (middle @ axis) * axis)
    return Bend(moved, middle, bend.first + float(step[7]), bend.last + float(step[8]))


def _frame(bend: Bend) -> Array:
    """Rows: the middle, across it, the axis."""
    axis = bend.torus.axis
    return np.stack([bend.middle, np.cross(axis, bend.middle), axis])


MODEL = DistanceModel(linearise, move)
