"""Many spline surfaces at once, against one at a time and against brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crispline.spline.atlas import bernstein, build_atlas
from crispline.spline.tensor import TensorSpline


def bumpy(seed, degrees, spans, is_rational, shift=0.0):
    """A height field of small bumps over a square of side 10, with uneven knots."""
    stream = np.random.default_rng(seed)
    knots, sizes = [], []
    for degree, n in zip(degrees, spans, strict=True):
        inner = np.sort(stream.uniform(0.1, 0.9, n - 1)) + np.arange(n - 1)
        knots.append(np.concatenate([np.zeros(degree + 1), inner / n, np.ones(degree + 1)]))
        sizes.append(degree + n)
    x, y = np.meshgrid(*(np.linspace(0.0, 10.0, n) for n in sizes), indexing="ij")
    net = np.stack([x + shift, y, stream.uniform(-0.5, 0.5, sizes)], axis=2)
    weights = stream.uniform(0.7, 1.4, sizes) if is_rational else None
    return TensorSpline(*degrees, *knots, net, weights)


def parameters(spline, place):
    """Parameters at places that are told in spans."""
    return [
        np.interp(place[:, i], np.arange(len(distinct)), distinct)
        for i, distinct in enumerate((np.unique(spline.knots_u), np.unique(spline.knots_v)))
    ]


@pytest.mark.parametrize("is_rational", [False, True])
@pytest.mark.parametrize("degrees", [(1, 1), (3, 3), (2, 5)])
def test_the_pieces_are_the_surfaces(degrees, is_rational):
    splines = [bumpy(seed, degrees, (4, 3), is_rational, 20.0 * seed) for seed in range(3)]
    atlas = build_atlas(splines)
    place = np.random.default_rng(9).uniform(0.0, [4.0, 3.0], (50, 2))
    for i, spline in enumerate(splines):
        (found,) = atlas.derivatives(np.full(50, i), place, ((0, 0),))
        assert np.allclose(found, spline.evaluate(*parameters(spline, place)), atol=1e-12)


def test_derivatives_are_those_of_finite_differences():
    atlas = build_atlas([bumpy(2, (3, 2), (3, 4), True)])
    place = np.random.default_rng(3).uniform(0.2, 0.8, (30, 2)) + np.array([1.0, 2.0])
    one, orders, step = (
        np.zeros(30, np.int64),
        ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
        1e-4,
    )

    def at(dx, dy):
        return atlas.derivatives(one, place + step * np.array([dx, dy]), ((0, 0),))[0]

    found = atlas.derivatives(one, place, orders)
    assert np.allclose(found[1], (at(1, 0) - at(-1, 0)) / (2 * step), atol=1e-5)
    assert np.allclose(found[2], (at(0, 1) - at(0, -1)) / (2 * step), atol=1e-5)
    assert np.allclose(found[3], (at(1, 0) - 2 * at(0, 0) + at(-1, 0)) / step**2, atol=1e-5)
    mixed = (at(1, 1) - at(1, -1) - at(-1, 1) + at(-1, -1)) / (4 * step**2)
    assert np.allclose(found[4], mixed, atol=1e-5)
    assert np.allclose(found[5], (at(0, 1) - 2 * at(0, 0) + at(0, -1)) / step**2, atol=1e-5)


@settings(max_examples=10, deadline=None)
@given(seed=st.integers(0, 1000), is_rational=st.booleans())
def test_feet_are_the_nearest_points(seed, is_rational):
    splines = [bumpy(seed + i, (3, 3), (3, 2 + i), is_rational) for i in range(3)]
    stream = np.random.default_rng(seed)
    points = stream.uniform([-1.0, -1.0, -1.5], [11.0, 11.0, 1.5], (40, 3))
    surface = stream.integers(0, 3, 40)
    feet, normals = build_atlas(splines).project(points, surface)
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 121), np.linspace(0, 1, 121)))
    samples = np.stack([spline.evaluate(u, v) for spline in splines])[surface]
    brute = np.linalg.norm(samples - points[:, None], axis=2).min(axis=1)
    distance = np.linalg.norm(points - feet, axis=1)
    assert np.all(distance <= brute + 1e-9)
    # Inside the border the offset is along the normal.
    is_inner = np.all((feet[:, :2] > 0.2) & (feet[:, :2] < 9.8), axis=1)
    across = np.cross(points - feet, normals)[is_inner]
    assert np.abs(across).max(initial=0.0) < 1e-6


def test_a_foot_may_lie_on_a_crease():
    knots = np.array([0.0, 0.0, 0.5, 1.0, 1.0])
    flat = np.array([0.0, 0.0, 1.0, 1.0])
    roof = np.array([[[x, y, 1.0 - abs(x - 1.0)] for y in (0.0, 2.0)] for x in (0.0, 1.0, 2.0)])
    atlas = build_atlas([TensorSpline(1, 1, knots, flat, roof)])
    feet, _ = atlas.project(np.array([[1.0, 1.0, 3.0], [2.0, 1.0, 1.0]]), np.zeros(2, np.int64))
    assert np.allclose(feet, [[1.0, 1.0, 1.0], [1.5, 1.0, 0.5]], atol=1e-4)


def test_bernstein_polynomials_are_a_partition_of_unity():
    t = np.linspace(-0.2, 1.2, 7)
    for degree in range(8):
        assert np.allclose(bernstein(degree, t).sum(axis=1), 1.0)
        assert np.allclose(bernstein(degree, t, 1).sum(axis=1), 0.0)
