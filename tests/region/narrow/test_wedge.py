"""A ramp between two walls: where the walls are lower than a patch, and where they end."""

import numpy as np

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.narrow.wedge import with_wedges
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane

N = 40
RADIUS = 120.0
FLOOR, RAMP, WALL = 0, 1, 2
X, Y, Z = np.eye(3)
OPTIONS = RegionOptions()
TIP, SEEN = 6.0, 18.0  # where the ramp leaves the floor, and from where on patches show the wall


def scene():
    """Unit patches: a floor at y < 0, a ramp at y > 0 that rises for x > TIP, the wall between."""
    x, y = (grid.ravel() for grid in np.meshgrid(np.arange(N) + 0.5, np.arange(N) - 19.5))
    height = np.where((y > 0.0) & (x > TIP), (x - TIP) ** 2 / (2.0 * RADIUS), 0.0)
    points = np.column_stack([x, y, height])
    index = np.arange(N * N).reshape(N, N)
    pairs = np.concatenate(
        [
            np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
            np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
        ]
    )
    row, column = np.divmod(np.arange(N * N), N)
    corner = row * (N + 1) + column
    quads = np.column_stack([corner, corner + 1, corner + N + 2, corner + N + 1])
    label = np.where(y > 0.0, RAMP, FLOOR)
    label[(np.abs(y) < 4.5) & (x > SEEN)] = WALL
    graph = PatchGraph(points, np.tile(Z, (N * N, 1)), np.sort(pairs, axis=1), 1.0)
    surfaces = {
        FLOOR: Plane(np.zeros(3), Z),
        RAMP: Cylinder(np.array([TIP, 0.0, RADIUS]), Y, RADIUS),
        WALL: Plane(np.zeros(3), Y),
    }
    sides = {FLOOR: 1, RAMP: -1, WALL: -1}
    fits = {
        name: RegionFit(surface, sides[name], points[label == name], np.zeros(5))
        for name, surface in surfaces.items()
    }
    return graph, half_edges(quads, (N + 1) ** 2), label, fits


def test_the_wall_goes_on_to_where_it_is_lower_than_what_can_be_told():
    graph, net, label, fits = scene()
    new, grown = with_wedges(label, fits, graph, net, OPTIONS)
    assert grown == {WALL}
    ends = graph.points[new == WALL, 0]
    told = TIP + np.sqrt(2.0 * RADIUS * 0.25)  # a quarter of a spacing high
    assert abs(ends.min() - told) < 2.0
    assert (new[label == WALL] == WALL).all()
    touching = np.sort(new[graph.pairs], axis=1) == (FLOOR, RAMP)
    places = graph.points[graph.pairs[touching.all(axis=1)]].mean(axis=1)
    assert places[:, 0].max() < told + 2.0


def test_faces_that_meet_get_no_wall():
    graph, net, label, fits = scene()
    flat = Plane(np.zeros(3), Z)
    fits[RAMP] = RegionFit(flat, 1, fits[RAMP].points, fits[RAMP].residuals)
    new, grown = with_wedges(label, fits, graph, net, OPTIONS)
    assert grown == set()
    np.testing.assert_array_equal(new, label)


def test_a_wall_elsewhere_does_not_jump_in():
    graph, net, label, fits = scene()
    fits[WALL] = RegionFit(Plane(8.0 * Y, Y), -1, fits[WALL].points, fits[WALL].residuals)
    new, grown = with_wedges(label, fits, graph, net, OPTIONS)
    assert grown == set()
    np.testing.assert_array_equal(new, label)
