"""Crescents at the corners of a prism are pieces of one cone about its bore."""

import numpy as np
import pytest
from turned import turned
from witnessed import witnessed

from crispline.fit.plane import fit_plane
from crispline.options import RegionOptions
from crispline.region.fitting import fitted_region, held_fit
from crispline.region.narrow.pieces import bridged, shared_by_pieces
from crispline.surface import Cone, Cylinder, Plane

SIGMA = 0.15
N_SIDES, INRADIUS, BORE = 6, 30.0, 12.0
SLOPE = np.tan(np.radians(30.0))
AXIS = np.array([0.0, 0.0, 1.0])
OPTIONS = RegionOptions()


def nut(rise=(0.0,) * N_SIDES, slope=SLOPE, seed=0):
    """Patches of a bore (0) and of the crescents (1, 2, ...) that a cone cuts off a prism.

    Each crescent stands a ``rise`` above the cone. Its fit is the plane that its points tell.
    """
    turn, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 76)[:-1], np.arange(-20.0, 0.0))
    spoke = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=-1).reshape(-1, 3)
    points, normals = [BORE * spoke + height.reshape(-1, 1) * AXIS], [-spoke]
    label = [np.zeros(len(spoke), dtype=int)]
    half = np.pi / N_SIDES
    for k in range(N_SIDES):
        x, y = (part.ravel() for part in np.meshgrid(np.arange(28.5, 45.0), np.arange(-20.5, 20.0)))
        radius, angle = np.hypot(x, y), np.arctan2(y, x)
        aside = np.abs(np.abs(angle) - half)
        inside = (radius > INRADIUS) & (np.abs(angle) < half) & (radius * np.cos(aside) < INRADIUS)
        radius, angle = radius[inside], angle[inside] + 2.0 * k * half
        around = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
        z = rise[k] - slope * (radius - INRADIUS)
        points.append(radius[:, None] * around + z[:, None] * AXIS)
        normals.append((slope * around + AXIS) / np.hypot(slope, 1.0))
        label.append(np.full(len(radius), k + 1))
    points, normals, label = (np.concatenate(part) for part in (points, normals, label))
    evidence = witnessed(points, normals, np.empty((0, 2), dtype=int), SIGMA, seed)
    fits = {0: held_fit(Cylinder(np.zeros(3), AXIS, BORE), np.flatnonzero(label == 0), evidence)}
    for k in range(1, N_SIDES + 1):
        own = label[evidence.patch] == k
        plane = fit_plane(evidence.points[own], evidence.normals[own], SIGMA)
        fits[k] = fitted_region(plane, evidence.points[own], evidence.normals[own], True)
    return label, fits, evidence


@pytest.mark.parametrize("seed", range(3))
def test_crescents_get_the_cone_that_they_are_pieces_of(seed):
    label, fits, evidence = nut(seed=seed)
    found = shared_by_pieces(label, fits, evidence, OPTIONS)
    assert sorted(found) == list(range(1, N_SIDES + 1))
    cone = found[1].surface
    assert isinstance(cone, Cone)
    assert all(fit.surface is cone for fit in found.values())
    assert abs(float(cone.axis @ AXIS)) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(cone.apex, [0.0, 0.0, SLOPE * INRADIUS], atol=0.5)
    assert np.degrees(cone.half_angle) == pytest.approx(60.0, abs=1.0)
    assert all(fit.orientation == fits[name].orientation for name, fit in found.items())


def test_a_crescent_at_another_height_keeps_its_own_surface():
    label, fits, evidence = nut(rise=(0.0, 0.0, 0.3, 0.0, 0.0, 0.0))
    found = shared_by_pieces(label, fits, evidence, OPTIONS)
    assert sorted(found) == [1, 2, 4, 5, 6]


def test_two_are_too_few():
    label, fits, evidence = nut(rise=(0.0, 0.6, 1.2, 0.0, 1.8, 2.4))
    assert not shared_by_pieces(label, fits, evidence, OPTIONS)


def test_pieces_of_a_plane_across_the_axis_are_none_of_a_cone():
    label, fits, evidence = nut(slope=0.0)
    assert not shared_by_pieces(label, fits, evidence, OPTIONS)


def necked(stands_out):
    """Two pieces of a chamfer along an edge that stands so far out of it, and a gap between."""
    top, side, first, second = range(4)
    across = np.array([1.0, 0.0, 0.0])
    part = turned([(3.0, 0.0), (15.0, 0.0), (15.0, -12.0)], 60, is_straight=True)
    points = part.evidence.graph.points
    lean = np.sqrt(0.5) * (AXIS + across)
    chamfer = Plane(15.0 * across - stands_out * lean, lean)
    is_near = np.abs((points - 15.0 * across) @ lean) < 1.5
    label = part.face.copy()
    label[is_near & (points[:, 1] < 25.0)] = first
    label[is_near & (points[:, 1] > 34.0)] = second
    planes = {top: Plane(np.zeros(3), AXIS), side: Plane(15.0 * across, across)}
    fits = part.fits({**planes, first: chamfer, second: chamfer}, label)
    pieces = {name: fits[name] for name in (first, second)}
    return label, bridged(label, fits, pieces, part.evidence.graph, OPTIONS)


def test_pieces_are_one_over_a_neck_that_has_no_patches():
    label, new = necked(stands_out=0.4)
    assert not (new == 3).any()
    assert (new == 2)[(label == 2) | (label == 3)].all()
    between = (new == 2) & (label < 2)
    assert between.any()


@pytest.mark.parametrize("stands_out", [-0.3, 0.0, 0.05])
def test_pieces_that_touch_an_edge_or_leave_it_stay_apart(stands_out):
    label, new = necked(stands_out)
    np.testing.assert_array_equal(new, label)
