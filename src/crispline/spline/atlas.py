"""Nearest points on many spline surfaces at once."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import NdBSpline
from scipy.spatial import cKDTree

from crispline.spline.tensor import TensorSpline
from crispline.surface.base import Array, unit
from crispline.surface.bspline import newton_steps

Index = NDArray[np.int64]

_CHUNK = 50_000
"""Points evaluated together; bounds the memory for their control points."""
_MAX_STEPS = 40
_CONVERGED = 1e-8
"""Newton's method ends when no parameter moves by more than this, in spans: with a last step
of that size it is right to rounding."""
_TICKS = (1 / 6, 1 / 2, 5 / 6)
"""Start values in every span."""
_ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


@dataclass(frozen=True, eq=False)
class Atlas:
    """Spline surfaces of one pair of degrees as rational Bezier pieces.

    A place on surface ``i`` is told in spans: ``(x, y)`` lies in piece
    ``(floor(x), floor(y))`` of it, at the fractions as Bezier parameters.

    Attributes
    ----------
    coordinates : homogeneous Bezier points of all pieces, shape ``(n_pieces, p + 1, q + 1, 4)``;
        a surface's pieces follow one another, those along v first.
    first : first piece of each surface, shape ``(n_surfaces,)``.
    spans : number of spans along u and v, shape ``(n_surfaces, 2)``.
    """

    coordinates: Array
    first: Index
    spans: Index

    def project(self, points: Array, surface: Index) -> tuple[Array, Array]:
        """Nearest points on the surface that is named for each point.

        Parameters
        ----------
        points : shape ``(n, 3)``.
        surface : the surface of each, shape ``(n,)``.

        Returns
        -------
        feet : shape ``(n, 3)``; on the border where the true foot is beyond it.
        normals : ``S_u x S_v`` of length one, shape ``(n, 3)``.
        """
        parts = [
            self._project(points[i : i + _CHUNK], surface[i : i + _CHUNK])
            for i in range(0, len(points), _CHUNK)
        ]
        if not parts:
            return np.empty((0, 3)), np.empty((0, 3))
        feet, normals = zip(*parts, strict=True)
        return np.concatenate(feet), np.concatenate(normals)

    def _project(self, points: Array, surface: Index) -> tuple[Array, Array]:
        place = self._descend(points, surface, self._nearest_samples(points, surface))
        foot, along_u, along_v = self.derivatives(surface, place, _ORDERS[:3])
        return foot, unit(np.cross(along_u, along_v))

    def _descend(self, points: Array, surface: Index, place: Array) -> Array:
        """Places of the foot points by Newton's method; the distance never grows."""
        high = self.spans[surface].astype(float)
        low = np.zeros_like(high)
        best, best_distance = place.copy(), np.full(len(place), np.inf)
        trial, step = place.copy(), np.zeros_like(place)
        active = np.arange(len(place))
        for _ in range(_MAX_STEPS):
            found = self.derivatives(surface[active], trial[active], _ORDERS)
            offset = points[active] - found[0]
            distance = np.einsum("ij,ij->i", offset, offset)
            # Slack for rounding: at the foot a distance resolves only half the digits.
            is_lower = distance <= best_distance[active] * (1.0 + 1e-12)
            lower = active[is_lower]
            best[lower], best_distance[lower] = trial[lower], distance[is_lower]
            newton = newton_steps(offset, found, trial[active], low[active], high[active])
            # A step that went uphill is retried at a quarter of its length.
            step[active] = np.where(
                is_lower[:, None], np.clip(newton, -1.0, 1.0), 0.25 * step[active]
            )
            target = np.clip(best[active] + step[active], 0.0, high[active])
            has_moved = np.abs(target - best[active]).max(axis=1) > _CONVERGED
            trial[active] = target
            active = active[has_moved]
            if not len(active):
                break
        return best

    def derivatives(
        self, surface: Index, place: Array, orders: Sequence[tuple[int, int]]
    ) -> list[Array]:
        """Points or derivatives (up to the second) by span, each of shape ``(n, 3)``.

        ``orders`` begins with ``(0, 0)`` and holds the lower derivatives before the higher.
        """
        spans = self.spans[surface]
        piece = np.clip(np.floor(place).astype(np.int64), 0, spans - 1)
        local = place - piece
        points = self.coordinates[self.first[surface] + piece[:, 0] * spans[:, 1] + piece[:, 1]]
        n, n_u, n_v, _ = points.shape
        highest = max(max(order) for order in orders)
        basis_u, basis_v = (
            [bernstein(size - 1, local[:, axis], k) for k in range(highest + 1)]
            for axis, size in enumerate((n_u, n_v))
        )
        flat = points.reshape(n, n_u, n_v * 4)
        along_v = {
            du: (basis_u[du][:, None, :] @ flat).reshape(n, n_v, 4)
            for du in {du for du, _ in orders}
        }
        homogeneous = [(basis_v[dv][:, None, :] @ along_v[du])[:, 0, :] for du, dv in orders]
        return _quotients(homogeneous, orders)

    def _nearest_samples(self, points: Array, surface: Index) -> Array:
        tree, places, reach = self._samples
        _, nearest = tree.query(np.column_stack([points, reach * surface]))
        return places[nearest]

    @cached_property
    def _samples(self) -> tuple[cKDTree, Array, float]:
        """Search tree over samples of every piece, their places, and a length that is added
        per surface as a fourth coordinate, so that only samples of one surface are near.
        """
        n_pieces = len(self.coordinates)
        owner = np.repeat(np.arange(len(self.first)), self.spans.prod(axis=1))
        number = np.arange(n_pieces) - self.first[owner]
        corner = np.column_stack(np.divmod(number, self.spans[owner, 1])).astype(float)
        ticks = np.array([(a, b) for a in _TICKS for b in _TICKS])
        places = (corner[:, None, :] + ticks).reshape(-1, 2)
        owner = np.repeat(owner, len(ticks))
        (positions,) = self.derivatives(owner, places, _ORDERS[:1])
        # Farther than any two points that are asked for within the surroundings.
        reach = 10.0 * float(np.ptp(positions, axis=0).sum()) + 1e-300
        return cKDTree(np.column_stack([positions, reach * owner])), places, reach


