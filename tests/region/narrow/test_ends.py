"""A narrow blind bore whose floor was left with its wall."""

import numpy as np
import pytest
from witnessed import witnessed

from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.evidence import N_WITNESSES
from crispline.region.fitting import held_fit
from crispline.region.narrow.ends import with_ends
from crispline.surface import Cone, Cylinder, Plane, Torus

RADIUS, N_ROWS, N_SIDE, SIGMA = 2.5, 6, 4, 0.1
N_AROUND = 4 * N_SIDE
UP = np.array([0.0, 0.0, 1.0])
WALL, CRUMB = 0, 1


def bore(depth_of_tip=0.0, is_blind=True):
    """Vertices and quads of a bore along z, its floor at 0; the material is outside."""
    across = np.linspace(-1.0, 1.0, N_SIDE + 1)
    x, y = (axis.ravel() for axis in np.meshgrid(across, across, indexing="ij"))
    square = np.maximum(np.abs(x), np.abs(y))
    spread = np.where(square > 0.0, square / np.maximum(np.hypot(x, y), 1e-9), 0.0)
    floor = np.column_stack([x * spread, y * spread, depth_of_tip * (square - 1.0) / RADIUS])
    floor *= RADIUS
    number = np.arange(len(floor)).reshape(N_SIDE + 1, N_SIDE + 1)
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    wall = np.concatenate([floor[rim] + (row + 1) * UP for row in range(N_ROWS)])
    tubes = np.vstack([rim, len(floor) + np.arange(len(wall)).reshape(N_ROWS, -1)])
    low, high = tubes[:-1].ravel(), tubes[1:].ravel()
    after = [np.roll(row, -1, axis=1).ravel() for row in (tubes[:-1], tubes[1:])]
    sides = np.column_stack([low, high, after[1], after[0]])
    corners = [number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]]
    disc = np.column_stack([corner.ravel() for corner in corners])
    quads = np.concatenate([sides, disc]) if is_blind else sides
    return np.concatenate([floor, wall]), quads


def evidence(vertices, quads):
    corners = vertices[quads]
    normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    points = corners.mean(axis=1)
    net = half_edges(quads, len(vertices))
    return net, witnessed(points, normals, net.pairs(), SIGMA, seed=1)


def ended(vertices, quads, label=None, crumb=None):
    net, seen = evidence(vertices, quads)
    label = np.zeros(len(quads), dtype=np.int64) if label is None else label
    surfaces = {WALL: Cylinder(np.zeros(3), UP, RADIUS), CRUMB: crumb}
    fits = {
        name: held_fit(surfaces[name], np.flatnonzero(label == name), seen)
        for name in np.unique(label).tolist()
    }
    return with_ends(label, fits, vertices, net, seen, RegionOptions())


def is_floor(quads):
    return np.arange(len(quads)) >= N_ROWS * N_AROUND


def test_the_floor_of_a_narrow_blind_bore_is_a_face():
    vertices, quads = bore()
    label, fits = ended(vertices, quads)
    (name,) = set(fits) - {WALL}
    np.testing.assert_array_equal(label == name, is_floor(quads))
    floor = fits[name]
    assert isinstance(floor.surface, Plane)
    assert abs(floor.surface.normal @ UP) == 1.0
    assert np.abs(floor.surface.signed_distance(np.zeros((1, 3)))) < 0.05
    assert floor.orientation * floor.surface.normal[2] == 1.0  # out of the material
    assert len(fits[WALL].points) == N_WITNESSES * N_ROWS * N_AROUND


def test_a_drill_tip_is_a_cone():
    vertices, quads = bore(depth_of_tip=2.0)
    label, fits = ended(vertices, quads)
    (name,) = set(fits) - {WALL}
    assert (label == name)[is_floor(quads)].mean() > 0.9
    tip = fits[name].surface
    assert isinstance(tip, Cone)
    assert np.degrees(tip.half_angle) == pytest.approx(np.degrees(np.arctan2(2.5, 2.0)), abs=12.0)


def test_a_torus_that_is_floor_and_wall_becomes_the_floor():
    vertices, quads = bore()
    row = np.arange(len(quads)) // N_AROUND
    label = np.where((row == 0) | is_floor(quads), CRUMB, WALL)
    label, fits = ended(vertices, quads, label, Torus(0.8 * UP, UP, 1.6, 0.9))
    assert CRUMB not in fits
    (name,) = set(fits) - {WALL}
    assert isinstance(fits[name].surface, Plane)
    np.testing.assert_array_equal(label == name, is_floor(quads))


def test_a_bore_that_goes_through_is_sound():
    vertices, quads = bore(is_blind=False)
    label, fits = ended(vertices, quads)
    assert set(fits) == {WALL}
    assert not label.any()
