"""Curves that edges lie on: exact geometry, no OCCT."""

from crispline.curve.curves import BSplineCurve, Circle, Curve, Line
from crispline.curve.fit import circle_through, interpolated, line_through
from crispline.curve.polyline import arc_length, resampled, smoothed, straight_at

__all__ = [
    "BSplineCurve",
    "Circle",
    "Curve",
    "Line",
    "arc_length",
    "circle_through",
    "interpolated",
    "line_through",
    "resampled",
    "smoothed",
    "straight_at",
]