def build_atlas(splines: Sequence[TensorSpline]) -> Atlas:
    """Bezier pieces of spline surfaces that all have the same degrees ``(p, q)``."""
    pieces: list[Array] = [np.empty(0)] * len(splines)
    spans = np.zeros((len(splines), 2), dtype=np.int64)
    for alike in _alike(splines):
        found = _bezier_pieces([splines[i] for i in alike])
        spans[alike] = found.shape[1:3]
        for i, grid in zip(alike, found, strict=True):
            pieces[i] = grid.reshape(-1, *grid.shape[2:])
    counts = spans.prod(axis=1)
    return Atlas(np.concatenate(pieces), np.cumsum(counts) - counts, spans)


def _alike(splines: Sequence[TensorSpline]) -> Iterable[list[int]]:
    """Groups of splines over the same knots, which the patches of a net nearly all are."""
    groups: dict[tuple[bytes, bytes], list[int]] = {}
    for i, spline in enumerate(splines):
        groups.setdefault((spline.knots_u.tobytes(), spline.knots_v.tobytes()), []).append(i)
    return groups.values()


def bernstein(degree: int, t: Array, derivative: int = 0) -> Array:
    """Bernstein polynomials or a derivative of them at ``t`` of shape ``(n,)``: ``(n, p + 1)``.

    >>> bernstein(2, np.array([0.5])).tolist()
    [[0.25, 0.5, 0.25]]
    """
    if derivative > degree:
        return np.zeros((len(t), degree + 1))
    if derivative:
        lower = np.pad(bernstein(degree - 1, t, derivative - 1), ((0, 0), (1, 1)))
        return np.asarray(degree * (lower[:, :-1] - lower[:, 1:]))
    values = np.ones((len(t), degree + 1))
    for parameter, columns in ((t, values.T), (1.0 - t, values.T[::-1])):
        power = parameter
        for column in columns[1:]:  # products, as numpy's powers take ten times as long
            column *= power
            power = power * parameter
    return np.asarray(values * [float(comb(degree, i)) for i in range(degree + 1)])


def _bezier_pieces(splines: Sequence[TensorSpline]) -> Array:
    """Homogeneous Bezier points of every span of splines over the same knots.

    The polynomials are found from values inside the spans, so at a multiple knot either
    side keeps its own.

    Returns
    -------
    Shape ``(k, m, n, p + 1, q + 1, 4)`` for ``k`` splines of ``m x n`` spans.
    """
    points = np.stack([spline.control_points for spline in splines], axis=2)
    weights = np.stack(
        [np.ones(points.shape[:2]) if s.weights is None else s.weights for s in splines], axis=2
    )[..., None]
    one = splines[0]
    axes = ((one.knots_u, one.degree_u), (one.knots_v, one.degree_v))
    parameters, solvers = [], []
    for knots, degree in axes:
        distinct = np.unique(knots[degree : len(knots) - degree])
        # Chebyshev points keep high degrees well conditioned.
        inside = 0.5 - 0.5 * np.cos((np.arange(degree + 1) + 0.5) * np.pi / (degree + 1))
        parameters.append(distinct[:-1, None] + np.diff(distinct)[:, None] * inside)
        solvers.append(np.linalg.inv(bernstein(degree, inside)))
    u, v = parameters
    grid = np.stack(np.meshgrid(u.ravel(), v.ravel(), indexing="ij"), axis=-1)
    homogeneous = np.concatenate([points * weights, weights], axis=3)
    evaluate = NdBSpline((one.knots_u, one.knots_v), homogeneous, (one.degree_u, one.degree_v))
    values = np.asarray(evaluate(grid)).reshape(*u.shape, *v.shape, len(splines), 4)
    return np.asarray(
        np.einsum("ab,mbncks,dc->kmnads", solvers[0], values, solvers[1], optimize=True)
    )


def _quotients(homogeneous: list[Array], orders: Sequence[tuple[int, int]]) -> list[Array]:
    """Derivatives of a rational surface (Piegl and Tiller, The NURBS Book, equation 4.20)."""
    at = dict(zip(orders, homogeneous, strict=True))
    weight = at[0, 0][:, 3:]
    found: dict[tuple[int, int], Array] = {}
    for a, b in orders:
        rest = at[a, b][:, :3]
        for (i, j), lower in found.items():
            if i <= a and j <= b:
                rest = rest - comb(a, i) * comb(b, j) * at[a - i, b - j][:, 3:] * lower
        found[a, b] = rest / weight
    return [found[order] for order in orders]
