"""Rims: corners where straight stretches meet, and the simplest curve on the surface."""

import numpy as np
import pytest

from crispline.options import LocateOptions
from crispline.region.topology import Chain, Topology
from crispline.sharp.rim import rim_curve, split_at_kinks
from crispline.sharp.trace import guide_along
from crispline.surface import Cylinder, Plane, unit

OPTIONS = LocateOptions()
Z = np.array([0.0, 0.0, 1.0])


def ragged(path, size=0.3, seed=0):
    return path + np.random.default_rng(seed).normal(size=path.shape) * size


def rounded_square(half=15.0, radius=1.5):
    """Square path with rounded corners, a point a spacing; starts in the middle of a side."""
    t = np.linspace(0.0, 1.0, 4000, endpoint=False)
    s = (t * 8.0 * half) % (8.0 * half)
    side, along = np.divmod(s + half, 2.0 * half)
    corner = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    start, end = corner[side.astype(int) % 4], corner[(side.astype(int) + 1) % 4]
    path = start + (end - start) * (along / (2.0 * half))[:, None]
    inner = np.clip(path, -half + radius, half - radius)
    away = path - inner
    length = np.linalg.norm(away, axis=1, keepdims=True)
    path = inner + away * np.minimum(1.0, radius / np.maximum(length, 1e-12))
    path = path[:: 4000 // int(8 * half)]
    return np.column_stack([path, np.zeros(len(path))])


def ring_of(path):
    n = len(path)
    return Topology((Chain(np.append(np.arange(n), 0), 0, -1),), {0: (((0, 1),),)})


@pytest.mark.parametrize("seed", range(4))
def test_a_square_rim_gets_its_four_corners(seed):
    path = ragged(rounded_square(), 0.2, seed) * [1.0, 1.0, 0.0]
    topology, vertices = split_at_kinks(ring_of(path), path, OPTIONS)
    assert len(topology.chains) == 4
    assert [side for _, side in topology.loops[0][0]] == [1, 1, 1, 1]
    starts = np.array([vertices[chain.vertices[0]] for chain in topology.chains])
    expected = 15.0 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    gap = np.linalg.norm(starts[:, None, :2] - expected, axis=2).min(axis=0)
    assert gap.max() < 0.6


def test_a_round_rim_gets_none():
    angle = np.linspace(0.0, 2.0 * np.pi, 50, endpoint=False)
    path = 8.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    topology, _ = split_at_kinks(ring_of(path), ragged(path, 0.2), OPTIONS)
    assert len(topology.chains) == 1


def test_inner_borders_are_left_alone():
    path = rounded_square()
    n = len(path)
    inner = Topology(
        (Chain(np.append(np.arange(n), 0), 0, 1),), {0: (((0, 1),),), 1: (((0, -1),),)}
    )
    topology, vertices = split_at_kinks(inner, path, OPTIONS)
    assert topology == inner
    np.testing.assert_array_equal(vertices, path)


def test_a_ragged_straight_rim_is_a_line():
    path = np.column_stack([np.arange(41.0), np.zeros(41), np.zeros(41)])
    guide = guide_along(ragged(path, 0.3) * [1.0, 1.0, 0.0], False)
    ends = (np.zeros(3), np.array([40.0, 0.0, 0.0]))
    curve = rim_curve(guide, Plane(np.zeros(3), Z), ends, OPTIONS)
    assert curve.kind == "line"
    np.testing.assert_allclose(curve.samples(2), np.stack(ends), atol=1e-9)


def test_a_ragged_round_rim_is_a_circle():
    angle = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    ring = 9.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    ring = ragged(ring, 0.3)
    guide = guide_along(np.vstack([ring, ring[:1]]), True)
    curve = rim_curve(guide, Plane(np.zeros(3), Z), None, OPTIONS)
    assert curve.kind == "circle"
    assert np.linalg.norm(curve.samples(50), axis=1).mean() == pytest.approx(9.0, abs=0.25)


def test_the_end_of_a_tube_lies_in_a_plane_on_the_tube():
    angle = np.linspace(0.0, 2.0 * np.pi, 80, endpoint=False)
    tube = Cylinder(np.zeros(3), Z, 12.0)
    for slope in (0.0, 0.5):
        ring = 12.0 * np.column_stack([np.cos(angle), np.sin(angle), slope * np.cos(angle)])
        ring = ragged(ring, 0.25)
        guide = guide_along(np.vstack([ring, ring[:1]]), True)
        curve = rim_curve(guide, tube, None, OPTIONS)
        samples = curve.samples(200)
        assert np.abs(tube.signed_distance(samples)).max() < 1e-4
        normal = unit(np.array([-slope, 0.0, 1.0]))
        assert np.abs(samples @ normal).max() < 0.4
        spread = np.linalg.svd(samples - samples.mean(axis=0), compute_uv=False)
        assert spread[2] < 1e-3 * spread[0]


def test_a_wavy_rim_is_smooth_on_its_surface_and_never_folds():
    x = np.arange(61.0)
    path = np.column_stack([x, 4.0 * np.sin(x / 8.0), 0.0 * x])
    noisy = ragged(path, 0.35)
    noisy[0], noisy[-1] = path[0], path[-1]
    curve = rim_curve(
        guide_along(noisy, False), Plane(np.zeros(3), Z), (path[0], path[-1]), OPTIONS
    )
    samples = curve.samples(400)
    np.testing.assert_allclose(samples[:, 2], 0.0, atol=1e-6)
    assert (np.diff(samples[:, 0]) > 0.0).all()
    assert np.abs(samples[:, 1] - 4.0 * np.sin(samples[:, 0] / 8.0)).max() < 1.0


def test_a_tiny_rim_and_a_noose_still_are_curves():
    plane = Plane(np.zeros(3), Z)
    short = np.array([[0.0, 0, 0], [0.4, 0.3, 0], [0.8, 0.1, 0], [1.0, 0, 0]])
    away = (np.array([-2.0, 1.0, 0.0]), np.array([2.0, 1.0, 0.0]))
    angle = np.linspace(0.2, 2.0 * np.pi - 0.2, 12)
    noose = 2.0 * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    knot = np.array([2.0, 0.0, 0.0])
    for path, ends in ((short, away), (noose, (knot, knot + 1e-3))):
        curve = rim_curve(guide_along(path, False), plane, ends, OPTIONS)
        samples = curve.samples(50)
        assert np.isfinite(samples).all()
        np.testing.assert_allclose(samples[[0, -1]], np.stack(ends), atol=1e-9)
    assert samples[:, 0].min() < -1.0
