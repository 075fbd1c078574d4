"""Regularities of a designed part: parallel, perpendicular, coaxial, of equal radius.

They are proposed where the fits nearly show them and accepted where the noise
explains the difference, see :class:`crispline.fit.constrained.Adjustment`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crispline.fit.constrained import Adjustment, Pair, differences
from crispline.surface import Cone, Cylinder, Plane, RevolvedSurface, Sphere, Surface, Torus
from crispline.surface.base import Array

MAX_ANGLE = np.radians(2.5)
"""Directions farther than this from a regular position are not tried."""
MAX_OFFSET = 0.5
"""Axes farther apart than this are not tried, spacings."""
MAX_RADIUS_SHARE = 0.05
"""Radii that differ by a larger share are not tried."""
MAX_RADIUS_DIFFERENCE = 0.5
"""Nor those that differ by more than this, spacings."""


@dataclass(frozen=True)
class Regularity:
    """Two surfaces in a regular position.

    Attributes
    ----------
    members : which two.
    kind : which position.
    reach : length over which directions are compared, spacings: a relation's
        values are shifts over it.
    """

    members: tuple[int, int]
    kind: Literal["parallel", "perpendicular", "coaxial", "equal radius"]
    reach: float = 1.0

    def at(self, first: Surface, second: Surface) -> Regularity:
        """The same: a regularity has no place."""
        return self

    def values(self, first: Surface, second: Surface) -> Array:
        """What is zero in the regular position, shape ``(k,)``; not all of them independent."""
        if self.kind == "equal radius":
            return np.array([_radius(first) - _radius(second)])
        (origin, axis), (other, other_axis) = _axis(first), _axis(second)
        if self.kind == "perpendicular":
            return np.array([self.reach * (axis @ other_axis)])
        turn = self.reach * np.cross(axis, other_axis)
        if self.kind == "parallel":
            return turn
        return np.concatenate([turn, np.cross(axis, other - origin)])

    def derivatives(self, pair: Pair, position: int) -> Array:
        """Of the values, by the parameters of one of the two surfaces, shape ``(k, p)``."""
        return differences(self, pair, position)


def regularize(adjustment: Adjustment, surfaces: Mapping[int, Surface], sizes: Array) -> int:
    """Propose every regularity that the surfaces nearly show.

    Parameters
    ----------
    adjustment : what decides; it remembers what it accepted.
    surfaces : by the names that the adjustment knows them by.
    sizes : extent of each in the same order, spacings; larger surfaces lead.

    Returns
    -------
    Number of regularities accepted.
    """
    reach = dict(zip(surfaces, sizes.tolist(), strict=True))
    leading = sorted(surfaces, key=lambda name: (-reach[name], name))
    families = _families(adjustment, surfaces, reach, leading)
    accepted = sum(len(family) - 1 for family in families)
    for family in families:
        accepted += _coaxial(adjustment, surfaces, reach, family)
    return accepted + _equal_radii(adjustment, surfaces, leading)


def _families(
    adjustment: Adjustment,
    surfaces: Mapping[int, Surface],
    reach: Mapping[int, float],
    leading: list[int],
) -> list[list[int]]:
    """Names of parallel surfaces; the first of each family leads."""
    families: list[list[int]] = []
    for name in leading:
        if isinstance(surfaces[name], Sphere):
            continue
        axis = _axis(surfaces[name])[1]
        cosines = [abs(float(axis @ _axis(surfaces[family[0]])[1])) for family in families]
        joined = False
        for index in np.argsort(-np.array(cosines), kind="stable").tolist():
            if cosines[index] < np.cos(MAX_ANGLE) or joined:
                break
            pair = (families[index][0], name)
            joined = adjustment.propose(Regularity(pair, "parallel", reach[name]))
            if joined:
                families[index].append(name)
        if joined:
            continue
        for family, cosine in zip(families, cosines, strict=True):
            if cosine < np.sin(MAX_ANGLE):
                pair = (family[0], name)
                adjustment.propose(Regularity(pair, "perpendicular", reach[name]))
        families.append([name])
    return families


def _coaxial(
    adjustment: Adjustment,
    surfaces: Mapping[int, Surface],
    reach: Mapping[int, float],
    family: list[int],
) -> int:
    """Try every round surface of a family on the axes of larger ones."""
    axes: list[int] = []
    accepted = 0
    for name in family:
        if isinstance(surfaces[name], Plane):
            continue
        origin, _ = _axis(surfaces[name])
        for leader in axes:
            place, axis = _axis(surfaces[leader])
            offset = origin - place
            if np.linalg.norm(offset - (offset @ axis) * axis) > MAX_OFFSET:
                continue
            if adjustment.propose(Regularity((leader, name), "coaxial", reach[name])):
                accepted += 1
                break
        else:
            axes.append(name)
    return accepted


def _equal_radii(
    adjustment: Adjustment, surfaces: Mapping[int, Surface], leading: list[int]
) -> int:
    """Try every radius on those of larger surfaces of its kind, the nearest first."""
    leaders: dict[str, list[int]] = {}
    accepted = 0
    for name in leading:
        surface = surfaces[name]
        if not isinstance(surface, (Cylinder, Sphere, Torus)):
            continue
        known = leaders.setdefault(surface.kind, [])
        radius = _radius(surface)
        for other in sorted(known, key=lambda o: (abs(_radius(surfaces[o]) - radius), o)):
            difference = abs(_radius(surfaces[other]) - radius)
            if difference > min(MAX_RADIUS_DIFFERENCE, MAX_RADIUS_SHARE * radius):
                known.append(name)
                break
            if adjustment.propose(Regularity((other, name), "equal radius")):
                accepted += 1
                break
        else:
            known.append(name)
    return accepted


def _axis(surface: Surface) -> tuple[Array, Array]:
    """A point on the axis and its unit direction; for a plane its normal."""
    match surface:
        case Plane():
            return surface.origin, surface.normal
        case Cylinder() | RevolvedSurface():
            return surface.origin, surface.axis
        case Cone():
            return surface.apex, surface.axis
        case Torus():
            return surface.centre, surface.axis
    raise TypeError(f"a {surface.kind} has no axis")


def _radius(surface: Surface) -> float:
    match surface:
        case Cylinder() | Sphere():
            return surface.radius
        case Torus():
            return surface.minor_radius
    raise TypeError(f"a {surface.kind} has no radius")
