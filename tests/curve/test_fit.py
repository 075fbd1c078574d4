"""Curves through points: exact on lines and circles, fourth order elsewhere."""

import numpy as np
import pytest

from crispline.curve import (
    arc_length,
    circle_through,
    interpolated,
    line_through,
    resampled,
    smoothed,
)
from crispline.surface import perpendicular_frame, unit

AXIS = unit(np.array([1.0, 2.0, -0.5]))
CENTRE = np.array([30.0, -20.0, 10.0])


def circle(radius, start, end, n):
    x, y = perpendicular_frame(AXIS)
    angle = np.linspace(start, end, n)[:, None]
    return CENTRE + radius * (np.cos(angle) * x + np.sin(angle) * y)


def helix(t):
    return np.column_stack([5.0 * np.cos(t), 5.0 * np.sin(t), 2.0 * t])


@pytest.mark.parametrize("span", [0.2, 1.0, 3.0, 6.0, -0.2, -6.0])
def test_an_arc_is_recovered(span):
    points = circle(12.0, 0.3, 0.3 + span, 40)
    arc = circle_through(points, 1e-9, is_closed=False)
    assert arc is not None
    np.testing.assert_allclose(arc.centre, CENTRE, atol=1e-8)
    np.testing.assert_allclose(arc.normal, np.sign(span) * AXIS, atol=1e-8)
    assert arc.radius == pytest.approx(12.0, abs=1e-8)
    assert arc.end == pytest.approx(abs(span), abs=1e-8)
    np.testing.assert_allclose(arc.samples(40), points, atol=1e-9)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_full_circle_runs_as_its_points_do(direction):
    points = circle(7.0, 0.0, direction * 2.0 * np.pi, 30)
    full = circle_through(points, 1e-9, is_closed=True)
    assert full is not None
    assert full.end - full.start == 2.0 * np.pi
    np.testing.assert_allclose(full.samples(30), points, atol=1e-9)


def test_neither_a_line_nor_a_helix_is_a_circle():
    assert circle_through(np.outer(np.arange(5.0), AXIS), 1e-6, is_closed=False) is None
    assert circle_through(helix(np.linspace(0.0, 3.0, 30)), 1e-6, is_closed=False) is None


def test_a_line_is_recovered_and_a_bend_is_not():
    points = CENTRE + np.outer(np.array([0.0, 1.0, 5.0]), AXIS)
    line = line_through(points, 1e-12)
    assert line is not None
    np.testing.assert_allclose(line.samples(2), points[[0, -1]], atol=1e-12)
    points[1] += 1e-3
    assert line_through(points, 1e-6) is None
    assert line_through(np.zeros((3, 3)), 1.0) is None


def test_interpolation_passes_its_points_and_ends_at_control_points():
    points = helix(np.array([0.0, 0.3, 0.5, 1.2, 1.5, 2.0]))
    curve = interpolated(points, is_closed=False)
    np.testing.assert_allclose(curve.evaluate(arc_length(points)), points, atol=1e-12)
    np.testing.assert_allclose(curve.control_points[[0, -1]], points[[0, -1]], atol=1e-12)
    assert len(curve.knots) == len(curve.control_points) + 4


def test_two_points_give_a_straight_spline():
    curve = interpolated(np.array([[0.0, 0, 0], [0, 3.0, 4.0]]), is_closed=False)
    np.testing.assert_allclose(
        curve.samples(3), [[0, 0, 0], [0, 1.5, 2.0], [0, 3.0, 4.0]], atol=1e-12
    )


def test_a_closed_spline_is_smooth_across_its_seam():
    t = np.linspace(0.0, 2.0 * np.pi, 17)
    points = np.column_stack([8.0 * np.cos(t), 5.0 * np.sin(t), np.sin(2.0 * t)])
    points[-1] = points[0]
    curve = interpolated(points, is_closed=True)
    step = 1e-4
    at = np.array([curve.start, curve.start + step, curve.start + 2 * step])
    head = curve.evaluate(at)
    tail = curve.evaluate(curve.end - at + curve.start)
    np.testing.assert_allclose(head[0], tail[0], atol=1e-12)
    np.testing.assert_allclose((head[1] - head[0]) / step, (tail[0] - tail[1]) / step, atol=1e-3)
    second = [(p[0] - 2.0 * p[1] + p[2]) / step**2 for p in (head, tail)]
    np.testing.assert_allclose(second[0], second[1], atol=1e-2)


@pytest.mark.parametrize("with_tangents", [True, False])
def test_interpolation_converges(with_tangents):
    def error(n):
        t = np.linspace(0.0, 2.0, n)
        tangent = np.array([[0.0, 5.0, 2.0], [-5.0 * np.sin(2.0), 5.0 * np.cos(2.0), 2.0]])
        ends = unit(tangent) if with_tangents else None
        samples = interpolated(helix(t), is_closed=False, ends=ends).samples(997)
        radius = np.hypot(samples[:, 0], samples[:, 1])
        return np.abs(radius - 5.0).max()

    order = np.log2(error(11) / error(21))
    assert order > (3.7 if with_tangents else 2.7)


def test_polyline_tools():
    corner = np.array([[0.0, 0, 0], [3.0, 0, 0], [3.0, 4.0, 0]])
    np.testing.assert_array_equal(arc_length(corner), [0.0, 3.0, 7.0])
    np.testing.assert_allclose(resampled(corner, 8)[3], [3.0, 0.0, 0.0])
    zigzag = np.column_stack([np.arange(20.0), np.tile([0.5, -0.5], 10), np.zeros(20)])
    smooth = smoothed(zigzag, 12, is_closed=False)
    np.testing.assert_array_equal(smooth[[0, -1]], zigzag[[0, -1]])
    assert np.abs(smooth[5:-5, 1]).max() < 0.05
    ring = circle(10.0, 0.0, 2.0 * np.pi, 31)
    ring[-1] = ring[0]
    np.testing.assert_array_equal(smoothed(ring, 5, is_closed=True)[0], smoothed(ring, 5, True)[-1])
