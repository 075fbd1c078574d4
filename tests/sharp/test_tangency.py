"""Smooth borders that noise left open, closed by refitting the surfaces on both sides."""

import numpy as np
import pytest
from tangent_cylinder import fit_cylinder_tangent_to_planes

from crispline.fit.constrained import differences, estimate
from crispline.fit.cylinder import fit_cylinder
from crispline.fit.plane import fit_plane
from crispline.options import FitOptions, LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.tangency import Tangency, adjusted
from crispline.surface import Cone, Cylinder, Plane, Sphere, Torus

SIGMA = 0.2
LENGTH = 40.0


def rounded_edge(seed, radius=6.0, kink_deg=0.0, n_plane=3000, n_fillet=350):
    """Two planes and the fillet between them: fits to noisy points and the borders.

    ``kink_deg`` turns the first plane about its border, so that it is no longer tangent.
    """
    rng = np.random.default_rng(seed)
    y = rng.uniform(0.0, LENGTH, n_plane)
    away = rng.uniform(0.0, 60.0, n_plane)
    kink = np.radians(kink_deg)
    slope = np.array([-np.cos(kink), 0.0, -np.sin(kink)])
    top = np.array([-np.sin(kink), 0.0, np.cos(kink)])
    flats = [
        (radius * np.array([0.0, 0.0, 1.0]) + away[:, None] * slope + y[:, None] * [0, 1, 0], top),
        (np.column_stack([np.full(n_plane, radius), y, -away]), np.array([1.0, 0.0, 0.0])),
    ]
    swing = rng.uniform(0.0, np.pi / 2, n_fillet)
    normals = np.column_stack([np.sin(swing), np.zeros(n_fillet), np.cos(swing)])
    round_points = radius * normals + rng.uniform(0.0, LENGTH, n_fillet)[:, None] * [0, 1, 0]
    regions = {}
    for label, (points, normal) in enumerate(flats):
        noisy = points + SIGMA * rng.normal(size=(n_plane, 1)) * normal
        plane = fit_plane(noisy, np.tile(normal, (n_plane, 1)), SIGMA)
        regions[label] = RegionFit(plane, 1, noisy, plane.signed_distance(noisy))
    noisy = round_points + SIGMA * rng.normal(size=(n_fillet, 1)) * normals
    cylinder = fit_cylinder(noisy, normals, SIGMA)
    regions[2] = RegionFit(cylinder, 1, noisy, cylinder.signed_distance(noisy))
    along = np.arange(0.0, LENGTH + 1.0)
    lines = [
        np.column_stack([0 * along, along, 0 * along + radius]),
        np.column_stack([0 * along + radius, along, 0 * along]),
    ]
    vertices = np.concatenate(lines) + rng.uniform(-0.4, 0.4, (2 * len(along), 3))
    n = len(along)
    chains = (Chain(np.arange(n), 2, 0), Chain(np.arange(n, 2 * n), 1, 2))
    loops = {0: (((0, -1),),), 1: (((1, 1),),), 2: (((0, 1), (1, -1)),)}
    return Topology(chains, loops), vertices, regions


def touch(cylinder, plane):
    """How far a cylinder is from touching a plane: its turn and its gap."""
    height = abs(plane.normal @ (cylinder.origin - plane.origin))
    return abs(float(cylinder.axis @ plane.normal)), abs(height - cylinder.radius)


def closed(network, **options):
    return adjusted(*network, SIGMA, FitOptions(**options), LocateOptions())


def test_a_fillet_touches_its_planes_and_its_radius_improves():
    free, tied = [], []
    for seed in range(6):
        network = rounded_edge(seed)
        before = network[2]
        after = closed(network, regularize=False)
        gaps = [touch(before[2].surface, before[label].surface) for label in (0, 1)]
        assert max(max(gap) for gap in gaps) > 1e-3
        for label in (0, 1):
            assert max(touch(after[2].surface, after[label].surface)) < 1e-6
        free.append(before[2].surface.radius - 6.0)
        tied.append(after[2].surface.radius - 6.0)
        for label, fit in after.items():
            distances = fit.surface.signed_distance(before[label].points)
            assert np.allclose(fit.residuals, distances)
    assert np.linalg.norm(tied) < 0.7 * np.linalg.norm(free)


def test_firm_planes_give_the_rolling_ball():
    """Against the fit that keeps the planes and eliminates the tangency."""
    network = rounded_edge(11, n_plane=30000, n_fillet=100)
    after = closed(network, regularize=False)
    planes = [network[2][label].surface for label in (0, 1)]
    start = network[2][2]
    ball = fit_cylinder_tangent_to_planes(start.points, SIGMA, planes, start.surface)
    spread = abs(start.surface.radius - ball.radius)
    assert spread > 0.05
    assert after[2].surface.radius == pytest.approx(ball.radius, abs=0.2 * spread)


ORIGIN, UP = np.zeros(3), np.array([0.0, 0.0, 1.0])
LEANING = np.array([0.6, 0.0, 0.8])
KINDS = [
    Plane(ORIGIN, LEANING),
    Cylinder(ORIGIN, LEANING, 5.0),
    Sphere(ORIGIN, 5.0),
    Cone(-9.0 * UP, LEANING, 0.5),
    Torus(ORIGIN, LEANING, 6.0, 2.0),
]


@pytest.mark.parametrize("position", [0, 1])
@pytest.mark.parametrize("surface", KINDS, ids=lambda surface: surface.kind)
def test_the_derivatives_of_a_gap_are_its_differences(surface, position):
    rng = np.random.default_rng(8)
    points = surface.project(rng.uniform(2.0, 7.0, (60, 3)))[0]
    pair = [estimate(Plane(ORIGIN, UP), rng.normal(size=(60, 3)), SIGMA)] * 2
    pair[position] = estimate(surface, points, SIGMA)
    tangency = Tangency((0, 1), (1, -1), rng.uniform(2.0, 7.0, (9, 3)))
    found = tangency.derivatives(tuple(pair), position)
    assert found.shape == (9, len(pair[position].factor))
    np.testing.assert_allclose(found, differences(tangency, tuple(pair), position), atol=1e-7)


def test_a_kink_that_the_points_show_is_kept():
    network = rounded_edge(3, radius=25.0, kink_deg=6.0, n_fillet=1600)
    after = closed(network, regularize=False)
    cosine = float(after[0].surface.normal @ [0.0, 0.0, 1.0])
    assert np.degrees(np.arccos(cosine)) == pytest.approx(6.0, abs=0.3)
    assert max(touch(after[2].surface, after[1].surface)) < 1e-6


def test_regularities_are_part_of_it_unless_switched_off():
    network = rounded_edge(5)
    exact, free = closed(network), closed(network, regularize=False)
    assert abs(exact[0].surface.normal @ exact[1].surface.normal) < 1e-9
    assert abs(free[0].surface.normal @ free[1].surface.normal) > 1e-6
    assert isinstance(exact[0].surface, Plane)
    assert max(touch(exact[2].surface, exact[0].surface)) < 1e-6
