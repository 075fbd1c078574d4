"""Polynomials in the grid's own parameters, fitted to a side of a feature around many sites.

A side is smooth in the parameters of its rows and columns, so its points near
a site are explained by a polynomial of low degree, which also tells where the
side would go on. All sites are fitted at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.grid.lattice import Lattice
from crispline.grid.models import EXPONENTS, Basis, choose
from crispline.surface.base import Array, unit

Index = NDArray[np.int64]

_N_TRIALS = 48
"""Sites of each side that all models are tried at."""
_CHUNK = 400


@dataclass(frozen=True)
class Sides:
    """Polynomial surfaces, one a row.

    Attributes
    ----------
    centre, scale : the polynomials are in ``(parameter - centre) / scale``, ``(k, 2)``.
    coefficients : shape ``(k, 15, 3)``.
    """

    centre: Array
    scale: Array
    coefficients: Array

    def __getitem__(self, rows: Index) -> Sides:
        return Sides(self.centre[rows], self.scale[rows], self.coefficients[rows])

    def scaled(self, uv: Array) -> Array:
        """Parameters that are between -1 and 1 over the supporting points, shape ``(k, 2)``."""
        return np.asarray((uv - self.centre) / self.scale)

    def at(self, uv: Array) -> tuple[Array, Array, Array]:
        """Points and derivatives along both parameters at ``uv`` ``(k, 2)``, each ``(k, 3)``."""
        t = self.scaled(uv)
        power = np.stack([np.ones_like(t), t, t**2, t**3, t**4])
        slope = np.stack([np.zeros_like(t), np.ones_like(t), 2 * t, 3 * t**2, 4 * t**3])
        a, b = EXPONENTS.T
        values = power[a, :, 0] * power[b, :, 1]
        du = slope[a, :, 0] * power[b, :, 1] / self.scale[:, 0]
        dv = power[a, :, 0] * slope[b, :, 1] / self.scale[:, 1]
        p, p_u, p_v = (np.einsum("ak,kac->kc", x, self.coefficients) for x in (values, du, dv))
        return p, p_u, p_v

    def normals(self, uv: Array) -> Array:
        """Unit normals at ``uv``, shape ``(k, 3)``."""
        _, du, dv = self.at(uv)
        return unit(np.cross(du, dv))

    def foot(self, points: Array, uv: Array, n_steps: int = 4) -> tuple[Array, Array, Array]:
        """Nearest points by Gauss-Newton from ``uv``: feet, unit normals, their parameters."""
        uv = uv.copy()
        for _ in range(n_steps):
            p, du, dv = self.at(uv)
            tangents = np.stack([du, dv], axis=2)
            uv += np.einsum("kij,kj->ki", np.linalg.pinv(tangents, rcond=1e-9), points - p)
        p, du, dv = self.at(uv)
        return p, unit(np.cross(du, dv)), uv


@dataclass(frozen=True)
class Support:
    """The points that sites are fitted to.

    Attributes
    ----------
    lattice : the points.
    side : which side each point is on, 0 for none, shape ``(m, n)``.
    radius : of the disc of points around a site, cells.
    sigma : noise a coordinate along the normals and along the tangents, spacings.
    """

    lattice: Lattice
    side: Index
    radius: int
    sigma: tuple[float, float]

    def fit(self, sites: Index, wanted: Index) -> tuple[Sides, Sides]:
        """Fit the wanted side around every site.

        Parameters
        ----------
        sites : rows and columns, shape ``(k, 2)``.
        wanted : a side for each, shape ``(k,)``.

        Returns
        -------
        shape : with the model that explains the points along the normals, for where
            the side lies.
        course : with the model that explains the points along the tangents, for
            which parameters it has there. A site with fewer than three points gets
            NaN coefficients.
        """
        if not len(sites):
            empty = Sides(np.zeros((0, 2)), np.ones((0, 2)), np.zeros((0, 15, 3)))
            return empty, empty
        side = np.unique(wanted, return_inverse=True)[1]
        trial = _evenly(side, _N_TRIALS)
        bases = [self._basis(sites[part], wanted[part]) for part in _chunks(trial)]
        misfit = np.concatenate([basis.misfits() for basis in bases])
        count = np.concatenate([basis.count for basis in bases])
        models = np.stack(
            [
                choose(misfit[:, :, kind], count, side[trial], self.sigma[kind], 1 + kind)
                for kind in (0, 1)
            ]
        )[:, side]
        parts = [
            self._basis(sites[part], wanted[part]).solved(models[:, part])
            for part in _chunks(np.arange(len(sites)))
        ]
        centre, scale, shape, course = (
            np.concatenate([part[i] for part in parts]) for i in range(4)
        )
        return Sides(centre, scale, shape), Sides(centre, scale, course)

    def _basis(self, sites: Index, wanted: Index) -> Basis:
        points, uv, weight = self._gather(sites, wanted)
        n = weight.sum(axis=1)
        safe = np.maximum(n, 1.0)[:, None]
        centre = np.einsum("kw,kwi->ki", weight, uv) / safe
        offset = np.where(weight[:, :, None] > 0.0, uv - centre[:, None], 0.0)
        scale = np.maximum(np.abs(offset).max(axis=1), 1e-9)
        t = offset / scale[:, None]
        power = np.stack([np.ones_like(t), t, t**2, t**3, t**4])
        a, b = EXPONENTS.T
        values = np.moveaxis(power[a, :, :, 0] * power[b, :, :, 1], 0, 2) * weight[:, :, None]
        middle = np.einsum("kw,kwc->kc", weight, points) / safe
        local = (points - middle[:, None]) * weight[:, :, None]
        lines = np.stack([_n_lines(offset[:, :, i], weight) for i in (0, 1)], axis=1)
        return Basis(values, local, n, lines, centre, scale, middle)

    def _gather(self, sites: Index, wanted: Index) -> tuple[Array, Array, Array]:
        """Points ``(k, w, 3)``, parameters ``(k, w, 2)`` and weights 0 or 1 ``(k, w)``."""
        m, n = self.side.shape
        reach = np.arange(-self.radius, self.radius + 1)
        di, dj = (x.ravel() for x in np.meshgrid(reach, reach, indexing="ij"))
        disc = di**2 + dj**2 <= self.radius**2
        i, j = sites[:, :1] + di[disc], sites[:, 1:] + dj[disc]
        is_inside = (i >= 0) & (i < m) & (j >= 0) & (j < n)
        i, j = np.clip(i, 0, m - 1), np.clip(j, 0, n - 1)
        weight = is_inside & (self.side[i, j] == wanted[:, None])
        uv = np.stack([self.lattice.u[i], self.lattice.v[j]], axis=2)
        return self.lattice.points[i, j], uv, weight.astype(float)


def _chunks(rows: Index) -> list[Index]:
    return [rows[start : start + _CHUNK] for start in range(0, len(rows), _CHUNK)]


def _evenly(side: Index, n: int) -> Index:
    """Rows of at most ``n`` sites of every side, evenly spread over them."""
    order = np.argsort(side, kind="stable")
    size = np.bincount(side)
    first = np.cumsum(size) - size
    parts = [
        order[start + np.unique(np.linspace(0, count - 1, min(n, count)).astype(np.int64))]
        for start, count in zip(first, size, strict=True)
    ]
    return np.concatenate(parts)


def _n_lines(offset: Array, weight: Array) -> Array:
    """Distinct values among the supported offsets of each site, shape ``(k,)``."""
    value = np.sort(np.where(weight > 0.0, offset, np.inf), axis=1)
    is_new = np.isfinite(value[:, 1:]) & (value[:, 1:] > value[:, :-1] + 1e-9)
    return np.asarray(1 + is_new.sum(axis=1))
