"""The colours of reports and figures: kinds of faces, kinds of patches, deviation."""

from __future__ import annotations

import numpy as np

from crispline.exchange.palette import KIND_COLOURS as OF_KIND

KINDS = ("plane", "cylinder", "cone", "sphere", "torus", "revolution", "bspline", "other")
"""Kinds of faces in the order of the legend."""
KIND_COLOURS = tuple(OF_KIND.get(kind, "#b4bcc3") for kind in KINDS)
"""Of the faces, in the order of :data:`KINDS`; the same as in the files."""
PATCH_COLOURS = ("#cfd6dc", "#efcf78", "#d8503f")
"""Of flat, curved and sharp patches."""
RAMP = ("#1f4e9c", "#5d9bd1", "#c9ced2", "#e8935c", "#a8261c")
"""Deviations from inside to outside; the middle is on the model."""


def kind_index(kind: str) -> int:
    """Place of a kind of face in the legend; unknown kinds are ``other``."""
    return KINDS.index(kind) if kind in KINDS else len(KINDS) - 1


def ramp_colour(share: float) -> str:
    """Colour of a deviation as a share of the range, -1 to 1.

    >>> ramp_colour(-1.0), ramp_colour(0.0), ramp_colour(9.0)
    ('#1f4e9c', '#c9ced2', '#a8261c')
    """
    stops = np.array([[int(stop[i : i + 2], 16) for i in (1, 3, 5)] for stop in RAMP])
    place = np.linspace(-1.0, 1.0, len(stops))
    mixed = [round(float(np.interp(share, place, stops[:, i]))) for i in range(3)]
    return "#{:02x}{:02x}{:02x}".format(*mixed)
