"""Tensor-product B-spline surface."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.spatial import cKDTree

from crispline.surface.base import Array, Similarity, Surface, unit
from crispline.surface.basis import DEGREE, SpanPolynomials

_MAX_STEPS = 40
_CONVERGED = 1e-12
_SAMPLES_PER_SPAN = 3
_POINT = ((0, 0),)
_TANGENTS = ((0, 0), (1, 0), (0, 1))
_BENDS = (*_TANGENTS, (2, 0), (1, 1), (0, 2))


@dataclass(frozen=True)
class BSplineSurface(Surface):
    """Bicubic tensor-product B-spline with clamped knots.

    ``knots_u`` has shape ``(n_u + 4,)``, ``knots_v`` ``(n_v + 4,)``,
    ``control_points`` ``(n_u, n_v, 3)``. The normal is ``S_u x S_v``.
    """

    knots_u: Array
    knots_v: Array
    control_points: Array
    kind: ClassVar[str] = "bspline"

    @property
    def domain(self) -> tuple[Array, Array]:
        """Smallest and largest ``(u, v)``, each of shape ``(2,)``."""
        ends = np.array([self.knots_u[[DEGREE, -DEGREE - 1]], self.knots_v[[DEGREE, -DEGREE - 1]]])
        return ends[:, 0], ends[:, 1]

    def evaluate(self, u: Array, v: Array, du: int = 0, dv: int = 0) -> Array:
        """Points or derivatives at parameters ``u``, ``v`` of shape ``(n,)``: shape ``(n, 3)``.

        ``du`` and ``dv`` (0 to 3) are how often to differentiate by each
        parameter. Parameters outside the domain extend the border polynomials.
        """
        return self._derivatives(u, v, ((du, dv),))[0]

    def project(self, points: Array) -> tuple[Array, Array]:
        """Nearest points; where the true foot is beyond the domain, the nearest border point."""
        u, v = self.parameters_of(points)
        return self.evaluate_with_normals(u, v)

    def evaluate_with_normals(self, u: Array, v: Array) -> tuple[Array, Array]:
        """Points and unit normals at parameters ``u``, ``v`` of shape ``(n,)``: ``(n, 3)`` each."""
        points, along_u, along_v = self._derivatives(u, v, _TANGENTS)
        return points, unit(np.cross(along_u, along_v))

    def parameters_of(self, points: Array) -> tuple[Array, Array]:
        """Parameters of the nearest points, each of shape ``(n,)``, inside the domain."""
        tree, u, v = self._samples
        _, nearest = tree.query(points)
        return self.refined_parameters(points, u[nearest], v[nearest])

    def refined_parameters(
        self, points: Array, u: Array, v: Array, n_steps: int = _MAX_STEPS
    ) -> tuple[Array, Array]:
        """Foot-point parameters by Newton's method from given ones.

        Parameters
        ----------
        points : shape ``(n, 3)``.
        u, v : start values, shape ``(n,)``.
        n_steps : largest number of Newton steps; the default converges to 1e-12 of the domain.

        Returns
        -------
        u, v : clipped to the domain. The distance does not grow from the start values.
        """
        low, high = self.domain
        uv = np.clip(np.column_stack([u, v]), low, high)
        largest = (high - low) / [len(self.knots_u) - 7, len(self.knots_v) - 7]
        rounding = (_CONVERGED * float(np.max(high - low))) ** 2
        best = uv.copy()
        best_distance = np.full(len(uv), np.inf)
        step = np.zeros_like(uv)
        active = np.arange(len(uv))
        for count in range(n_steps + 1):
            # The last step is only judged: that takes no derivative.
            wanted = _POINT if count == n_steps else _BENDS
            surface = self._derivatives(uv[active, 0], uv[active, 1], wanted)
            offset = points[active] - surface[0]
            distance = np.einsum("ij,ij->i", offset, offset)
            # Slack for rounding: at the foot a distance resolves only half the digits.
            is_lower = distance <= best_distance[active] * (1.0 + 1e-9) + rounding
            lower = active[is_lower]
            best[lower], best_distance[lower] = uv[lower], distance[is_lower]
            if count == n_steps:
                break
            newton = newton_steps(offset, surface, uv[active], low, high)
            newton = np.clip(newton, -largest, largest)
            # A step that went uphill is retried at a quarter of its length.
            step[active] = np.where(is_lower[:, None], newton, 0.25 * step[active])
            target = np.clip(best[active] + step[active], low, high)
            moved = np.max(np.abs(target - best[active]) / (high - low), axis=1) > _CONVERGED
            uv[active] = target
            active = active[moved]
            if not len(active):
                break
        return best[:, 0], best[:, 1]

    def parameters(self) -> Mapping[str, float | list[float]]:
        return {
            "degree": DEGREE,
            "n_control_points_u": self.control_points.shape[0],
            "n_control_points_v": self.control_points.shape[1],
        }

    def transformed(self, similarity: Similarity) -> BSplineSurface:
        return BSplineSurface(self.knots_u, self.knots_v, similarity.points(self.control_points))

    @property
    def n_parameters(self) -> int:
        return int(self.control_points.size)

    @cached_property
    def _samples(self) -> tuple[cKDTree, Array, Array]:
        """Search tree over a grid of surface points, with their parameters."""
        low, high = self.domain
        n_u, n_v = (
            _SAMPLES_PER_SPAN * (len(k) - 2 * DEGREE - 1) + 1 for k in (self.knots_u, self.knots_v)
        )
        grid_u, grid_v = np.meshgrid(
            np.linspace(low[0], high[0], n_u), np.linspace(low[1], high[1], n_v), indexing="ij"
        )
        u, v = grid_u.ravel(), grid_v.ravel()
        return cKDTree(self.evaluate(u, v)), u, v

    @cached_property
    def _bases(self) -> tuple[SpanPolynomials, SpanPolynomials]:
        return SpanPolynomials.of(self.knots_u), SpanPolynomials.of(self.knots_v)

    def _derivatives(self, u: Array, v: Array, orders: tuple[tuple[int, int], ...]) -> list[Array]:
        """Several derivatives from one gather of control points, each of shape ``(n, 3)``."""
        along_u, across = self._bases
        first_u, basis_u = along_u.at(u, max(du for du, _ in orders))
        first_v, basis_v = across.at(v, max(dv for _, dv in orders))
        n_v = self.control_points.shape[1]
        flat = self.control_points.reshape(-1, 3)
        near = np.arange(DEGREE + 1)
        index = (first_u[:, None] + near)[:, :, None] * n_v + (first_v[:, None] + near)[:, None, :]
        local = flat.take(index, axis=0).reshape(len(u), 4, 12)
        # Contract u first, once for every u-derivative; then each wanted pair along v.
        # Products of a row and a small matrix each: einsum is quicker at them than matmul.
        along_v = {
            du: np.einsum("ni,nij->nj", basis_u[du], local).reshape(len(u), 4, 3)
            for du in {du for du, _ in orders}
        }
        return [np.einsum("ni,nij->nj", basis_v[dv], along_v[du]) for du, dv in orders]


def newton_steps(offset: Array, surface: list[Array], uv: Array, low: Array, high: Array) -> Array:
    """Newton steps ``(n, 2)`` towards the foot points, along the border where it holds them back.

    ``surface`` holds S, S_u, S_v, S_uu, S_uv, S_vv. Where the Hessian is not
    safely positive the Gauss-Newton matrix takes its place.
    """
    _, s_u, s_v, s_uu, s_uv, s_vv = surface
    dot = "ij,ij->i"
    gradient = np.column_stack([np.einsum(dot, offset, s_u), np.einsum(dot, offset, s_v)])
    a, b, c = np.einsum(dot, s_u, s_u), np.einsum(dot, s_u, s_v), np.einsum(dot, s_v, s_v)
    full_a = a - np.einsum(dot, offset, s_uu)
    full_b = b - np.einsum(dot, offset, s_uv)
    full_c = c - np.einsum(dot, offset, s_vv)
    is_convex = (full_a > 0.0) & (full_a * full_c - full_b**2 > 1e-3 * (a * c - b**2))
    a, b, c = (
        np.where(is_convex, full, plain) for full, plain in ((full_a, a), (full_b, b), (full_c, c))
    )
    blocked = ((uv <= low) & (gradient < 0.0)) | ((uv >= high) & (gradient > 0.0))
    gradient = np.where(blocked, 0.0, gradient)
    b = np.where(blocked.any(axis=1), 0.0, b)
    determinant = a * c - b**2
    safe = np.where(determinant > 0.0, determinant, 1.0)
    step_u = (c * gradient[:, 0] - b * gradient[:, 1]) / safe
    step_v = (a * gradient[:, 1] - b * gradient[:, 0]) / safe
    return np.where((determinant > 0.0)[:, None], np.column_stack([step_u, step_v]), 0.0)
