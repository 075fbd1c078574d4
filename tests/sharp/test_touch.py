"""``locate`` on a nut whose chamfer touches its sides, or nearly so."""

import numpy as np
import pytest

SIDES, CONES, END, BASE = range(6), range(6, 12), 12, 13
APOTHEM = 45.0


def counts(model):
    return len(model.vertices), len(model.edges), len(model.faces)


def at_the_end(model):
    """Vertices of the end face."""
    edges = [model.edges[index] for index, _ in model.faces[END].loops[0]]
    return model.vertices[sorted({vertex for edge in edges for vertex in (edge.start, edge.end)})]


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (0.6, 1)])
@pytest.mark.parametrize("inside", [0.0, 0.03, 0.2])
def test_pieces_of_a_cone_that_reach_a_side_or_nearly_do_meet_there(
    shapes, raggedness, seed, inside
):
    model, notes = shapes["nut"](raggedness, seed, inside=inside).located()
    assert counts(model) == (18, 30, 14)
    middles = at_the_end(model)
    assert len(middles) == 6
    np.testing.assert_allclose(np.hypot(middles[:, 0], middles[:, 1]), APOTHEM, atol=inside + 0.01)
    assert model.vertex_gaps.max() < inside + 1e-3
    assert not notes


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (0.6, 1)])
@pytest.mark.parametrize("lost", [4.0, 7.0])
def test_pieces_of_a_cone_that_crosses_a_side_end_where_it_does(shapes, raggedness, seed, lost):
    inside = -0.2
    model, notes = shapes["nut"](raggedness, seed, inside=inside, lost=lost).located()
    assert counts(model) == (24, 36, 14)
    ends = at_the_end(model)
    # Cone and edge cross at five degrees: a place on all surfaces is good enough.
    np.testing.assert_allclose(np.hypot(ends[:, 0], ends[:, 1]), APOTHEM - inside, atol=0.1)
    assert model.vertex_gaps.max() < 0.1
    assert not notes


@pytest.mark.parametrize("inside", [-1.5, -2.0])
def test_a_long_edge_between_two_crossings_stays(shapes, inside):
    lost = float(np.sqrt((APOTHEM - inside) ** 2 - APOTHEM**2))
    model, _ = shapes["nut"](0.6, 0, inside=inside, lost=lost).located()
    assert counts(model) == (24, 36, 14)
    assert model.vertex_gaps.max() < 1e-6
