"""Mean curvature at the patch centres (step 2 of the paper)."""

from __future__ import annotations

import numpy as np

from crispline.spline.catmull_clark import PatchCentres
from crispline.surface.base import Array


def curvature(centres: PatchCentres) -> Array:
    """Signed mean curvature of every patch at its centre, shape ``(m,)``, 1/length.

    ``H = (E N - 2 F M + G L) / (2 (E G - F^2))`` with the first fundamental
    form E, F, G and the second L, M, N (paper, section II). Positive where the
    surface bends towards its normal. Degenerate patches (parallel or zero
    tangents) get 0.
    """
    normal = centres.normal
    e, f, g = (
        np.einsum("ij,ij->i", a, b)
        for a, b in (
            (centres.du, centres.du),
            (centres.du, centres.dv),
            (centres.dv, centres.dv),
        )
    )
    second_l, second_m, second_n = (
        np.einsum("ij,ij->i", d, normal) for d in (centres.duu, centres.duv, centres.dvv)
    )
    metric = e * g - f * f
    regular = metric > 1e-12 * e * g
    numerator = e * second_n - 2.0 * f * second_m + g * second_l
    return np.where(regular, numerator / (2.0 * np.where(regular, metric, 1.0)), 0.0)
