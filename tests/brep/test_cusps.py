"""Edges that leave a vertex side by side, with known curves."""

import numpy as np
import pytest

from crispline.brep.cusps import cusp_gaps
from crispline.curve import interpolated
from crispline.model import Edge, Face, Model
from crispline.surface import Plane


def leaf(bend, hook=0.0):
    """A face between two curves of one end: a straight one and a parabola, which may hook."""
    t = np.linspace(0.0, 20.0, 400)
    upper = np.stack([t, bend * t**2 - hook * t * np.exp(-3.0 * t), 0.0 * t], axis=1)
    tip, far, top = np.zeros(3), np.array([20.0, 0.0, 0.0]), upper[-1]
    curves = [interpolated(np.stack([tip, far]), False), interpolated(np.stack([far, top]), False)]
    curves.append(interpolated(upper[::-1], False))
    ends = [(0, 1), (1, 2), (2, 0)]
    edges = tuple(
        Edge(curve, start, end, 0, -1, 0.0, 0.0, True)
        for curve, (start, end) in zip(curves, ends, strict=True)
    )
    loop = tuple((k, 1) for k in range(3))
    face = Face(Plane(np.zeros(3), np.eye(3)[2]), 1, (loop,), np.zeros((0, 3)), np.zeros(0), 0)
    return Model(np.stack([tip, far, top]), np.zeros(3), edges, (face,))


@pytest.mark.parametrize("bend", [0.01, 0.1])
def test_a_vertex_covers_where_two_edges_cannot_be_told_apart(bend):
    gaps = cusp_gaps(leaf(bend), [0])
    # A parabola leaves its tangent by bend * x**2.
    assert gaps[0] == pytest.approx(np.sqrt(1e-4 / bend), abs=0.01)
    assert gaps[1] == gaps[2] == 0.0


def test_a_vertex_covers_a_crossing_beside_it():
    hook, bend = 0.02, 0.05
    crossing = cusp_gaps(leaf(bend, hook), [0])[0]
    x = np.linspace(0.01, 1.0, 10001)
    true = x[np.flatnonzero(np.diff(np.sign(bend * x - hook * np.exp(-3.0 * x))))[0]]
    assert true < crossing < true + 0.03


def test_edges_at_an_angle_need_nothing():
    model = leaf(0.01)
    turned = leaf(0.01, hook=-2.0)
    assert cusp_gaps(turned, [0])[0] == 0.0
    assert cusp_gaps(model, [0])[0] > 0.0
