"""Crescents at the corners of a prism are pieces of one cone about its bore."""

import numpy as np
import pytest
from witnessed import witnessed

from crispline.fit.plane import fit_plane
from crispline.options import RegionOptions
from crispline.region.fitting import fitted_region, held_fit
from crispline.region.narrow.pieces import shared_by_pieces
from crispline.surface import Cone, Cylinder

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
