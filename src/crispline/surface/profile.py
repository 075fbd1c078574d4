"""A plane B-spline curve that a motion sweeps into a surface."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import BSpline
from scipy.spatial import cKDTree

from crispline.surface.base import Array, unit
from crispline.surface.basis import DEGREE, SpanPolynomials

_MAX_STEPS = 40
_CONVERGED = 1e-13
_SAMPLES_PER_SPAN = 8


@dataclass(frozen=True)
class Profile:
    """A plane cubic B-spline curve.

    Attributes
    ----------
    knots : clamped, shape ``(m + 4,)``.
    control_points : shape ``(m, 2)``.
    """

    knots: Array
    control_points: Array

    @property
    def interval(self) -> tuple[float, float]:
        """First and last parameter."""
        return float(self.knots[0]), float(self.knots[-1])

    def derivatives(self, t: Array, highest: int = 2) -> Array:
        """Points and derivatives up to the ``highest``, shape ``(highest + 1, n, 2)``."""
        first, values = self._basis.at(t, highest)
        local = self.control_points[first[:, None] + np.arange(DEGREE + 1)]
        return np.asarray(np.einsum("dnk,nkx->dnx", values, local))

    def normals(self, t: Array) -> Array:
        """Unit normals to the left of the curve's heading, shape ``(n, 2)``."""
        along = self.derivatives(t, 1)[1]
        return np.asarray(unit(np.column_stack([-along[:, 1], along[:, 0]])))

    def sharpest_bend(self, t: Array) -> float:
        """Largest curvature between parameters ``(n,)``, at places dense for the knots."""
        n_spans = len(self.control_points) - DEGREE
        t = np.linspace(t.min(), t.max(), _SAMPLES_PER_SPAN * n_spans + 1)
        _, along, bend = self.derivatives(t)
        turning = np.abs(along[:, 0] * bend[:, 1] - along[:, 1] * bend[:, 0])
        speed = np.linalg.norm(along, axis=1)
        return float(np.max(turning / np.maximum(speed, 1e-12) ** 3))

    def distances(self, flat: Array, t: Array) -> Array:
        """Signed distances of points ``(n, 2)`` at parameters ``(n,)``; positive on the left."""
        offset = flat - self.derivatives(t, 0)[0]
        return np.asarray(np.einsum("ij,ij->i", offset, self.normals(t)))

    def corrected(self, flat: Array, t: Array) -> Array:
        """The parameters after a Newton step towards the feet of points ``(n, 2)``."""
        return self._stepped(flat - (found := self.derivatives(t))[0], found, t)

    def feet(self, flat: Array) -> Array:
        """Parameters of the nearest points of the curve to points ``(n, 2)``, shape ``(n,)``.

        Newton's method from the nearest of many samples; a step that leads farther off is
        retried at a quarter of its length.
        """
        tree, samples = self._samples
        t = samples[tree.query(flat)[1]]
        best, least = t.copy(), np.full(len(t), np.inf)
        step = np.zeros_like(t)
        low, high = self.interval
        size = float(np.ptp(self.control_points, axis=0).max())
        active = np.arange(len(t))
        for _ in range(_MAX_STEPS):
            found = self.derivatives(t[active])
            offset = flat[active] - found[0]
            distance = np.einsum("ij,ij->i", offset, offset)
            # At the foot a distance resolves only half the digits.
            is_lower = distance <= least[active] * (1.0 + 1e-9) + (1e-12 * size) ** 2
            lower = active[is_lower]
            best[lower], least[lower] = t[lower], distance[is_lower]
            newton = self._stepped(offset, found, t[active]) - t[active]
            step[active] = np.where(is_lower, newton, 0.25 * step[active])
            t[active] = np.clip(best[active] + step[active], low, high)
            moved = np.abs(t[active] - best[active]) > _CONVERGED * (high - low)
            active = active[moved]
            if not len(active):
                break
        return best

    def reversed(self) -> Profile:
        """The same curve run the other way, over the negative parameters."""
        return Profile(-self.knots[::-1], self.control_points[::-1])

    def between(self, low: float, high: float) -> Profile:
        """The piece between two parameters of the interval."""
        spline = BSpline(self.knots, self.control_points, DEGREE)
        for place in (low, high):
            missing = DEGREE - int(np.count_nonzero(spline.t == place))
            if missing > 0:
                spline = spline.insert_knot(place, m=missing)
        knots, controls = np.asarray(spline.t), np.asarray(spline.c)
        inner = knots[(knots > low) & (knots < high)]
        first = int(np.count_nonzero(knots < low)) - (low > self.knots[0])
        clamped = np.concatenate([np.full(4, low), inner, np.full(4, high)])
        return Profile(clamped, controls[first : first + len(inner) + DEGREE + 1])

    def clear_of(self, least: float, t: float) -> Profile:
        """The piece about a parameter whose first coordinate stays above ``least``."""
        places = self._samples[1]
        is_near = self.derivatives(places, 0)[0][:, 0] <= least
        before = places[is_near & (places < t)]
        behind = places[is_near & (places > t)]
        low, high = self.interval
        # The sample beside the last that is too near.
        if before.size:
            low = float(places[np.searchsorted(places, before.max()) + 1])
        if behind.size:
            high = float(places[np.searchsorted(places, behind.min()) - 1])
        return self if (low, high) == self.interval else self.between(low, high)

    def _stepped(self, offset: Array, found: Array, t: Array) -> Array:
        _, along, bend = found
        span = float(np.diff(self.knots[DEGREE:-DEGREE]).max())
        speed = np.einsum("ij,ij->i", along, along)
        slope = speed - np.einsum("ij,ij->i", offset, bend)
        slope = np.where(slope > 0.1 * speed, slope, np.maximum(speed, 1e-12))
        step = np.clip(np.einsum("ij,ij->i", offset, along) / slope, -span, span)
        return np.asarray(np.clip(t + step, *self.interval))

    @cached_property
    def _basis(self) -> SpanPolynomials:
        return SpanPolynomials.of(self.knots)

    @cached_property
    def _samples(self) -> tuple[cKDTree, Array]:
        spans = np.unique(self.knots)
        shares = np.arange(_SAMPLES_PER_SPAN) / _SAMPLES_PER_SPAN
        within = spans[:-1, None] + np.diff(spans)[:, None] * shares
        t = np.append(within.ravel(), spans[-1])
        return cKDTree(self.derivatives(t, 0)[0]), t
