"""Tensor-product B-spline surface of any degree, possibly rational, as a value.

Parameter ``u`` runs along axis 0 of the control points, ``v`` along axis 1.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from math import comb

import numpy as np
from scipy.interpolate import NdBSpline

from crispline.errors import InputError
from crispline.spline import knots as along
from crispline.surface.base import Array

CUBIC = 3


@dataclass(frozen=True, eq=False)
class TensorSpline:
    """A B-spline surface; knots may be clamped or not.

    Values from outside go through :func:`crispline.spline.checked.checked_spline`;
    the constructor itself checks nothing.

    Attributes
    ----------
    degree_u, degree_v : at least 1.
    knots_u : nondecreasing, shape ``(n_u + degree_u + 1,)``.
    knots_v : nondecreasing, shape ``(n_v + degree_v + 1,)``.
    control_points : Euclidean (not multiplied by the weights), shape ``(n_u, n_v, 3)``.
    weights : positive, shape ``(n_u, n_v)``, or None for a polynomial surface.
    """

    degree_u: int
    degree_v: int
    knots_u: Array
    knots_v: Array
    control_points: Array
    weights: Array | None = None

    @property
    def domain(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """First and last parameter along ``u``, then along ``v``."""
        n_u, n_v = self.control_points.shape[:2]
        return (
            (float(self.knots_u[self.degree_u]), float(self.knots_u[n_u])),
            (float(self.knots_v[self.degree_v]), float(self.knots_v[n_v])),
        )

    def evaluate(self, u: Array, v: Array, du: int = 0, dv: int = 0) -> Array:
        """Points, or derivatives, at paired parameters.

        Parameters
        ----------
        u, v : shape ``(k,)``. Outside the domain the outermost polynomials go on.
        du, dv : how often to differentiate by each parameter.

        Returns
        -------
        Shape ``(k, 3)``. Where a derivative jumps at a knot, the value is the one
        from the side of larger parameters; at the end of the domain from inside.

        References
        ----------
        Derivatives of rational surfaces: Piegl and Tiller, The NURBS Book, 2nd
        ed., equation 4.20.
        """
        parameters = np.column_stack([u, v]).astype(float)
        if self.weights is None:
            return self._polynomial_derivative(parameters, du, dv)
        homogeneous = {
            (a, b): self._polynomial_derivative(parameters, a, b)
            for a in range(du + 1)
            for b in range(dv + 1)
        }
        weight = homogeneous[0, 0][:, 3:]
        found: dict[tuple[int, int], Array] = {}
        for a, b in sorted(homogeneous):
            rest = homogeneous[a, b][:, :3].copy()
            for i, j in sorted(found):
                if i <= a and j <= b:
                    factor = comb(a, i) * comb(b, j)
                    rest -= factor * homogeneous[a - i, b - j][:, 3:] * found[i, j]
            found[a, b] = rest / weight
        return found[du, dv]

    def _polynomial_derivative(self, parameters: Array, du: int, dv: int) -> Array:
        if du > self.degree_u or dv > self.degree_v:
            return np.zeros((len(parameters), self._coordinates.shape[2]))
        return np.asarray(self._scipy(parameters, nu=(du, dv)))

    @cached_property
    def _coordinates(self) -> Array:
        """Homogeneous coordinates of a rational surface, else the control points."""
        if self.weights is None:
            return self.control_points
        weights = self.weights[:, :, None]
        return np.concatenate([self.control_points * weights, weights], axis=2)

    @cached_property
    def _scipy(self) -> NdBSpline:
        degrees = (self.degree_u, self.degree_v)
        return NdBSpline((self.knots_u, self.knots_v), self._coordinates, degrees)

    def with_knot_u(self, u: float, multiplicity: int) -> TensorSpline:
        """The same surface with ``u`` a knot of at least this multiplicity.

        Parameters
        ----------
        u : inside the domain. A knot that equals it up to rounding is the one meant.
        multiplicity : at most ``degree_u``, which leaves the surface free to be
            creased there.

        Raises
        ------
        InputError
            ``u`` outside the domain or ``multiplicity`` above the degree.
        """
        (low, high), _ = self.domain
        if not low <= u <= high:
            raise InputError(
                f"expected a knot inside the surface's domain [{low:.6g}, {high:.6g}], "
                f"got {u:.6g}; choose one there"
            )
        if multiplicity > self.degree_u:
            raise InputError(
                f"expected a multiplicity up to the degree {self.degree_u}, got {multiplicity}; "
                "a higher one would tear the surface"
            )
        knots, coordinates = along.with_multiplicity(
            self.degree_u, self.knots_u, self._coordinates, float(u), multiplicity
        )
        return self._rebuilt(self.degree_u, knots, coordinates)

    def with_knot_v(self, v: float, multiplicity: int) -> TensorSpline:
        """The same surface with ``v`` a knot of at least this multiplicity; see `with_knot_u`."""
        return self.transposed().with_knot_u(v, multiplicity).transposed()

    def clamped(self) -> TensorSpline:
        """The same surface over clamped knots: its corner control points lie on it."""
        return self.restricted(*self.domain)

    def restricted(self, u: tuple[float, float], v: tuple[float, float]) -> TensorSpline:
        """The part of the surface between two parameters each way, over clamped knots.

        Parameters
        ----------
        u, v : lower and higher parameter, inside the domain.
        """
        return self._restricted_u(*u).transposed()._restricted_u(*v).transposed()

    def _restricted_u(self, low: float, high: float) -> TensorSpline:
        return self._rebuilt(
            self.degree_u,
            *along.restricted(self.degree_u, self.knots_u, self._coordinates, low, high),
        )

    def elevated(self, degree: int = CUBIC) -> TensorSpline:
        """The same surface with both degrees raised to ``degree``, over clamped knots.

        A surface that has the degree in both directions comes back as it is.

        Raises
        ------
        InputError
            A degree of the surface is higher than ``degree``.
        """
        if max(self.degree_u, self.degree_v) > degree:
            raise InputError(
                f"expected a surface of degree {degree} or less, got degrees {self.degree_u} and "
                f"{self.degree_v}; approximate it with a surface of degree {degree} first"
            )
        if self.degree_u == self.degree_v == degree:
            return self
        clamped = self.clamped()
        return clamped._elevated_u(degree).transposed()._elevated_u(degree).transposed()

    def _elevated_u(self, degree: int) -> TensorSpline:
        knots, coordinates = self.knots_u, self._coordinates
        for below in range(self.degree_u, degree):
            knots, coordinates = along.elevated(below, knots, coordinates)
        return self._rebuilt(degree, knots, coordinates)

    def _rebuilt(self, degree_u: int, knots_u: Array, coordinates: Array) -> TensorSpline:
        """The surface with another ``u`` axis, from (homogeneous) coordinates."""
        weights = None if self.weights is None else coordinates[:, :, 3]
        points = coordinates if weights is None else coordinates[:, :, :3] / weights[:, :, None]
        return TensorSpline(degree_u, self.degree_v, knots_u, self.knots_v, points, weights)

    def transposed(self) -> TensorSpline:
        """The same surface with ``u`` and ``v`` exchanged; its normal changes sides."""
        return TensorSpline(
            self.degree_v,
            self.degree_u,
            self.knots_v,
            self.knots_u,
            self.control_points.swapaxes(0, 1),
            None if self.weights is None else self.weights.T,
        )

    def reversed_u(self) -> TensorSpline:
        """The same surface run backwards along ``u``, over the same domain."""
        (low, high), _ = self.domain
        return replace(
            self,
            knots_u=(low + high) - self.knots_u[::-1],
            control_points=self.control_points[::-1],
            weights=None if self.weights is None else self.weights[::-1],
        )

    def reversed_v(self) -> TensorSpline:
        """The same surface run backwards along ``v``, over the same domain."""
        return self.transposed().reversed_u().transposed()


def spline_over_grid(points: Array) -> TensorSpline:
    """Uniform bicubic B-spline surface with the points of a grid as its control net.

    Parameters
    ----------
    points : shape ``(m, n, 3)``, ``m`` and ``n`` at least 2. A NaN point leaves
        a hole of 4 x 4 spans in the surface.

    Returns
    -------
    Knots are the integers ``-3 ... m + 2`` and ``-3 ... n + 2``, and parameter
    ``(i, j)`` belongs to grid point ``(i, j)``. One row and column is added on
    every side by linear extrapolation, so that the surface spans the whole grid
    and its border passes through the border's points where they lie on a line.

    Raises
    ------
    InputError
        Not a grid, or fewer than two rows or columns.

    References
    ----------
    Step 1 of the method: the points, in grid order, are the control points.
    """
    if points.ndim != 3 or points.shape[2] != 3 or min(points.shape[:2]) < 2:
        raise InputError(
            "expected a grid of points, an array of shape (m, n, 3) with m and n at least 2, "
            f"got shape {points.shape}; arrange the points in rows and columns"
        )
    m, n = points.shape[:2]
    net = _extrapolated(_extrapolated(points.astype(float)).swapaxes(0, 1)).swapaxes(0, 1)
    return TensorSpline(CUBIC, CUBIC, np.arange(-3.0, m + 3), np.arange(-3.0, n + 3), net)


def _extrapolated(net: Array) -> Array:
    """The net with one row more at either end of axis 0, on the line of the last two."""
    before, after = 2.0 * net[:1] - net[1:2], 2.0 * net[-1:] - net[-2:-1]
    return np.concatenate([before, net, after])
