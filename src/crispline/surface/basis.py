"""Cubic B-spline basis functions at many parameters at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array

DEGREE = 3
_FACTORIALS = np.array([1.0, 1.0, 2.0, 6.0])


def uniform_knots(start: float, end: float, n_spans: int) -> Array:
    """Clamped cubic knots over ``[start, end]`` with equal spans, shape ``(n_spans + 7,)``.

    >>> uniform_knots(0.0, 2.0, 2).tolist()
    [0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 2.0, 2.0, 2.0]
    """
    inner = np.linspace(start, end, n_spans + 1)
    return np.concatenate([np.full(DEGREE, start), inner, np.full(DEGREE, end)])


def basis_functions(
    knots: Array, parameters: Array, n_derivatives: int = 0
) -> tuple[NDArray[np.intp], Array]:
    """The four cubic basis functions that do not vanish, and their derivatives.

    Parameters
    ----------
    knots : clamped, shape ``(m + 4,)`` for ``m`` control points.
    parameters : shape ``(n,)``; values outside the domain extend the first or
        last span's polynomials, and the right end belongs to the last span.
    n_derivatives : highest derivative wanted, 0 to 3.

    Returns
    -------
    first : index of the first of the four control points, shape ``(n,)``.
    values : shape ``(n_derivatives + 1, n, 4)``.

    References
    ----------
    Cox-de Boor recursion and its derivative: Piegl and Tiller, The NURBS Book,
    2nd ed., equations 2.5 and 2.9.
    """
    last = len(knots) - DEGREE - 2
    span = np.clip(np.searchsorted(knots, parameters, side="right") - 1, DEGREE, last)
    ladder = [np.ones((1, len(parameters)))]
    for degree in range(1, DEGREE + 1):
        ladder.append(_raised(ladder[-1], knots, span, parameters, degree))
    values = np.empty((n_derivatives + 1, len(parameters), DEGREE + 1))
    values[0] = ladder[DEGREE].T
    for k in range(1, n_derivatives + 1):
        rows = ladder[DEGREE - k]
        for degree in range(DEGREE - k + 1, DEGREE + 1):
            rows = _differentiated(rows, knots, span, degree)
        values[k] = rows.T
    return span - DEGREE, values


@dataclass(frozen=True)
class SpanPolynomials:
    """The basis functions as polynomials of each span: quick for a few parameters at a time.

    Attributes
    ----------
    knots : clamped, shape ``(m + 4,)``.
    coefficients : of the four functions of each span by ascending powers of the distance from
        the span's first knot, shape ``(m - 3, 4 powers, 4 functions)``.
    """

    knots: Array
    coefficients: Array

    @classmethod
    def of(cls, knots: Array) -> SpanPolynomials:
        """The polynomials from the derivatives at the first knot of every span."""
        return _span_polynomials(np.asarray(knots, dtype=np.float64).tobytes())

    @classmethod
    def _of(cls, knots: Array) -> SpanPolynomials:
        starts = np.asarray(knots[DEGREE : -DEGREE - 1], dtype=np.float64)
        is_span = np.diff(knots[DEGREE:-DEGREE]) > 0.0
        coefficients = np.zeros((len(starts), DEGREE + 1, DEGREE + 1))
        derivatives = basis_functions(knots, starts[is_span], DEGREE)[1]
        coefficients[is_span] = np.moveaxis(derivatives / _FACTORIALS[:, None, None], 0, 1)
        return cls(knots, coefficients)

    def at(self, parameters: Array, n_derivatives: int = 0) -> tuple[NDArray[np.intp], Array]:
        """The same as :func:`basis_functions`."""
        last = len(self.coefficients) - 1
        first = np.searchsorted(self.knots, parameters, side="right") - 1 - DEGREE
        first = np.clip(first, 0, last)
        t = (parameters - self.knots[first + DEGREE])[:, None]
        c = [self.coefficients[:, power].take(first, axis=0) for power in range(DEGREE + 1)]
        values = np.empty((n_derivatives + 1, len(first), DEGREE + 1))
        for order in range(n_derivatives + 1):  # Horner, on the coefficients differentiated
            total = c[-1]
            for factors in c[-2::-1]:
                total = total * t + factors
            values[order] = total
            c = [power * factors for power, factors in enumerate(c)][1:]
        return first, values


@lru_cache(maxsize=16)
def _span_polynomials(knots: bytes) -> SpanPolynomials:
    """A fit makes one surface after the other over the same knots."""
    return SpanPolynomials._of(np.frombuffer(knots))


def _raised(
    lower: Array, knots: Array, span: NDArray[np.intp], parameters: Array, degree: int
) -> Array:
    """Functions of ``degree`` from those of one less: rows are functions, columns parameters."""
    rows = np.zeros((degree + 1, len(parameters)))
    for m in range(degree):
        left, right = knots[span - degree + 1 + m], knots[span + 1 + m]
        ratio = lower[m] / (right - left)
        rows[m] += (right - parameters) * ratio
        rows[m + 1] = (parameters - left) * ratio
    return rows


def _differentiated(lower: Array, knots: Array, span: NDArray[np.intp], degree: int) -> Array:
    """Derivatives at ``degree`` from the (derivatives of) functions of one degree less."""
    rows = np.zeros((degree + 1, lower.shape[1]))
    for m in range(degree):
        ratio = degree * lower[m] / (knots[span + 1 + m] - knots[span - degree + 1 + m])
        rows[m] -= ratio
        rows[m + 1] = ratio
    return rows
