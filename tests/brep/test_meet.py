"""Edges end at their vertices, also where the surfaces leave no common point."""

from dataclasses import replace

import brep_models
import numpy as np
import pytest

from crispline.brep.build import build_shape
from crispline.brep.check import check_shape
from crispline.brep.meet import meet_at_vertices
from crispline.curve import Line


def ends_of(model):
    """Distance of both ends of every edge from their vertices, shape ``(e, 2)``."""
    return np.array(
        [
            np.linalg.norm(edge.curve.samples(2) - model.vertices[[edge.start, edge.end]], axis=1)
            for edge in model.edges
        ]
    )


def with_vertex_moved(model, index, shift):
    vertices = model.vertices.copy()
    vertices[index] += shift
    gaps = np.array(model.vertex_gaps)
    gaps[index] = np.linalg.norm(shift)
    return replace(model, vertices=vertices, vertex_gaps=gaps)


def test_edges_that_meet_stay_as_they_are():
    model = brep_models.box_cylinder().model
    assert all(a is b for a, b in zip(meet_at_vertices(model).edges, model.edges, strict=True))


def test_a_vertex_beside_its_edges_moves_to_where_they_meet():
    model = brep_models.box().model
    moved = with_vertex_moved(model, 0, np.array([0.1, 0.2, -0.1]))
    met = meet_at_vertices(moved)
    np.testing.assert_allclose(met.vertices, model.vertices, atol=1e-12)
    assert all(edge.curve.kind == "line" for edge in met.edges)


def with_line_aside(model, distance):
    """One line of the corner at vertex 0 moved aside: no place suits all three."""
    index = next(i for i, edge in enumerate(model.edges) if 0 in (edge.start, edge.end))
    line = model.edges[index].curve
    aside = np.cross(line.direction, [0.6, 0.48, 0.64])
    origin = line.origin + distance * aside / np.linalg.norm(aside)
    shifted = Line(origin, line.direction, line.start, line.end)
    edges = list(model.edges)
    edges[index] = replace(edges[index], curve=shifted)
    return replace(model, edges=tuple(edges)), index


def test_lines_that_miss_their_vertex_are_bent_to_it_and_only_near_it():
    model, index = with_line_aside(brep_models.box().model, 0.2)
    met = meet_at_vertices(model)
    assert ends_of(met).max() < 1e-9
    line, bent = model.edges[index].curve, met.edges[index].curve
    assert bent.kind == "bspline"
    assert line.end - line.start > 10.0  # 5 units from the ends it is the line that it was
    np.testing.assert_allclose(bent.samples(3)[1], line.samples(3)[1], atol=1e-9)
    check = check_shape(build_shape(model).shape)
    assert check.is_good
    assert check.edge_tolerance == pytest.approx(0.2, abs=0.05)


def test_an_edge_far_from_its_vertex_is_left_alone():
    model, index = with_line_aside(brep_models.box().model, 4.0)
    assert meet_at_vertices(model).edges[index] is model.edges[index]
