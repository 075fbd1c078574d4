"""Flat, curved and sharp patches: brute force, every grid phase, noise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from crispline.net.halfedge import half_edges
from crispline.options import DetectOptions
from crispline.sharp.curvature import curvature
from crispline.sharp.detect import detect, normal_spread
from crispline.spline.catmull_clark import patch_centres

OPTIONS = DetectOptions()


def detected(net, sigma=0.0, edge_length=1.0, options=OPTIONS):
    vertices, quads = net
    centres = patch_centres(vertices, quads)
    adjacency = half_edges(quads, len(vertices)).adjacency()
    return detect(curvature(centres), centres.normal, adjacency, edge_length, sigma, options)


def within(adjacency, start, rings):
    """Patches at most ``rings`` sides away, by walking."""
    found, front = {start}, {start}
    for _ in range(rings):
        front = {int(n) for patch in front for n in adjacency.indices[
            adjacency.indptr[patch] : adjacency.indptr[patch + 1]
        ]} - found  # fmt: skip
        found |= front
    return found


def brute_spread(normals, adjacency, is_curved, rings):
    """Largest angle between flat normals near every curved patch, over all pairs."""
    spread = np.zeros(len(normals))
    for patch in np.flatnonzero(is_curved):
        around = [p for p in within(adjacency, int(patch), rings) if not is_curved[p]]
        if around:
            cosine = normals[around] @ normals[around].T
            spread[patch] = np.arccos(np.clip(cosine.min(), -1.0, 1.0))
    return spread


def random_case(nets, seed, share):
    rng = np.random.default_rng(seed)
    quads = nets.grid(6, 7, is_closed=True)
    adjacency = csr_array(half_edges(quads, 42).adjacency())
    return rng, adjacency, rng.random(len(quads)) < share


@given(seed=st.integers(0, 10_000), rings=st.integers(1, 3), share=st.sampled_from([0.1, 0.5, 0.9]))
def test_spread_is_exact_for_normals_on_an_arc(nets, seed, rings, share):
    rng, adjacency, is_curved = random_case(nets, seed, share)
    angle = rng.uniform(0.0, 3.0, adjacency.shape[0])
    normals = np.stack([np.cos(angle), np.sin(angle), np.zeros_like(angle)], axis=1)
    np.testing.assert_allclose(
        normal_spread(normals, adjacency, is_curved, rings),
        brute_spread(normals, adjacency, is_curved, rings),
        atol=1e-6,
    )


@given(seed=st.integers(0, 10_000), rings=st.integers(1, 3), share=st.sampled_from([0.1, 0.5, 0.9]))
def test_spread_of_any_normals_is_between_half_the_truth_and_the_truth(nets, seed, rings, share):
    rng, adjacency, is_curved = random_case(nets, seed, share)
    normals = rng.normal(size=(adjacency.shape[0], 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    spread = normal_spread(normals, adjacency, is_curved, rings)
    truth = brute_spread(normals, adjacency, is_curved, rings)
    assert (spread <= truth + 1e-6).all()
    assert (spread >= 0.5 * truth - 1e-6).all()


def folded(nets, phase, angle_deg=90.0, n=24):
    """A sheet folded along x; the fold lies ``phase`` of a cell after a row of points."""
    vertices, quads = nets.plane(n, n)
    across = vertices[:, 1] - (n // 2 + phase)
    half = np.radians(angle_deg) / 2.0
    vertices[:, 1] = across * np.cos(half)
    vertices[:, 2] = -np.abs(across) * np.sin(half)
    return (vertices, quads), across


def cell_distance(across, quads):
    return np.abs(across[quads].mean(axis=1))


@pytest.mark.parametrize("phase", np.linspace(0.0, 0.5, 6))
@pytest.mark.parametrize("angle_deg", [40.0, 90.0, 140.0])
def test_an_edge_is_found_wherever_it_lies_between_two_rows(nets, phase, angle_deg):
    n = 24
    (vertices, quads), across = folded(nets, phase, angle_deg, n)
    found = detected((vertices, quads))
    distance = cell_distance(across, quads)
    rows = np.repeat(np.arange(n - 1), n - 1)
    inside = (rows > 0) & (rows < n - 2)
    assert set(rows[found.is_sharp & inside]) == set(range(1, n - 2))
    assert distance[found.is_sharp].max() < 2.1
    assert not found.is_sharp[distance > 2.1].any()


@pytest.mark.parametrize("sigma", [0.05, 0.1, 0.2])
def test_noise_neither_hides_an_edge_nor_makes_one(nets, sigma):
    n = 40
    (vertices, quads), across = folded(nets, 0.3, 90.0, n)
    # What noise of sigma leaves in a net that was projected onto the cloud.
    vertices = vertices + 0.3 * sigma * np.random.default_rng(0).normal(size=vertices.shape)
    found = detected((vertices, quads), sigma=sigma)
    distance = cell_distance(across, quads)
    assert found.is_sharp[distance < 0.5].mean() > 0.95
    assert found.is_sharp[distance > 3.0].mean() < 0.02


def test_a_bend_is_curved_but_not_sharp(nets):
    vertices, quads = nets.torus(60, 24, 10.0, 4.0)
    found = detected((vertices, quads))
    assert found.is_curved.all()
    assert not found.is_sharp.any()


def test_a_plane_is_neither(nets):
    found = detected(nets.plane(8, 8))
    assert not found.is_curved.any()
    assert not found.is_sharp.any()


def test_one_patch_alone_is_noise(nets):
    """A component needs two patches above the higher threshold."""
    adjacency = half_edges(nets.grid(6, 6, is_closed=True), 36).adjacency()
    bend, normals = np.zeros(36), np.tile([0.0, 0.0, 1.0], (36, 1))
    bend[14] = 1.0
    assert not detect(bend, normals, adjacency, 1.0, 0.0, OPTIONS).is_curved.any()
    bend[15] = 1.0
    assert detect(bend, normals, adjacency, 1.0, 0.0, OPTIONS).is_curved.sum() == 2
    # Weaker neighbours come along, down to the lower threshold.
    bend[16], bend[20] = 0.045, 0.035
    curved = detect(bend, normals, adjacency, 1.0, 0.0, OPTIONS).is_curved
    np.testing.assert_array_equal(np.flatnonzero(curved), [14, 15, 16])


@given(exponent=st.floats(-3, 3), sign=st.sampled_from([-1.0, 1.0]))
def test_is_the_same_in_every_unit_and_for_either_side(nets, exponent, sign):
    (vertices, quads), _ = folded(nets, 0.2)
    scale = 10.0**exponent
    adjacency = half_edges(quads, len(vertices)).adjacency()
    centres = patch_centres(vertices, quads)
    bend = curvature(centres)
    one = detect(bend, centres.normal, adjacency, 1.0, 0.1, OPTIONS)
    other = detect(sign * bend / scale, centres.normal, adjacency, scale, 0.1 * scale, OPTIONS)
    np.testing.assert_array_equal(one.is_sharp, other.is_sharp)
    assert other.threshold * scale == pytest.approx(one.threshold)
