"""Where a circle touches two curves of a plane, each a line or a circle.

Its centre is as far from both, so it lies where their offset curves cross.
"""

from __future__ import annotations

import numpy as np

from crispline.fit.swept import Circle, Line, Profile
from crispline.surface.base import Array

_PARALLEL = 1e-9  # sine between lines, or distance of centres over a radius


def crossing(first: Profile, second: Profile, near: Array) -> Array | None:
    """The common point of two profiles nearest to ``near``, shape ``(2,)``; None without one."""
    if isinstance(first, Line):
        if isinstance(second, Line):
            rows = np.stack([first.normal, second.normal])
            if abs(np.linalg.det(rows)) < _PARALLEL:
                return None
            return np.asarray(np.linalg.solve(rows, [first.offset, second.offset]))
        return _on_circle(second, first.normal, first.offset, near)
    if isinstance(second, Line):
        return _on_circle(first, second.normal, second.offset, near)
    # The points that two circles share are on the line on which both have the same power.
    apart = second.centre - first.centre
    length = float(np.linalg.norm(apart))
    if length < _PARALLEL * first.radius:
        return None
    along = 0.5 * (length + (first.radius**2 - second.radius**2) / length)
    normal = apart / length
    return _on_circle(first, normal, float(normal @ first.centre) + along, near)


def offset(profile: Profile, distance: float) -> Profile | None:
    """The parallel curve at a signed distance, out of a circle; None for a circle that is gone."""
    if isinstance(profile, Line):
        return Line(profile.angle, profile.offset + distance)
    if profile.radius + distance <= 0.0:
        return None
    return Circle(profile.centre, profile.radius + distance)


def outward(profile: Profile, point: Array) -> Array:
    """The unit normal of a profile at a point, away from the centre of a circle, shape ``(2,)``."""
    if isinstance(profile, Line):
        return profile.normal
    away = point - profile.centre
    return np.asarray(away / np.linalg.norm(away))


def _on_circle(circle: Circle, normal: Array, level: float, near: Array) -> Array | None:
    """The point of a circle on the line ``p . normal = level``."""
    height = level - float(normal @ circle.centre)
    squared = circle.radius**2 - height**2
    if squared < 0.0:
        return None
    along = np.array([-normal[1], normal[0]])
    side = 1.0 if along @ (near - circle.centre) > 0.0 else -1.0
    return np.asarray(circle.centre + height * normal + side * np.sqrt(squared) * along)
