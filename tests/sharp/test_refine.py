"""Refinement ends, whatever the constraints do."""

import numpy as np
import pytest

from crispline.options import LocateOptions
from crispline.sharp import refine
from crispline.surface import Cylinder


def test_refinement_stops_when_new_points_fall_on_old_ones(monkeypatch):
    """Two cylinders whose curve needs more nodes than are ever kept."""
    t = np.linspace(-1.0, 1.0, 40)
    curve = np.stack([4.0 * np.cos(t), 4.0 * np.sin(t), np.sqrt(100.0 - (4 * np.sin(t)) ** 2)], 1)
    pipes = [
        Cylinder(np.zeros(3), np.array([0.0, 0.0, 1.0]), 4.0),
        Cylinder(np.zeros(3), np.array([1.0, 0.0, 0.0]), 10.0),
    ]
    rounds = iter(range(50))
    kept = []

    def stubborn(points):
        if next(rounds, None) is None:
            pytest.fail("no end of the refinement")
        kept.append(distinct(points))
        return kept[min(1, len(kept) - 1)]  # the second call makes the first nodes

    distinct = refine._distinct
    monkeypatch.setattr(refine, "_distinct", stubborn)
    found = refine.curve_along(curve, (curve[0], curve[-1]), pipes, LocateOptions())
    assert len(kept) > 2
    np.testing.assert_allclose(found.samples(2), curve[[0, -1]], atol=1e-9)
