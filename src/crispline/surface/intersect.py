"""Newton's method for points common to several surfaces.

A step solves the linearised distances in the least-squares sense and is the
shortest that does, so that a point lands on two surfaces close to where it
started, and on surfaces without a common point between them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from crispline.surface import Surface
from crispline.surface.base import Array

CUTOFF = 0.03
"""Singular values below this fraction of the largest count as zero.

Two surfaces that meet at less than about 3.5 degrees are then met in their mean,
instead of far away where their tangent planes cross.
"""
_MAX_STEPS = 40
_MAX_STEP = 2.0
_CONVERGED = 1e-10


class Constraint(Protocol):
    """Anything with nearest points: a surface, or where two have the same normal."""

    def project(self, points: Array) -> tuple[Array, Array]:
        """Feet and unit normals, both ``(n, 3)``; a zero normal constrains nothing."""


def intersect(points: Array, constraints: Sequence[Constraint]) -> tuple[Array, Array]:
    """Move points to the nearest common points of the constraints.

    Parameters
    ----------
    points : start values, spacings, shape ``(n, 3)``.
    constraints : one or more.

    Returns
    -------
    located : shape ``(n, 3)``.
    gap : largest distance of each located point to its constraints, shape
        ``(n,)``; not small where they have no common point nearby.
    """
    located = np.array(points, dtype=np.float64)
    active = np.arange(len(located))
    for _ in range(_MAX_STEPS):
        if not active.size:
            break
        step = newton_step(located[active], constraints)
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, _MAX_STEP / np.maximum(length, _MAX_STEP))[:, None]
        located[active] += step
        active = active[length > _CONVERGED]
    return located, distance(located, constraints)


def newton_step(points: Array, constraints: Sequence[Constraint]) -> Array:
    """The shortest step to where the constraints' tangent planes meet, shape ``(n, 3)``.

    Its length is, to first order, the distance to the common points.
    """
    normals, distances = equations(points, constraints)
    return np.asarray(np.einsum("nij,nj->ni", np.linalg.pinv(normals, rcond=CUTOFF), distances))


def damped_intersect(
    point: Array, constraints: Sequence[Constraint], weight: float
) -> tuple[Array, float]:
    """A compromise between the constraints and staying where the point is.

    Minimises the squared distances to all constraints plus ``weight**2`` times
    the squared distance to ``point``, shape ``(3,)``. Returns the minimiser and
    its largest distance to the constraints.
    """
    located = np.array(point, dtype=np.float64)
    for _ in range(_MAX_STEPS):
        normals, distances = equations(located[None], constraints)
        rows = np.vstack([normals[0], weight * np.eye(3)])
        values = np.concatenate([distances[0], weight * (point - located)])
        step = np.linalg.lstsq(rows, values, rcond=None)[0]
        length = float(np.linalg.norm(step))
        located += step * min(1.0, _MAX_STEP / max(length, _MAX_STEP))
        if length < _CONVERGED:
            break
    return located, float(distance(located[None], constraints)[0])


def equations(points: Array, constraints: Sequence[Constraint]) -> tuple[Array, Array]:
    """Normals ``(n, k, 3)`` and the distances along them to the feet ``(n, k)``."""
    pairs = [constraint.project(points) for constraint in constraints]
    normals = np.stack([normal for _, normal in pairs], axis=1)
    offsets = np.stack([feet - points for feet, _ in pairs], axis=1)
    return normals, np.einsum("nki,nki->nk", offsets, normals)


def distance(points: Array, constraints: Sequence[Constraint]) -> Array:
    """Largest distance of each point to the constraints, shape ``(n,)``."""
    feet = [constraint.project(points)[0] for constraint in constraints]
    return np.asarray(np.max([np.linalg.norm(foot - points, axis=1) for foot in feet], axis=0))


def tangents(points: Array, constraints: Sequence[Constraint]) -> tuple[Array, Array]:
    """Direction in which points may move without leaving the constraints.

    Returns
    -------
    tangents : unit vectors of arbitrary sign, shape ``(n, 3)``.
    strength : second singular value of the normals, shape ``(n,)``; near zero
        where the constraints touch and no direction is distinguished.
    """
    normals, _ = equations(points, constraints)
    # The Gram matrix squares the singular values but not the directions.
    values, vectors = np.linalg.eigh(np.einsum("nki,nkj->nij", normals, normals))
    return vectors[:, :, 0], np.sqrt(np.maximum(values[:, 1], 0.0))


def angles(points: Array, surfaces: Sequence[Surface], orientations: Sequence[int]) -> Array:
    """Angle between the outward normals of two surfaces, radians, shape ``(n,)``."""
    first, second = (
        orientation * surface.project(points)[1]
        for surface, orientation in zip(surfaces, orientations, strict=True)
    )
    # atan2 keeps its digits near 0, where arccos loses half of them.
    sine = np.linalg.norm(np.cross(first, second), axis=1)
    return np.asarray(np.arctan2(sine, np.einsum("ij,ij->i", first, second)))
