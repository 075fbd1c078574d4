"""Fitted primitives adjusted to each other: relations that hold exactly, at the least cost.

Each fit is replaced by what its points know of it, the quadratic form by which
the chi-square rises when its parameters move. In coordinates in which that form
is the squared length, the least change that meets a set of relations is a
minimum-norm solution, and each relation has its price: the rise of the
chi-square that it adds to those accepted before.

References: Benko, Kos, Varady, Andor and Martin (2002), Constrained fitting in
reverse engineering; Bjorck (1996), Numerical methods for least squares problems,
section 5.1.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from scipy.linalg import solve_triangular
from scipy.stats import chi2

from crispline.fit import cone, cylinder, plane, rigid, sphere, torus
from crispline.fit.robust import DistanceModel, tukey_weights
from crispline.surface import Cone, Cylinder, Sphere, Surface, Torus
from crispline.surface.base import Array

_DIFFERENCE = 1e-4
_KNOWN = 1e-3  # what is known this well is no longer free, in the units of the relation
_INCONSISTENT = 0.03
_CONFIDENCE = 0.999
_VARIANCE_FACTOR = 2.0
"""Residuals of neighbouring points and of badly cut borders are not independent: the rise of
the chi-square that noise explains is taken this many times larger."""
_MAX_NEWTON_STEPS = 12
_CONVERGED = 1e-8

MODELS: Mapping[str, DistanceModel[Any]] = {
    "plane": plane.MODEL,
    "cylinder": cylinder.MODEL,
    "sphere": sphere.MODEL,
    "cone": cone.MODEL,
    "torus": torus.MODEL,
    "revolution": rigid.MODEL,
}

System = tuple[Array, Array]
"""Values of equations ``(k,)`` and their derivatives by all whitened parameters ``(k, P)``."""


class Relation(Protocol):
    """Equations between two surfaces."""

    @property
    def members(self) -> tuple[int, int]:
        """Which two."""

    def at(self, first: Surface, second: Surface) -> Relation:
        """The relation for surfaces that have moved a little; it may carry places on them."""

    def values(self, first: Surface, second: Surface) -> Array:
        """What is zero where the relation holds, shape ``(k,)``, in spacings or the like."""

    def derivatives(self, pair: Pair, position: int) -> Array:
        """Of the values, by the parameters of one of the two surfaces, shape ``(k, p)``."""


@dataclass(frozen=True)
class Estimate:
    """A primitive and how firmly its points hold it.

    Attributes
    ----------
    kind : of surface.
    shape : the primitive in the parameters of its fit.
    factor : upper triangular, shape ``(p, p)``; a step ``s`` of the parameters
        raises the chi-square by ``|factor s|^2``.
    """

    kind: str
    shape: Any
    factor: Array

    @property
    def surface(self) -> Surface:
        """The primitive."""
        found: Surface = cone.as_cone(self.shape) if self.kind == "cone" else self.shape
        return found

    def moved(self, step: Array) -> Estimate:
        """After a step ``(p,)`` of the parameters."""
        return replace(self, shape=MODELS[self.kind].move(self.shape, step))

    def distance_derivatives(self, points: Array) -> Array:
        """Of the signed distances of points ``(n, 3)``, by the parameters, shape ``(n, p)``."""
        derivatives: Array = MODELS[self.kind].linearise(self.shape, points)[1]
        return derivatives


Pair = tuple[Estimate, Estimate]


def estimate(surface: Surface, points: Array, sigma: float) -> Estimate | None:
    """What points ``(n, 3)`` with noise ``sigma`` know of the primitive fitted to them.

    None for a B-spline, or where the points leave a parameter open.
    """
    if surface.kind not in MODELS:
        return None
    shape: Any = surface
    if isinstance(surface, Cone):
        shape = cone.frustum_beside(surface, points)
    residuals, jacobian = MODELS[surface.kind].linearise(shape, points)
    if len(residuals) <= jacobian.shape[1]:
        return None
    roots = np.sqrt(tukey_weights(residuals, sigma)) / (np.sqrt(_VARIANCE_FACTOR) * sigma)
    factor = np.asarray(np.linalg.qr(jacobian * roots[:, None], mode="r"))
    diagonal = np.abs(np.diag(factor))
    if not np.isfinite(factor).all() or diagonal.min() <= 1e-12 * diagonal.max():
        return None
    return Estimate(surface.kind, shape, factor)


def is_proper(surface: Surface, given: Surface) -> bool:
    """Whether a surface is what its kind says: no cone as flat as a plane, no radius below zero.

    A torus may cross its own axis, as a round does in a tight corner, only if it did so where it
    was ``given``.
    """
    match surface:
        case Cone():
            return bool(cone.MIN_HALF_ANGLE <= surface.half_angle <= cone.MAX_HALF_ANGLE)
        case Cylinder() | Sphere():
            return surface.radius > 0.0
        case Torus():
            is_spindle = isinstance(given, Torus) and given.major_radius <= given.minor_radius
            least = 0.0 if is_spindle else surface.minor_radius
            return surface.minor_radius > 0.0 and surface.major_radius > least
    return True


class Adjustment:
    """Estimates and the relations accepted between them so far.

    Parameters
    ----------
    estimates : by the numbers that relations call their members.
    """

    def __init__(self, estimates: Mapping[int, Estimate]) -> None:
        self._estimates = dict(estimates)
        sizes = [len(e.factor) for e in self._estimates.values()]
        ends = np.cumsum(sizes)
        self._places = {
            name: slice(int(end - size), int(end))
            for name, end, size in zip(self._estimates, ends, sizes, strict=True)
        }
        self._n_parameters = int(sum(sizes))
        self._accepted: list[tuple[Relation, System]] = []  # linearised at the estimates
        self._rows = np.empty((0, self._n_parameters))  # orthonormal
        self._solution = np.zeros(self._n_parameters)

    @property
    def relations(self) -> tuple[Relation, ...]:
        """Those accepted."""
        return tuple(relation for relation, _ in self._accepted)

    def propose(self, relation: Relation) -> bool:
        """Accept a relation if noise explains what it costs on top of those accepted before."""
        values, rows = system = self._linearised(relation, self._estimates)
        if not (np.isfinite(values).all() and np.isfinite(rows).all()):
            return False
        values = values + rows @ self._solution
        for _ in range(2):  # twice is enough for orthogonality to rounding
            rows = rows - (rows @ self._rows.T) @ self._rows
        left, lengths, right = np.linalg.svd(rows, full_matrices=False)
        amounts = left.T @ values
        is_free = lengths > _KNOWN
        if np.abs(amounts[~is_free]).max(initial=0.0) > _INCONSISTENT:
            return False
        steps = -amounts[is_free] / lengths[is_free]
        if len(steps):
            if float(steps @ steps) > chi2.ppf(_CONFIDENCE, len(steps)):
                return False
            self._solution = self._solution + steps @ right[is_free]
            self._rows = np.vstack([self._rows, right[is_free]])
        self._accepted.append((relation, _independent(*system)))
        return True

    def forget(self, name: int) -> None:
        """Give up all relations of one surface."""
        self._accepted = [pair for pair in self._accepted if name not in pair[0].members]

    def solved(self) -> dict[int, Surface]:
        """The surfaces that meet all accepted relations, by Newton's method.

        Only of members of a relation. Relations that contradict each other by less
        than is known of the surfaces are met in the mean. Ends with the first step that
        leaves a surface improper: one that its points hold so loosely takes all others
        with it if it goes on.
        """
        estimates = dict(self._estimates)
        touched = sorted({name for relation in self.relations for name in relation.members})
        systems = [system for _, system in self._accepted]
        for count in range(_MAX_NEWTON_STEPS if systems else 0):
            if count:
                systems = [
                    _independent(*self._linearised(relation, estimates))
                    for relation in self.relations
                ]
            values = np.concatenate([value for value, _ in systems])
            rows = np.vstack([row for _, row in systems])
            if not np.isfinite(rows).all():
                break
            left, lengths, right = np.linalg.svd(rows, full_matrices=False)
            is_free = lengths > _KNOWN
            step = -right[is_free].T @ ((left.T @ values)[is_free] / lengths[is_free])
            for name in touched:
                estimates[name] = estimates[name].moved(self._unwhitened(name, step))
            is_at_rest = np.linalg.norm(step) < _CONVERGED * np.sqrt(self._n_parameters)
            is_sound = all(
                is_proper(estimates[name].surface, self._estimates[name].surface)
                for name in touched
            )
            if is_at_rest or not is_sound:
                break
        return {name: estimates[name].surface for name in touched}

    def _unwhitened(self, name: int, step: Array) -> Array:
        return np.asarray(solve_triangular(self._estimates[name].factor, step[self._places[name]]))

    def _linearised(self, relation: Relation, estimates: Mapping[int, Estimate]) -> System:
        """Values ``(k,)`` and their derivatives by all whitened parameters, shape ``(k, P)``."""
        first, second = relation.members
        pair = estimates[first], estimates[second]
        relation = relation.at(pair[0].surface, pair[1].surface)
        values = relation.values(pair[0].surface, pair[1].surface)
        rows = np.zeros((len(values), self._n_parameters))
        for position, name in enumerate(relation.members):
            columns = relation.derivatives(pair, position)
            rows[:, self._places[name]] = solve_triangular(
                estimates[name].factor, columns.T, trans="T"
            ).T
        return values, rows


def _independent(values: Array, rows: Array) -> System:
    """As many equations as are independent, in place of those of one relation."""
    if not np.isfinite(rows).all():
        return values, rows
    left, lengths, right = np.linalg.svd(rows, full_matrices=False)
    is_free = lengths > _KNOWN
    return (left.T @ values)[is_free], lengths[is_free, None] * right[is_free]


def differences(relation: Relation, pair: Pair, position: int) -> Array:
    """Central differences of a relation's values by the parameters of one member, ``(k, p)``."""
    columns = []
    for step in _DIFFERENCE * np.eye(len(pair[position].factor)):
        ends = []
        for sign in (1.0, -1.0):
            surfaces = [member.surface for member in pair]
            surfaces[position] = pair[position].moved(sign * step).surface
            ends.append(relation.values(surfaces[0], surfaces[1]))
        columns.append((ends[0] - ends[1]) / (2.0 * _DIFFERENCE))
    return np.column_stack(columns)
