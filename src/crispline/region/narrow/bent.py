"""The edge of two faces along one direction of which one is round, seen along it.

Heights above a plane and a cylinder along it are no affine coordinates across their edge, as
they are for two planes; but in the plane across it they are a line and a circle, or two circles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from crispline.fit.contact import crossing, offset, outward
from crispline.fit.swept import Profile, Sweep, Translation
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane, Surface
from crispline.surface.base import Array

Mask = NDArray[np.bool_]

_STRAIGHT = 1e-6  # sine of an arc that is half a circle, or none


@dataclass(frozen=True)
class Outline:
    """Two curves that meet at an angle.

    Attributes
    ----------
    profiles : of the two faces.
    orientation : 1 where the outside is where a line's normal or a circle's radius goes, else -1.
    corner : where they meet, shape ``(2,)``.
    """

    profiles: tuple[Profile, Profile]
    orientation: tuple[float, float]
    corner: Array

    @classmethod
    def near(
        cls, profiles: tuple[Profile, Profile], orientation: tuple[float, float], place: Array
    ) -> Outline | None:
        """With the corner nearest to a place; None where they do not meet."""
        corner = crossing(*profiles, place)
        return None if corner is None else cls(profiles, orientation, corner)

    @property
    def cosine(self) -> float:
        """Of the angle between the outward normals at the corner."""
        first, second = (
            sign * outward(profile, self.corner)
            for profile, sign in zip(self.profiles, self.orientation, strict=True)
        )
        return float(first @ second)

    def centre(self, height: float) -> Array | None:
        """The place so high above both, shape ``(2,)``; None if there is none."""
        first, second = (
            offset(profile, sign * height)
            for profile, sign in zip(self.profiles, self.orientation, strict=True)
        )
        if first is None or second is None:
            return None
        return crossing(first, second, self.corner)

    def from_ball(self, flat: Array, height: float) -> tuple[Array, Mask] | None:
        """Distances of points ``(n, 2)`` from the ball that touches both, and which are on its arc.

        The height is the centre's above both faces; the arc is between the places where the ball
        touches them.
        """
        centre = self.centre(height)
        if centre is None:
            return None
        touches = np.stack(
            [
                -np.sign(height) * sign * outward(profile, centre)
                for profile, sign in zip(self.profiles, self.orientation, strict=True)
            ]
        )
        if abs(np.linalg.det(touches)) < _STRAIGHT:
            return None
        away = flat - centre
        on_arc = np.linalg.solve(touches.T, away.T).min(axis=0) > 0.0
        return np.linalg.norm(away, axis=1) - abs(height), np.asarray(on_arc)


def is_bent(sweep: Sweep, sides: Sequence[RegionFit]) -> TypeGuard[Translation]:
    """Whether one of two faces that are swept straight is round."""
    is_straight = isinstance(sweep, Translation)
    return is_straight and any(isinstance(side.surface, Cylinder) for side in sides)


def next_to(points: Array, own: Mask, sweep: Translation) -> Mask:
    """Which points are no farther along the sweep than their own ones.

    A cylinder goes on past the end of a plane, and is not beside it there.
    """
    along = points @ sweep.direction
    return np.asarray((along >= along[own].min()) & (along <= along[own].max()))


def _profile(surface: Surface, sweep: Translation) -> Profile:
    assert isinstance(surface, Plane | Cylinder)
    return sweep.profile(surface)


def outline_of(sweep: Translation, sides: Sequence[RegionFit], points: Array) -> Outline | None:
    """Of two faces swept straight, where they meet near the points; None if they do not."""
    first, second = sides
    place = np.median(sweep.flattened(points), axis=0)
    return Outline.near(
        (_profile(first.surface, sweep), _profile(second.surface, sweep)),
        (first.orientation, second.orientation),
        place,
    )
