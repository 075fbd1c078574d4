"""Length units: what the numbers of a shape or a file mean."""

from __future__ import annotations

from collections.abc import Mapping

from crispline.errors import InputError

MILLIMETRES: Mapping[str, float] = {
    "mm": 1.0,
    "um": 1e-3,
    "cm": 10.0,
    "m": 1e3,
    "km": 1e6,
    "in": 25.4,
    "mil": 0.0254,
    "ft": 304.8,
}
"""Millimetres in every unit that a file may be written in."""

OCCT_NAMES: Mapping[str, str] = {name: name.upper() for name in MILLIMETRES} | {"in": "INCH"}
"""What OCCT's settings call them."""

STEP_NAMES: Mapping[str, str] = {
    "millimetre": "mm",
    "micrometre": "um",
    "centimetre": "cm",
    "metre": "m",
    "kilometre": "km",
    "inch": "in",
    "mil": "mil",
    "foot": "ft",
}
"""Names of units in STEP files, and ours."""


def checked_unit(unit: str) -> str:
    """The unit, if it is one of `MILLIMETRES`; else an `InputError`."""
    if unit not in MILLIMETRES:
        raise InputError(
            f"expected a length unit out of {', '.join(MILLIMETRES)}, got '{unit}'; choose one"
        )
    return unit
