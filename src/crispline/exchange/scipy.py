"""Tensor-product B-splines of SciPy."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import NdBSpline

from crispline.errors import InputError
from crispline.spline.checked import checked_spline
from crispline.spline.tensor import TensorSpline


def from_scipy(
    t: Sequence[ArrayLike], c: ArrayLike, k: int | Sequence[int], where: str = "the SciPy spline"
) -> TensorSpline:
    """The surface of ``NdBSpline(t, c, k)``, whose ``t``, ``c`` and ``k`` these are.

    Parameters
    ----------
    t : the two knot vectors.
    c : control points, shape ``(n_u, n_v, 3)``.
    k : degree, one for both directions or a pair.
    where : what the sentence of an error begins with.

    Raises
    ------
    InputError
        Not two parameters, or numbers that make no sense.
    """
    if len(t) != 2:
        raise InputError(
            f"{where}: expected two knot vectors, those of a surface, found {len(t)}; "
            "give t = (t_u, t_v)"
        )
    degrees = np.atleast_1d(k)
    if degrees.shape not in ((1,), (2,)):
        raise InputError(
            f"{where}: expected one degree or two, found {degrees.size}; give k = (k_u, k_v)"
        )
    return checked_spline(int(degrees[0]), int(degrees[-1]), t[0], t[1], c, where=where)


def to_scipy(spline: TensorSpline) -> NdBSpline:
    """``NdBSpline`` with the same values; its ``t``, ``c`` and ``k`` are those of `from_scipy`.

    Raises
    ------
    InputError
        The surface is rational, which SciPy's splines cannot be.
    """
    if spline.weights is not None:
        raise InputError(
            "expected a surface without weights, got a rational one, which SciPy cannot hold; "
            "use geomdl, JSON, NPZ, STEP or IGES"
        )
    return NdBSpline(
        (spline.knots_u, spline.knots_v), spline.control_points, (spline.degree_u, spline.degree_v)
    )
