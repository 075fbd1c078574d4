"""Table I of the paper, as published.

Lee, Quan, Wu, Wu, Tamir, Rishe: Optimizing B-Spline Surface Reconstruction for Sharp Feature
Preservation. Errors are over the mean distance of adjacent points. The paper does not say how
its edges lie relative to the rows of points, nor how many runs the numbers are from.
"""

from __future__ import annotations

from collections.abc import Mapping

from crispline.paper.windows import Feature

TABLE_I: Mapping[float, Mapping[Feature, tuple[float, float]]] = {
    0.0: {
        "straight": (0.3955, 0.0000),
        "lower circle": (0.3917, 0.0002),
        "upper circle": (0.3997, 0.0002),
        "corner": (0.4958, 0.0000),
    },
    0.005: {
        "straight": (0.3952, 0.0444),
        "lower circle": (0.3906, 0.0428),
        "upper circle": (0.3992, 0.0450),
        "corner": (0.4951, 0.0499),
    },
    0.01: {
        "straight": (0.3939, 0.0890),
        "lower circle": (0.3901, 0.0829),
        "upper circle": (0.3979, 0.0849),
        "corner": (0.4933, 0.0927),
    },
    0.02: {
        "straight": (0.3920, 0.2172),
        "lower circle": (0.3879, 0.2241),
        "upper circle": (0.3966, 0.2053),
        "corner": (0.4903, 0.2468),
    },
}
"""Noise level to feature to initial and final error. The paper reports 100 % correct detection."""
