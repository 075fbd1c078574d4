"""A surface as a set of bicubic Bezier patches: its points, areas, and exact distances to it.

Every patch is a polynomial of its own, so nothing is smeared over a crease: on either side
of it stands another patch, and both end in it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.spline.tensor import CUBIC, TensorSpline
from crispline.surface.base import Array

_BINOMIAL = np.array([1.0, 3.0, 3.0, 1.0])
_POWER = np.arange(4.0)

_N_STARTS = 5
"""Start points per patch and direction in the search for the nearest point."""
_N_NEAREST = 64
"""Nearest start points of which every distinct patch is searched."""
_MAX_STEPS = 60
_STILL = 1e-11
"""Newton's method ends when no parameter moves by more than this ..."""
_ROUNDING = 1e-7
"""... or when even so short a step gains nothing but rounding."""


@dataclass(frozen=True, eq=False)
class Patches:
    """Bicubic Bezier patches over the unit square.

    Attributes
    ----------
    control_points : shape ``(m, 4, 4, 3)``, ``u`` along axis 1.
    """

    control_points: Array

    def evaluate(
        self, index: NDArray[np.intp], u: Array, v: Array, du: int = 0, dv: int = 0
    ) -> Array:
        """Points of patches ``index`` at parameters ``u``, ``v``, or derivatives, ``(k, 3)``."""
        points = self.control_points[index]
        return np.asarray(np.einsum("ka,kb,kabd->kd", _bernstein(u, du), _bernstein(v, dv), points))

    def lattice(self, n: int, *, with_borders: bool) -> tuple[NDArray[np.intp], Array, Array]:
        """Patch, ``u`` and ``v`` of ``n x n`` parameters in every patch, each ``(m n^2,)``."""
        ticks = np.linspace(0.0, 1.0, n) if with_borders else (np.arange(n) + 0.5) / n
        u, v = np.meshgrid(ticks, ticks, indexing="ij")
        m = len(self.control_points)
        index = np.repeat(np.arange(m), n * n)
        return index, np.tile(u.ravel(), m), np.tile(v.ravel(), m)

    def samples(self, n: int) -> tuple[Array, Array]:
        """Points in the middle of ``n x n`` cells of every patch, and the cells' areas.

        Returns
        -------
        points : shape ``(m n^2, 3)``.
        areas : shape ``(m n^2,)``.
        """
        at = self.lattice(n, with_borders=False)
        normal = np.cross(self.evaluate(*at, du=1), self.evaluate(*at, dv=1))
        return self.evaluate(*at), np.linalg.norm(normal, axis=1) / n**2

    def distances(self, points: Array) -> Array:
        """Exact distances of points, shape ``(k, 3)``, to the surface, shape ``(k,)``.

        Start points on all patches are searched for the nearest ones; from the nearest
        of every patch that can hold the foot, Newton's method minimises the distance
        over the closed unit square, so a foot may lie on a crease or a corner.
        """
        starts = self.lattice(_N_STARTS, with_borders=True)
        tree = cKDTree(self.evaluate(*starts))
        n_nearest = min(_N_NEAREST, len(starts[0]))
        found = tree.query(points, n_nearest)
        away, near = np.ravel(found[0]), np.ravel(found[1])
        query = np.repeat(np.arange(len(points)), n_nearest)
        pair = query * len(self.control_points) + starts[0][near]
        first = np.unique(pair, return_index=True)[1]  # the nearest start of every patch
        slack = self._gap()[starts[0][near[first]]]
        first = first[away[first] - slack <= away[query[first] * n_nearest]]
        query, start = query[first], near[first]
        index, u, v = starts
        reached = _descend(self, points[query], index[start], u[start], v[start])
        nearest = np.full(len(points), np.inf)
        np.minimum.at(nearest, query, reached)
        return nearest

    def _gap(self) -> Array:
        """Bound of the distance from any point of each patch to a start point, ``(m,)``.

        A cubic moves by at most three times the longest leg of its control polygon per
        unit of parameter, and half a step between starts away there is a start.
        """
        legs = [
            np.linalg.norm(np.diff(self.control_points, axis=axis), axis=3).max(axis=(1, 2))
            for axis in (1, 2)
        ]
        return np.asarray(CUBIC * (legs[0] + legs[1]) / (2.0 * (_N_STARTS - 1)))


