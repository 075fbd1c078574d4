"""The floor of a counterbore, two patches wide and broken through, on a net about the axis."""

from types import SimpleNamespace

import numpy as np
import pytest

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.narrow.coaxial import broken_rings
from crispline.region.narrow.restore import closed_rings
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Plane

ROWS, COLUMNS = 24, 60
BORE, FLOOR, WALL = 0, 1, 2
Z = np.eye(3)[2]
OPTIONS = RegionOptions()


def counterbore(nets, gap, wide=10.2):
    """Evidence, the labels as they should be, and with a floor that misses some columns."""
    quads = half_edges(nets.grid(ROWS, COLUMNS, is_closed=True), ROWS * COLUMNS)
    row, column = (a.ravel() for a in np.mgrid[:ROWS, :COLUMNS])
    # Ten rows of bore, two of floor, ten of wall; the last two close the net far off.
    radius = np.select([row < 10, row == 10, row == 11, row < 22], [8.0, 8.6, 9.6, wide], 30.0)
    height = np.select([row < 10, row < 12, row < 22], [row - 10.0, 0.0 * row, row - 11.0], 5.0)
    turn = 2.0 * np.pi * column / COLUMNS
    points = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), height])
    graph = PatchGraph(points, np.tile(Z, (len(points), 1)), quads.pairs(), 1.0)
    whole = np.select([row < 10, row < 12, row < 22], [BORE, FLOOR, WALL], 3)
    broken = whole.copy()
    is_gap = (whole == FLOOR) & (column < gap)
    broken[is_gap] = np.where(row[is_gap] == 10, BORE, WALL)
    return SimpleNamespace(graph=graph), whole, broken


def fits(wide=10.2):
    surfaces = (Cylinder(np.zeros(3), Z, 8.0), Plane(np.zeros(3), Z), Cylinder(0.0 * Z, Z, wide))
    nothing = np.empty((0, 3)), np.empty(0)
    return {name: RegionFit(surface, 1, *nothing) for name, surface in enumerate(surfaces)}


@pytest.mark.parametrize("gap", [1, 3])
def test_a_floor_through_which_the_walls_touch_is_closed(nets, gap):
    evidence, whole, broken = counterbore(nets, gap)
    rings = broken_rings(broken, fits(), evidence, OPTIONS)
    assert list(rings) == [FLOOR]
    np.testing.assert_array_equal(closed_rings(broken, rings, evidence.graph, OPTIONS), whole)


def test_a_whole_floor_is_none_of_them(nets):
    evidence, whole, _ = counterbore(nets, 0)
    assert broken_rings(whole, fits(), evidence, OPTIONS) == {}


def test_walls_of_one_radius_may_touch(nets):
    """What is between them is a groove or a collar, and need not go round."""
    evidence, _, broken = counterbore(nets, 3)
    assert broken_rings(broken, fits(wide=8.4), evidence, OPTIONS) == {}
