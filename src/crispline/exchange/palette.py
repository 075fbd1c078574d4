"""Colours of the kinds of faces, the same in every file and picture."""

from __future__ import annotations

from collections.abc import Mapping

KIND_COLOURS: Mapping[str, str] = {
    "plane": "#8fb3d9",
    "cylinder": "#9fd3a5",
    "cone": "#e6c27a",
    "sphere": "#d9a0c0",
    "torus": "#b5a3dc",
    "revolution": "#8ecfcb",
    "bspline": "#f0a884",
    "patch": "#f0a884",
}
_OTHER = "#c9d3dd"


def kind_colour(kind: str) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 (sRGB); grey for a kind without a colour of its own."""
    digits = KIND_COLOURS.get(kind, _OTHER)[1:]
    red, green, blue = (int(digits[i : i + 2], 16) / 255.0 for i in (0, 2, 4))
    return red, green, blue
