"""Primitives that grow over a sheet of patches bent along a line."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from crispline.fit.choose import PRIMITIVE_FITS
from crispline.region.grow import Ground
from crispline.surface import Plane

N = 20


def ground(bend_deg, min_share=0.8):
    """A grid of N x N patches, its halves at an angle to each other."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(N) - (N - 1) / 2, np.arange(N)))
    slope = np.tan(np.radians(bend_deg)) * (x > 0.0)
    points = np.column_stack([x, y, -slope * x])
    normals = np.column_stack([slope, np.zeros(N * N), np.ones(N * N)])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    near = np.abs(points[:, None, :2] - points[None, :, :2]).sum(axis=2) == 1.0
    free = np.ones(N * N, dtype=bool)
    cosine = float(np.cos(np.radians(10.0)))
    return Ground(points, normals, csr_array(near * 1.0), free, 0.1, cosine, min_share, 6)


@pytest.mark.parametrize("bend_deg", [8.0, 30.0])
def test_a_plane_grows_up_to_the_bend(bend_deg):
    sheet = ground(bend_deg)
    left = sheet.points[:, 0] < 0.0
    seeds = np.flatnonzero(sheet.points[:, 0] < -6.0)
    found = sheet.grown(PRIMITIVE_FITS["plane"], seeds)
    beyond = np.count_nonzero(~left[found.patches])
    assert np.isin(np.flatnonzero(left), found.patches).all()
    assert beyond <= 3 * N  # of 10 N: those within 3 sigma of the plane, which tilts a little
    assert found.worth <= len(found.patches)
    assert found.worth == pytest.approx(len(found.patches), rel=0.15)


def test_it_does_not_cross_what_is_taken():
    sheet = ground(0.0)
    seeds = np.flatnonzero(sheet.points[:, 0] < -6.0)
    assert len(sheet.grown(PRIMITIVE_FITS["plane"], seeds).patches) == N * N
    wall = np.flatnonzero(sheet.points[:, 0] == 0.5)
    found = sheet.without(wall).grown(PRIMITIVE_FITS["plane"], seeds)
    assert np.array_equal(found.patches, np.flatnonzero(sheet.points[:, 0] < 0.0))
    assert sheet.is_free.all()


def test_seeds_on_both_sides_of_a_bend_have_no_plane():
    sheet = ground(60.0)
    seeds = np.flatnonzero(np.abs(sheet.points[:, 0]) < 4.0)
    assert sheet.grown(PRIMITIVE_FITS["plane"], seeds) is None


def test_support_of_a_surface_that_misses_the_seeds_is_what_it_hits_of_them():
    sheet = ground(60.0)
    flat = Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    seeds = np.flatnonzero(sheet.points[:, 0] > -1.0)
    patches, worth = sheet.support(flat, seeds)
    assert np.array_equal(patches, seeds[sheet.points[seeds, 0] < 0.0])
    assert worth == pytest.approx(len(patches))
