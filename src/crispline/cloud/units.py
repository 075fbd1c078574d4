"""In which unit a cloud may be."""

from __future__ import annotations

import numpy as np

from crispline.surface.base import Array

_SURVEY = 1e5
_PART_IN_METRES = 3.0
_PART_IN_MILLIMETRES = (8.0, 3000.0)


def guess_unit(low: Array, high: Array, spacing: float) -> tuple[str, str]:
    """A guess at the unit of length, and its reason; nothing in the program relies on it.

    Parameters
    ----------
    low, high : corners of the box about the points, shape ``(3,)``.
    spacing : mean distance between neighbouring points.

    Returns
    -------
    unit : ``mm``, ``m`` or ``unknown``.
    reason : half a sentence.

    Examples
    --------
    >>> guess_unit(np.zeros(3), np.array([120.0, 80.0, 40.0]), 0.5)[0]
    'mm'
    """
    size = float(np.linalg.norm(high - low))
    farthest = float(np.maximum(np.abs(low), np.abs(high)).max())
    if farthest > _SURVEY and size < 0.1 * farthest:
        return "m", f"coordinates up to {farthest:.3g} are those of a survey, kept in metres"
    longest = float((high - low).max())
    if abs(longest - 2.0) < 0.02 and np.all(np.abs(low + high) < 0.02):
        return "unknown", "the longest side is 2 about the origin: the cloud was normalised"
    if size < _PART_IN_METRES:
        return "m", f"{size:.3g} across with {spacing:.2g} between points is a part in metres"
    if _PART_IN_MILLIMETRES[0] <= size <= _PART_IN_MILLIMETRES[1]:
        return "mm", f"{size:.3g} across is a part in millimetres; in metres it were a building"
    return "unknown", f"{size:.3g} across is no usual size of a part, in millimetres or metres"
