"""Corners: acceptance and what replaces a corner that is not accepted."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.options import LocateOptions
from crispline.sharp.corner import locate_corner
from crispline.surface import Cone, Cylinder, Plane, Sphere, unit
from crispline.surface.intersect import intersect

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
OPTIONS = LocateOptions()


def corner_of(surfaces, net_vertex, cloud=((0.0, 0.0, 0.0),), contacts=()):
    return locate_corner(
        np.array(net_vertex), surfaces, contacts, cKDTree(np.array(cloud)), 1.6, OPTIONS
    )


def test_three_planes_meet_in_their_point():
    planes = [Plane(ORIGIN, X), Plane(ORIGIN, Y), Plane(ORIGIN, Z)]
    corner = corner_of(planes, [1.0, -2.0, 0.5])
    np.testing.assert_allclose(corner.position, 0.0, atol=1e-12)
    assert corner.gap < 1e-12
    assert not corner.is_fallback


def test_an_exact_corner_may_be_far_from_the_net():
    planes = [Plane(ORIGIN, X), Plane(ORIGIN, Y), Plane(ORIGIN, Z)]
    assert not corner_of(planes, [8.0, 0.0, 0.0]).is_fallback
    assert corner_of(planes, [16.0, 0.0, 0.0]).is_fallback


def test_a_corner_off_the_cloud_is_refused():
    planes = [Plane(ORIGIN, X), Plane(ORIGIN, Y), Plane(ORIGIN, Z)]
    corner = corner_of(planes, [1.0, 1.0, 1.0], cloud=[[0.0, 0.0, 1.7]])
    assert corner.is_fallback


def test_nearly_dependent_planes_do_not_throw_the_corner_away():
    # The third plane all but contains the line of the first two: they meet 10 spacings off.
    third = unit(np.array([1.0, 1.0, 0.02]))
    planes = [Plane(ORIGIN, X), Plane(ORIGIN, Y), Plane(0.2 * third, third)]
    corner = corner_of(planes, [0.3, -0.2, 0.0])
    assert np.linalg.norm(corner.position) < 1.0
    assert corner.gap < 0.2


def test_four_planes_nearly_through_a_point_meet_in_the_least_squares_point():
    normals = unit(np.array([[1.0, 0, 1], [-1, 0, 1], [0, 1, 1], [0, -1, 1]]))
    planes = [Plane(0.1 * k * n, n) for k, n in enumerate(normals)]
    corner = corner_of(planes, [0.5, 0.5, 0.5])
    offsets = np.array([plane.origin @ plane.normal for plane in planes])
    expected = np.linalg.lstsq(normals, offsets, rcond=None)[0]
    np.testing.assert_allclose(corner.position, expected, atol=1e-9)
    residuals = np.abs(normals @ expected - offsets)
    assert corner.gap == pytest.approx(residuals.max(), abs=1e-9)
    assert not corner.is_fallback


def test_without_a_common_point_the_corner_stays_between_surfaces_and_net():
    planes = [Plane(ORIGIN, X), Plane(2.0 * X, X), Plane(ORIGIN, Z)]
    corner = corner_of(planes, [0.5, 0.0, 0.5])
    assert corner.is_fallback
    assert corner.gap == pytest.approx(1.0, abs=0.05)
    assert np.linalg.norm(corner.position - [0.5, 0.0, 0.5]) < 1.0


def test_hopeless_surfaces_leave_the_net_vertex():
    planes = [Plane(20.0 * X, X), Plane(ORIGIN, Y), Plane(ORIGIN, Z)]
    corner = corner_of(planes, [0.5, 0.25, 0.0])
    np.testing.assert_array_equal(corner.position, [0.5, 0.25, 0.0])
    assert corner.is_fallback
    assert corner.gap == pytest.approx(19.5)


@pytest.mark.parametrize("seed", range(5))
def test_newton_finds_a_common_point_of_curved_surfaces(seed):
    rng = np.random.default_rng(seed)
    point = rng.normal(size=3) * 10.0
    axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    surfaces = [
        Sphere(point + 9.0 * axes[0], 9.0),
        Cylinder(point + 6.0 * axes[1], axes[0], 6.0),
        Plane(point, axes[2]),
    ]
    found, gap = intersect(point + rng.normal(size=(20, 3)) * 0.3, surfaces)
    assert gap.max() < 1e-9
    for surface in surfaces:
        np.testing.assert_allclose(surface.project(found)[0], found, atol=1e-9)


def test_newton_takes_the_shortest_way():
    # Onto two perpendicular planes, the nearest common point is the orthogonal projection.
    found, _ = intersect(np.array([[3.0, 4.0, 5.0]]), [Plane(ORIGIN, X), Plane(ORIGIN, Y)])
    np.testing.assert_allclose(found, [[0.0, 0.0, 5.0]], atol=1e-12)


def test_surfaces_that_barely_cross_are_met_in_their_mean():
    tilted = unit(np.array([0.01, 0.0, 1.0]))
    planes = [Plane(ORIGIN, Z), Plane(0.2 * Z, tilted)]
    found, gap = intersect(np.array([[0.0, 0.0, 1.0]]), planes)
    np.testing.assert_allclose(found, [[0.0, 0.0, 0.1]], atol=5e-3)
    assert gap[0] == pytest.approx(0.1, abs=5e-3)


def test_newton_survives_a_cone_apex():
    cone = Cone(ORIGIN, Z, np.radians(30.0))
    found, gap = intersect(np.array([[0.0, 0.0, -2.0]]), [cone, Plane(ORIGIN, Z)])
    assert np.isfinite(found).all()
    assert np.isfinite(gap).all()
