"""Regions that are given up because no face can be built for them."""

import numpy as np
import pytest

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.amend import without_narrow
from crispline.region.patches import PatchGraph
from crispline.region.segment import Segmentation

ROWS, COLUMNS = 24, 30
OPTIONS = RegionOptions()


@pytest.fixture(scope="module")
def sheet(nets):
    """A closed net of unit patches; its quads, its graph and where each patch lies."""
    faces = nets.grid(ROWS, COLUMNS, is_closed=True)
    quads = half_edges(faces, ROWS * COLUMNS)
    row, column = (a.ravel() for a in np.mgrid[:ROWS, :COLUMNS])
    points = np.column_stack([row, column, np.zeros(len(row))]).astype(float)
    normals = np.tile([0.0, 0.0, 1.0], (len(points), 1))
    return quads, PatchGraph(points, normals, quads.pairs(), 1.0), row, column


def lessened(sheet, inside, failing=(1,)):
    """What is left when region 1, between region 0 and the columns of region 2, fails."""
    quads, graph, _, column = sheet
    label = np.where(inside, 1, np.where(column >= 16, 2, 0))
    regions = Segmentation(label, {0: "left", 1: "groove", 2: "right"}, True)
    found = without_narrow(regions, failing, graph, quads, OPTIONS)
    return None if found is None else (found.label, found.fits)


def test_each_patch_of_a_groove_goes_to_the_side_it_lies_on(sheet):
    _, _, row, column = sheet
    groove = (np.abs(row - 12) < 5) & (column >= 13) & (column < 19)
    label, fits = lessened(sheet, groove)
    assert fits == {0: "left", 2: "right"}
    np.testing.assert_array_equal(label[groove], np.where(column[groove] < 16, 0, 2))
    np.testing.assert_array_equal(label[~groove], np.where(column[~groove] < 16, 0, 2))


def test_a_wide_region_stays(sheet):
    _, _, row, column = sheet
    assert lessened(sheet, (np.abs(row - 12) < 5) & (column >= 12) & (column < 19)) is None


def test_a_region_that_does_not_fail_stays(sheet):
    _, _, row, column = sheet
    groove = (np.abs(row - 12) < 5) & (column >= 13) & (column < 19)
    assert lessened(sheet, groove, failing=()) is None


def test_a_ring_that_is_narrow_but_long_stays(sheet):
    quads, graph, _, column = sheet
    options = RegionOptions(max_pruned_patches=50)
    groove = (column >= 13) & (column < 16)
    label = np.where(groove, 1, np.where(column >= 16, 2, 0))
    regions = Segmentation(label, {0: "left", 1: "groove", 2: "right"}, True)
    assert without_narrow(regions, [1], graph, quads, options) is None
    assert without_narrow(regions, [1], graph, quads, OPTIONS) is not None


def test_a_low_wall_elsewhere_stays(sheet):
    """A step has a wall of a few patches, fewer than a region that seeds find."""
    quads, graph, row, column = sheet
    groove = (np.abs(row - 12) < 5) & (column >= 13) & (column < 19)
    wall = (row < 4) & (np.abs(column - 24) < 1)
    assert 0 < wall.sum() < OPTIONS.min_patches
    label = np.where(wall, 3, np.where(groove, 1, np.where(column >= 16, 2, 0)))
    fits = {0: "left", 1: "groove", 2: "right", 3: "wall"}
    found = without_narrow(Segmentation(label, fits, True), [1], graph, quads, OPTIONS)
    assert found.fits == {0: "left", 2: "right", 3: "wall"}
    np.testing.assert_array_equal(found.label == 3, wall)
