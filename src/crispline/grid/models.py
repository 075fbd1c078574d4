"""Polynomial models of a side, their least-squares fits at many sites, and the choice of one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array, unit

Index = NDArray[np.int64]

EXPONENTS = np.array([(a, d - a) for d in range(5) for a in range(d, -1, -1)])
"""Exponents of ``u`` and ``v`` in the 15 monomials up to degree 4."""
_QUADRATIC = 3
_RCOND = 1e-11
_COST = 3.0
"""Charge for a coefficient, in logarithms of the number of points; 1 would be Schwarz's."""
_LEAST_NOISE = 1e-6
"""Noise below which nothing is told apart, spacings."""


def _degree(n: int) -> NDArray[np.bool_]:
    return np.asarray(EXPONENTS.sum(axis=1) <= n)


def _with(*pairs: tuple[int, int]) -> NDArray[np.bool_]:
    wanted = {(0, 0), (1, 0), (0, 1), *pairs}
    return np.array([tuple(pair) in wanted for pair in EXPONENTS.tolist()])


MODELS = np.stack(
    [
        _degree(1),
        _with((2, 0)),
        _with((0, 2)),
        _degree(2),
        _with((2, 0), (3, 0), (4, 0), (1, 1), (2, 1)),
        _with((0, 2), (0, 3), (0, 4), (1, 1), (1, 2)),
        _degree(3),
        _degree(4),
    ]
)
"""Which monomials each model has: a plane, bent along one parameter, and so on, ``(8, 15)``."""


@dataclass(frozen=True)
class Basis:
    """All monomials at the supporting points of some sites.

    Attributes
    ----------
    values : 0 at points that do not belong, shape ``(k, w, 15)``.
    local : the points about ``middle``, likewise, ``(k, w, 3)``.
    count : number of supporting points, ``(k,)``.
    lines : rows and columns that these lie on, ``(k, 2)``.
    centre, scale : of the parameters, ``(k, 2)``.
    middle : mean of the points, ``(k, 3)``.
    """

    values: Array
    local: Array
    count: Array
    lines: Array
    centre: Array
    scale: Array
    middle: Array

    def is_usable(self, model: int) -> NDArray[np.bool_]:
        """Sites with enough points for a model; all are taken to have enough for a plane."""
        columns = MODELS[model]
        is_known = (self.lines > EXPONENTS[columns].max(axis=0)).all(axis=1)
        return np.asarray((is_known & (self.count >= 1.5 * columns.sum())) | (model == 0))

    def coefficients(self, model: int, rows: Index) -> Array:
        """Least-squares coefficients of a model, shape ``(r, b, 3)``."""
        part = self.values[rows][:, :, MODELS[model]]
        turned = part.swapaxes(1, 2)
        inverse = np.linalg.pinv(turned @ part, rcond=_RCOND, hermitian=True)
        return np.asarray(inverse @ (turned @ self.local[rows]))

    def misfits(self) -> Array:
        """Squared misfits of every model along normals and tangents, ``(k, 8, 2)``.

        Infinite where there are too few points.
        """
        misfit = np.full((len(self.count), len(MODELS), 2), np.inf)
        for model in range(len(MODELS)):
            rows = np.flatnonzero(self.is_usable(model))
            c = self.coefficients(model, rows)
            residual = self.local[rows] - self.values[rows][:, :, MODELS[model]] @ c
            # At the middle of the support; scaled parameters span the same plane.
            normal = unit(np.cross(c[:, 1], c[:, 2]))
            along = np.square((residual @ normal[:, :, None])[:, :, 0]).sum(axis=1)
            total = np.square(residual).sum(axis=(1, 2))
            misfit[rows, model, 0] = along
            misfit[rows, model, 1] = np.maximum(total - along, 0.0)
        return misfit

    def solved(self, models: Index) -> tuple[Array, Array, Array, Array]:
        """Centre, scale and the coefficients ``(k, 15, 3)`` of two models for each site.

        A site with too few points for its model gets the simpler one of degree two,
        or one, that it has enough for.
        """
        results = []
        for wanted in models:
            model = wanted.copy()
            for simpler in (_QUADRATIC, 0):
                usable = np.stack([self.is_usable(k) for k in range(len(MODELS))], axis=1)
                lacks = ~usable[np.arange(len(model)), model]
                model[lacks] = np.minimum(model[lacks], simpler)
            coefficients = np.zeros((len(model), len(EXPONENTS), 3))
            for k in np.unique(model):
                rows = np.flatnonzero(model == k)
                columns = np.flatnonzero(MODELS[k])
                coefficients[rows[:, None], columns] = self.coefficients(int(k), rows)
            coefficients[:, 0] += self.middle
            coefficients[self.count < 3] = np.nan
            results.append(coefficients)
        return self.centre, self.scale, results[0], results[1]


def choose(misfit: Array, count: Array, side: Index, sigma: float, n_components: int) -> Index:
    """The model of least description length for each side (mean over its sites), ``(s,)``."""
    n_sites = np.bincount(side)
    size = MODELS.sum(axis=1)
    # Noise that the estimate does not see, such as correlated noise, shows in the fullest model.
    usable = np.isfinite(misfit)
    fullest = len(MODELS) - 1 - np.argmax(usable[:, ::-1], axis=1)
    rows = np.arange(len(misfit))
    freedom = np.maximum(count - size[fullest], 1.0) * n_components
    seen = np.bincount(side, misfit[rows, fullest] / freedom) / n_sites
    variance = np.maximum(seen, max(sigma, _LEAST_NOISE) ** 2)[side]
    length = np.where(usable, misfit, 0.0) / variance[:, None]
    length += _COST * n_components * size * np.log(np.maximum(count, 2.0))[:, None]
    total = np.stack([np.bincount(side, column) for column in length.T], axis=1)
    n_unusable = np.stack([np.bincount(side, ~column) for column in usable.T], axis=1)
    total[n_unusable > 0.5 * n_sites[:, None]] = np.inf
    return np.asarray(np.argmin(total, axis=1))
