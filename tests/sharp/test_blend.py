"""A free-form face that passes smoothly into a plane."""

from dataclasses import replace

import numpy as np

from crispline.fit.bspline import fit_bspline_surface
from crispline.fit.plane import fit_plane
from crispline.options import FitOptions, LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.blend import blended
from crispline.surface import Plane

SIGMA = 0.2
SIZE = 30.0


def swell(seed):
    """A plane for x < 0 and a swell that leaves it with its slope at x = 0: fits and border."""
    rng = np.random.default_rng(seed)
    x, y = rng.uniform(-SIZE, SIZE, 2400), rng.uniform(0.0, SIZE, 2400)
    bend = 0.012 + 0.004 * np.sin(y / 6.0)
    z = np.where(x > 0.0, bend * x**2, 0.0)
    slope_x = np.where(x > 0.0, 2.0 * bend * x, 0.0)
    slope_y = np.where(x > 0.0, 0.004 / 6.0 * np.cos(y / 6.0) * x**2, 0.0)
    normals = np.column_stack([-slope_x, -slope_y, np.ones(len(x))])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = np.column_stack([x, y, z]) + SIGMA * rng.normal(size=(len(x), 1)) * normals
    flat, free = x < -0.8, x > 0.8
    plane = fit_plane(points[flat], normals[flat], SIGMA)
    spline = fit_bspline_surface(points[free], normals[free], SIGMA, FitOptions())
    regions = {
        0: RegionFit(plane, 1, points[flat], plane.signed_distance(points[flat])),
        1: RegionFit(spline, 1, points[free], spline.signed_distance(points[free])),
    }
    along = np.arange(0.0, SIZE + 1.0)
    vertices = np.column_stack([0.0 * along, along, 0.0 * along])
    vertices += rng.uniform(-0.3, 0.3, vertices.shape)
    chain = Chain(np.arange(len(along)), 0, 1)
    return Topology((chain,), {0: (((0, 1),),), 1: (((0, -1),),)}), vertices, regions


def border_errors(regions):
    """Largest gap and kink between the two surfaces along the true border."""
    y = np.linspace(2.0, SIZE - 2.0, 50)
    line = np.column_stack([0.0 * y, y, 0.0 * y])
    (foot, normal), (other, other_normal) = (regions[i].surface.project(line) for i in (0, 1))
    gap = np.linalg.norm(foot - other, axis=1).max()
    kink = np.degrees(np.arccos(np.clip(np.einsum("ij,ij->i", normal, other_normal), -1, 1))).max()
    return gap, kink


def test_the_join_closes_and_the_kink_shrinks():
    for seed in range(3):
        topology, vertices, regions = swell(seed)
        after = blended(topology, vertices, regions, SIGMA, FitOptions(), LocateOptions())
        gap_before, kink_before = border_errors(regions)
        gap, kink = border_errors(after)
        assert gap < min(0.02, 0.2 * gap_before)
        assert kink < max(0.5, 0.5 * kink_before)
        assert after[0] is regions[0]
        fit = after[1]
        assert np.std(fit.residuals) < 1.05 * SIGMA
        assert np.allclose(fit.residuals, fit.surface.signed_distance(fit.points))


def test_a_sharp_border_is_left_alone():
    topology, vertices, regions = swell(0)
    tilt = np.radians(40.0)
    regions[0] = replace(
        regions[0], surface=Plane(np.zeros(3), np.array([np.sin(tilt), 0.0, np.cos(tilt)]))
    )
    after = blended(topology, vertices, regions, SIGMA, FitOptions(), LocateOptions())
    assert after[1] is regions[1]
