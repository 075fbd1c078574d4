"""Crescents: faces between two half circles that touch, or nearly, at one end."""

import numpy as np
import pytest

from crispline.brep.compose import make_solid
from crispline.brep.cusps import with_cusps_opened
from crispline.cadfile.step import faces_lost_in_step
from crispline.curve import Circle, interpolated
from crispline.model import Edge, Face, Model
from crispline.surface import Plane

Z = np.eye(3)[2]
INNER, OUTER = 10.0, 15.0


def half_circle(radius, turn, is_backward=False):
    """From the origin, with its centre above it but for the turn."""
    towards = np.array([np.sin(turn), np.cos(turn), 0.0])
    if is_backward:
        return Circle(radius * towards, -Z, towards, radius, 0.0, np.pi)
    return Circle(radius * towards, Z, -towards, radius, 0.0, np.pi)


def crescent(turn, is_backward=False):
    """The smaller half circle turned so that it crosses the other again, if positive."""
    inner, outer = half_circle(INNER, turn), half_circle(OUTER, 0.0, is_backward)
    tops = [2.0 * INNER * np.array([np.sin(turn), np.cos(turn), 0.0]), [0.0, 2.0 * OUTER, 0.0]]
    line = interpolated(np.array(tops), False)
    ends = [(0, 1), (1, 2), (2, 0) if is_backward else (0, 2)]
    edges = tuple(
        Edge(curve, start, end, 0, -1, 0.0, 0.0, True)
        for curve, (start, end) in zip((inner, line, outer), ends, strict=True)
    )
    loop = ((2, -1 if is_backward else 1), (1, -1), (0, -1))
    face = Face(Plane(np.zeros(3), Z), 1, (loop,), np.zeros((0, 3)), np.zeros(0), 0)
    return Model(np.array([np.zeros(3), *tops]), np.zeros(3), edges, (face,))


@pytest.mark.parametrize("is_backward", [False, True])
@pytest.mark.parametrize("turn", [0.0005, 0.002, 0.01])
def test_circles_that_cross_again_beside_their_vertex_make_a_face_that_a_file_keeps(
    turn, is_backward
):
    solid = make_solid(crescent(turn, is_backward), None, 1.0, time_limit=0.0)
    assert (solid.attempt, solid.check.bad_faces) == ("cusps opened", ())
    assert faces_lost_in_step(solid.shape) == ()


@pytest.mark.parametrize("is_backward", [False, True])
def test_the_more_bent_edge_is_drawn_straight_to_the_vertex(is_backward):
    model = crescent(0.002, is_backward)
    opened = with_cusps_opened(model, [0])
    assert opened.edges[1:] == model.edges[1:]
    drawn = opened.edges[0].curve
    start, step = drawn.evaluate(drawn.start + np.array([0.0, 1e-6]))
    assert np.allclose(start, 0.0)
    # The chord of 2 spacings, and not the tangent of the circle.
    assert (step[1] - start[1]) / (step[0] - start[0]) == pytest.approx(1.0 / INNER, rel=0.3)
    # A chord of 2 leaves the circle by so much; the curve turns into the circle before its end.
    away = np.abs(np.linalg.norm(drawn.samples(500) - model.edges[0].curve.centre, axis=1) - INNER)
    assert 0.5 < away.max() / (2.0**2 / (8.0 * INNER)) < 1.0
    assert opened.edges[0].gap == pytest.approx(away.max(), rel=0.1)


def test_edges_that_part_at_once_stay():
    # The smaller circle runs into the larger one at an angle, and nowhere else.
    model = crescent(-0.02)
    assert with_cusps_opened(model, [0]).edges == model.edges


def test_faces_that_do_not_count_stay():
    model = crescent(0.002)
    assert with_cusps_opened(model, []).edges == model.edges
