"""Fits, merges and lost faces on a box whose net, labels and raw points are known exactly."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from crispline.cloud.working import WorkingCloud
from crispline.net.halfedge import half_edges
from crispline.options import FitOptions, RegionOptions
from crispline.region.evidence import gather_evidence
from crispline.region.expand import expand_regions
from crispline.region.fitting import fit_regions, label_cloud
from crispline.region.merge import merge_regions
from crispline.region.patches import PatchGraph
from crispline.region.segment import segment
from crispline.region.split import split_into_surfaces
from crispline.region.swallowed import release_swallowed
from crispline.surface import Similarity

N = 14
OPTIONS, FIT = RegionOptions(), FitOptions()
SIGMA = 0.05


@pytest.fixture
def box(nets):
    """A box of side 14: one patch and one raw point per cell, edges midway between points."""
    vertices, quads, side = nets.box(N, half=N / 2.0)
    connected = half_edges(quads, len(vertices))
    centres = vertices[quads].mean(axis=1)
    normals = np.eye(3)[side // 2] * np.where(side % 2, 1.0, -1.0)[:, None]
    rng = np.random.default_rng(0)
    noise = SIGMA * rng.normal(size=(len(centres), 1)) * normals
    still = Similarity(1.0, np.eye(3), np.zeros(3))
    none = np.zeros((0, 24))
    kept = np.arange(len(centres))
    points = centres + noise
    cloud = WorkingCloud(points, none.astype(np.int64), none, SIGMA, still, 0, 0, kept, points)
    graph = PatchGraph(centres, normals, connected.pairs(), 1.0)
    evidence = gather_evidence(cloud, normals, graph, np.full(len(centres), SIGMA))
    return SimpleNamespace(
        vertices=vertices, quads=connected, side=side, cloud=cloud, normals=normals, graph=graph,
        evidence=evidence,
    )  # fmt: skip


def fitted(box, label):
    labelled = label_cloud(box.evidence, box.vertices, box.quads, label)
    known = fit_regions(labelled, box.graph, label, FIT, {})
    return labelled, known, {region: fit for region, (fit, _) in known.items()}


def released(box, label, fits):
    return release_swallowed(label, fits, box.evidence, OPTIONS)


def test_points_get_the_label_and_clearance_of_their_patch(box):
    labelled, _, _ = fitted(box, box.side)
    np.testing.assert_array_equal(labelled.region, box.side)
    inward = N / 2.0 - np.sort(np.abs(box.graph.points), axis=1)[:, 1]
    near = inward < 3.5
    assert near.any()
    np.testing.assert_allclose(labelled.clearance[near], inward[near], atol=0.1 + 4 * SIGMA)
    assert labelled.clearance[~near].min() > 3.5 - 0.1 - 4 * SIGMA
    points, _, clearance = labelled.samples(3, FIT)
    assert len(points) == (N - 2) ** 2
    assert clearance.min() > FIT.border_margin


def test_a_region_that_is_mostly_border_gives_half_of_its_points(box):
    """Within a margin of 4 on every side of 14 there are 36 of 196 points clear of it."""
    labelled, _, _ = fitted(box, box.side)
    points, _, clearance = labelled.samples(3, replace(FIT, border_margin=4.0))
    assert len(points) == N * N // 2
    assert clearance.min() >= np.median(labelled.clearance[box.side == 3])


def test_every_side_is_a_plane_that_looks_outward(box):
    _, known, fits = fitted(box, box.side)
    for region, fit in fits.items():
        assert fit.surface.kind == "plane"
        outward = fit.orientation * fit.surface.normal
        np.testing.assert_allclose(outward, box.normals[box.side == region][0], atol=0.01)
        assert np.sqrt(np.mean(fit.residuals**2)) == pytest.approx(SIGMA, rel=0.2)
    labelled, _, _ = fitted(box, box.side)
    again = fit_regions(labelled, box.graph, box.side, FIT, known)
    assert all(again[region] is known[region] for region in known)  # nothing changed: no new fit


def test_halves_of_a_side_join_and_sides_do_not(box):
    label = box.side + 6 * (box.graph.points[:, 0] > 0.0) * (box.side > 1)
    for _ in range(4):
        labelled, _, fits = fitted(box, label)
        label = merge_regions(label, fits, labelled, box.graph, OPTIONS, FIT, {})
    assert len(np.unique(label)) == 6
    assert len(np.unique(np.stack([label, box.side]), axis=1)[0]) == 6


def test_a_crumpled_box_has_no_faces_and_takes_one_round(box, monkeypatch):
    """Bumps of ten sigmas, two patches wide, on every side but one."""
    bumps = 10.0 * SIGMA * np.prod(np.sin(1.6 * box.graph.points + 0.3), axis=1)
    points = box.evidence.points + np.where(box.side > 0, bumps, 0.0)[:, None] * box.normals
    evidence = replace(box.evidence, points=points)
    rounds = []

    def watched(label, *_):
        rounds.append(label)
        return label

    monkeypatch.setattr("crispline.region.segment.expand_regions", watched)
    is_sharp = np.zeros(len(box.side), dtype=bool)
    for crumpled, n_rounds in ((evidence, 1), (box.evidence, OPTIONS.rounds)):
        rounds.clear()
        found = segment(crumpled, box.vertices, box.quads, is_sharp, OPTIONS, FIT)
        assert len(rounds) == n_rounds
        assert found.has_faces == (n_rounds > 1)


def test_split_takes_a_box_without_creases_apart(box):
    label = np.zeros(len(box.side), dtype=np.int64)
    is_sharp = np.zeros(len(label), dtype=bool)
    parts = split_into_surfaces(
        label, box.graph, is_sharp, 0.7 * box.evidence.patch_noise, OPTIONS, FIT
    ).label
    agree = [np.bincount(parts[box.side == k]).max() for k in range(6)]
    assert sum(agree) > 0.95 * len(label)


def test_borders_move_back_to_the_edges(box):
    """A strip two patches wide has gone to the wrong side."""
    label = box.side.copy()
    label[(box.side == 5) & (box.graph.points[:, 0] > N / 2.0 - 2.0)] = 1
    _, _, fits = fitted(box, box.side)
    moved = expand_regions(label, fits, box.evidence, OPTIONS)
    np.testing.assert_array_equal(moved, box.side)


def test_a_swallowed_side_comes_back(box):
    _, _, fits = fitted(box, box.side)
    label = np.where(box.side == 5, 1, box.side)
    del fits[5]
    found = released(box, label, fits)
    (new,) = set(found.tolist()) - set(label.tolist())
    assert np.mean(found[box.side == 5] == new) > 0.8
    assert not (found[box.side != 5] == new).any()


def test_a_noisy_side_is_not_lost(box):
    """Points three sigmas off are, unless that is the noise of their place."""
    points = box.evidence.points + np.where(box.side == 5, 3.0 * SIGMA, 0.0)[:, None] * box.normals
    cloud = replace(box.cloud, points=points)
    _, _, fits = fitted(box, box.side)
    for noise, is_lost in ((SIGMA, True), (3.0 * SIGMA, False)):
        along = np.where(box.side == 5, noise, SIGMA)
        evidence = gather_evidence(cloud, box.normals, box.graph, along)
        found = release_swallowed(box.side, fits, evidence, replace(OPTIONS, swallowed_floor=0.0))
        assert (len(np.unique(found)) > 6) == is_lost


def test_each_region_is_judged_by_the_noise_of_its_own_points(box):
    """One side is scanned with five times the noise of the others."""
    rng = np.random.default_rng(1)
    noise = np.where(box.side == 2, 5.0 * SIGMA, SIGMA)
    points = box.graph.points + (noise * rng.normal(size=len(noise)))[:, None] * box.normals
    cloud = replace(box.cloud, points=points)
    for assumed, is_accepted in ((noise, True), (np.full(len(noise), SIGMA), False)):
        evidence = gather_evidence(cloud, box.normals, box.graph, assumed)
        labelled = label_cloud(evidence, box.vertices, box.quads, box.side)
        known = fit_regions(labelled, box.graph, box.side, FIT, {})
        assert known[2][0].is_accepted == is_accepted
        assert known[3][0].is_accepted
        assert labelled.sigma(3) == pytest.approx(SIGMA)
        assert labelled.sigma(2) == pytest.approx(assumed[box.side == 2][0])


def test_nothing_is_lost_on_a_sound_labelling(box):
    _, _, fits = fitted(box, box.side)
    np.testing.assert_array_equal(released(box, box.side, fits), box.side)


def test_patches_astride_an_edge_are_not_lost(box):
    """Each of their points lies on one of two surfaces, though no surface has them all."""
    points = box.graph.points.copy()
    on_rim = np.sort(np.abs(points), axis=1)[:, 1] > N / 2.0 - 1.0
    points[on_rim] = np.sign(points[on_rim]) * np.where(
        np.abs(points[on_rim]) > N / 2.0 - 1.0, N / 2.0 - 0.1, np.abs(points[on_rim])
    )
    astride = PatchGraph(points, box.graph.normals, box.graph.pairs, 1.0)
    _, _, fits = fitted(box, box.side)
    evidence = gather_evidence(box.cloud, box.normals, astride, box.evidence.noise)
    found = release_swallowed(box.side, fits, evidence, OPTIONS)
    np.testing.assert_array_equal(found, box.side)


@pytest.mark.parametrize("n", [0, 1, 3])
def test_rings_are_the_patches_within_n_sides(box, n):
    start = np.arange(len(box.side)) == 7 * N + 7  # in the middle of a side
    reached = box.graph.points[box.graph.rings(start, n)]
    assert len(reached) == 2 * n * (n + 1) + 1
    assert np.abs(reached - box.graph.points[start]).sum(axis=1).max() == pytest.approx(n)