def spline_patches(spline: TensorSpline) -> Patches:
    """The non-empty spans of a polynomial bicubic B-spline surface that have no NaN in them.

    The polynomial of a span is found from 4 x 4 points inside it, so at a multiple knot
    either side keeps its own.
    """
    inside = np.asarray((np.arange(4.0) + 0.5) / 4.0, dtype=np.float64)
    u, v = (
        _span_parameters(knots, degree, inside)
        for knots, degree in (
            (spline.knots_u, spline.degree_u),
            (spline.knots_v, spline.degree_v),
        )
    )
    n_u, n_v = len(u), len(v)
    grid_u, grid_v = np.meshgrid(u.ravel(), v.ravel(), indexing="ij")
    values = spline.evaluate(grid_u.ravel(), grid_v.ravel())
    values = values.reshape(n_u, 4, n_v, 4, 3).transpose(0, 2, 1, 3, 4).reshape(-1, 4, 4, 3)
    values = values[np.isfinite(values).all(axis=(1, 2, 3))]
    to_bezier = np.linalg.inv(_bernstein(inside, 0))
    return Patches(np.einsum("ia,jb,mabd->mijd", to_bezier, to_bezier, values))


def _span_parameters(knots: Array, degree: int, inside: Array) -> Array:
    """Parameters at shares ``inside`` of every non-empty span of the domain, ``(n, 4)``."""
    domain = knots[degree : len(knots) - degree]
    start, end = domain[:-1], domain[1:]
    is_span = end > start
    return np.asarray(start[is_span, None] + inside * (end - start)[is_span, None])


def _bernstein(t: Array, derivative: int) -> Array:
    """The four cubic Bernstein polynomials or a derivative up to the second, ``(k, 4)``."""
    t = t[:, None]
    if derivative == 0:
        return np.asarray(_BINOMIAL * t**_POWER * (1.0 - t) ** (CUBIC - _POWER))
    s = 1.0 - t
    if derivative == 1:
        columns = [-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t]
    else:
        columns = [6 * s, 6 * t - 12 * s, 6 * s - 12 * t, 6 * t]
    return np.concatenate(columns, axis=1)


def _descend(
    patches: Patches, targets: Array, index: NDArray[np.intp], u: Array, v: Array
) -> Array:
    """Distances of targets ``(k, 3)`` to one patch each, by Newton's method in the unit square.

    A parameter at a bound stays there while the distance falls beyond it. Where the
    second derivatives do not promise a minimum, Gauss-Newton steps are taken; a step
    that would go up is halved.
    """
    place = np.column_stack([u, v])
    size = np.ones(len(place))
    active = np.arange(len(place))
    gap = patches.evaluate(index, u, v) - targets
    value = np.einsum("kd,kd->k", gap, gap)
    step = np.zeros_like(place)
    for _ in range(_MAX_STEPS):
        fresh = size[active] == 1.0
        renew = active[fresh]
        step[renew] = _newton_step(patches, targets[renew], index[renew], place[renew])
        trial = np.clip(place[active] + size[active, None] * step[active], 0.0, 1.0)
        gap = patches.evaluate(index[active], trial[:, 0], trial[:, 1]) - targets[active]
        reached = np.einsum("kd,kd->k", gap, gap)
        moved = np.abs(trial - place[active]).max(axis=1, initial=0.0)
        better = reached <= value[active]
        place[active[better]], value[active[better]] = trial[better], reached[better]
        size[active] = np.where(better, 1.0, size[active] / 2.0)
        active = active[moved > np.where(better, _STILL, _ROUNDING)]
        if len(active) == 0:
            break
    return np.asarray(np.sqrt(value))


def _newton_step(patches: Patches, targets: Array, index: NDArray[np.intp], place: Array) -> Array:
    """Step towards the foot of each target, shape ``(k, 2)``, that respects the bounds."""
    u, v = place.T
    gap = patches.evaluate(index, u, v) - targets
    s_u, s_v = patches.evaluate(index, u, v, du=1), patches.evaluate(index, u, v, dv=1)
    tangents = np.stack([s_u, s_v], axis=1)
    gradient = np.einsum("kid,kd->ki", tangents, gap)
    gauss = np.einsum("kid,kjd->kij", tangents, tangents)
    bend = np.empty_like(gauss)
    for i, j, du, dv in ((0, 0, 2, 0), (0, 1, 1, 1), (1, 0, 1, 1), (1, 1, 0, 2)):
        second = patches.evaluate(index, u, v, du=du, dv=dv)
        bend[:, i, j] = np.einsum("kd,kd->k", second, gap)
    full = gauss + bend
    is_minimum = (np.linalg.det(full) > 1e-3 * np.linalg.det(gauss)) & (full[:, 0, 0] > 0.0)
    hessian = np.where(is_minimum[:, None, None], full, gauss)
    held = ((place <= 0.0) & (gradient > 0.0)) | ((place >= 1.0) & (gradient < 0.0))
    gradient[held] = 0.0
    hessian[held[:, 0] | held[:, 1], 0, 1] = 0.0
    hessian[held[:, 0] | held[:, 1], 1, 0] = 0.0
    # A little of the diagonal keeps patches that are collapsed to a line or a point solvable.
    ridge = 1e-14 * np.trace(hessian, axis1=1, axis2=2) + np.finfo(float).tiny
    hessian = hessian + ridge[:, None, None] * np.eye(2)
    return np.asarray(np.linalg.solve(hessian, -gradient[:, :, None])[:, :, 0])
