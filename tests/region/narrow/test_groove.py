"""Grooves and undercuts that a net and its regions show as something else."""

from dataclasses import replace

import numpy as np
import pytest
from turned import turned

from crispline.fit.swept import Revolution
from crispline.net.halfedge import half_edges
from crispline.options import RegionOptions
from crispline.region.narrow.coaxial import coaxial_sites, is_on_axis, straight_profile
from crispline.region.narrow.groove import with_grooves
from crispline.surface import Cone, Cylinder, Plane, Torus

UP = np.array([0.0, 0.0, 1.0])
RADIUS, N_AROUND = 16.0, 100  # at that radius patches are a spacing wide
OPTIONS = RegionOptions()


def connectivity(part):
    row, turn = np.divmod(np.arange(len(part.face)), N_AROUND)
    first, second = row * N_AROUND + turn, row * N_AROUND + (turn + 1) % N_AROUND
    quads = np.column_stack([first, second, second + N_AROUND, first + N_AROUND])
    return half_edges(quads, len(part.face) + N_AROUND)


def spread(corners):
    """The part with its points all over the patches, not only across their middles."""
    part = turned(corners, N_AROUND)
    evidence = part.evidence
    around = np.cross(UP, evidence.points)
    along = np.cross(around / np.linalg.norm(around, axis=1, keepdims=True), evidence.normals)
    shift = np.random.default_rng(1).uniform(-0.5, 0.5, (len(along), 1))
    return replace(part, evidence=replace(evidence, points=evidence.points + shift * along))


def grooved(part, label, surfaces):
    fits = part.fits(surfaces, label)
    return with_grooves(label, fits, part.evidence, connectivity(part), OPTIONS)


def test_a_groove_that_came_out_as_one_torus_becomes_three_faces():
    corners = [(16.0, 12.0), (16.0, 1.0), (14.0, 1.0), (14.0, -1.0), (16.0, -1.0), (16.0, -12.0)]
    part = spread(corners)
    label = np.where((part.face > 0) & (part.face < 4), 1, 0)
    surfaces = {0: Cylinder(0.0 * UP, UP, RADIUS), 1: Torus(0.0 * UP, UP, 15.2, 1.2)}
    new, found = grooved(part, label, surfaces)
    assert sorted(fit.surface.kind for fit in found.values()) == ["cylinder", "plane", "plane"]
    (bottom,) = (fit.surface for fit in found.values() if fit.surface.kind == "cylinder")
    np.testing.assert_allclose(bottom.radius, 14.0, atol=0.1)
    for face in (1, 2, 3):
        names, counts = np.unique(new[part.face == face], return_counts=True)
        name = names[np.argmax(counts)]
        assert counts.max() > 0.8 * counts.sum()
        assert np.sqrt(np.mean(found[name].residuals ** 2)) < 0.25
    assert (new[np.isin(part.face, [0, 4])] == 0).mean() > 0.95


def test_a_round_groove_stays_a_torus():
    angle = np.linspace(np.pi / 2.0, 3.0 * np.pi / 2.0, 8)
    arc = np.column_stack([16.0 + 2.5 * np.cos(angle), 2.5 * np.sin(angle)])
    part = spread([(16.0, 12.0), *map(tuple, arc), (16.0, -12.0)])
    label = np.where((part.face > 0) & (part.face < 8), 1, 0)
    surfaces = {0: Cylinder(0.0 * UP, UP, RADIUS), 1: Torus(0.0 * UP, UP, 16.0, 2.5)}
    new, found = grooved(part, label, surfaces)
    assert found == {}
    np.testing.assert_array_equal(new, label)


def test_the_foot_of_a_chamfer_that_a_shoulder_took_comes_back():
    corners = [(28.0, 0.0), (18.0, 0.0), (16.0, -2.0), (16.0, 9.0)]
    part = spread(corners[::-1])  # the shaft stands in a countersink of the shoulder
    label = np.where(part.face == 0, 0, 1)
    surfaces = {0: Cylinder(0.0 * UP, UP, RADIUS), 1: Plane(0.0 * UP, UP)}
    new, found = grooved(part, label, surfaces)
    ((name, fit),) = found.items()
    assert isinstance(fit.surface, Cone)
    np.testing.assert_allclose(np.degrees(fit.surface.half_angle), 45.0, atol=3.0)
    assert (new[part.face == 1] == name).mean() > 0.9


def test_half_a_ring_is_none():
    corners = [(16.0, 12.0), (16.0, 1.0), (14.0, 1.0), (14.0, -1.0), (16.0, -1.0), (16.0, -12.0)]
    part = spread(corners)
    is_far = np.arange(len(part.face)) % N_AROUND > N_AROUND / 2
    label = np.where((part.face > 0) & (part.face < 4) & is_far, 1, 0)
    surfaces = {0: Cylinder(0.0 * UP, UP, RADIUS), 1: Torus(0.0 * UP, UP, 15.2, 1.2)}
    new, found = grooved(part, label, surfaces)
    assert found == {}
    np.testing.assert_array_equal(new, label)


def test_a_chamfer_that_leans_within_its_noise_is_about_the_axis_of_the_shaft():
    # Its own axis, taken for that of the groove, put two faces askew between the others.
    part = spread([(16.0, 14.0), (16.0, -14.0), (13.0, -17.0)])
    tilted = np.array([np.sin(0.03), 0.0, np.cos(0.03)])
    surfaces = {
        0: Cylinder(0.0 * UP, UP, RADIUS),
        1: Cone(np.array([0.9, 0.0, -30.0]), tilted, np.pi / 4.0),
    }
    fits = part.fits(surfaces, part.face)
    axis = Revolution(0.0 * UP, UP)
    assert not is_on_axis(surfaces[1].apex, surfaces[1].axis, axis)
    line = straight_profile(fits[1], axis)
    assert abs(np.degrees(line.angle)) % 90.0 == pytest.approx(45.0, abs=2.0)
    sites = list(coaxial_sites(part.face, fits, part.evidence, OPTIONS))
    assert {tuple(np.round(site.sweep.axis, 6)) for site in sites} == {(0.0, 0.0, 1.0)}


def test_a_cone_that_stands_aside_is_not_about_the_axis():
    part = spread([(16.0, 14.0), (16.0, -14.0), (13.0, -17.0)])
    aside = Revolution(np.array([1.5, 0.0, 0.0]), UP)
    surface = Cone(np.array([0.0, 0.0, -30.0]), UP, np.pi / 4.0)
    assert straight_profile(part.fits({1: surface}, part.face)[1], aside) is None


def test_a_piece_that_hangs_together_with_nothing_is_no_groove():
    corners = [(16.0, 12.0), (16.0, 1.0), (14.0, 1.0), (14.0, -1.0), (16.0, -1.0), (16.0, -12.0)]
    part = spread(corners)
    label = np.where((part.face > 0) & (part.face < 4), 1, 0)
    graph = part.evidence.graph
    within = label[graph.pairs[:, 0]] == label[graph.pairs[:, 1]]
    evidence = replace(part.evidence, graph=replace(graph, pairs=graph.pairs[within]))
    surfaces = {0: Cylinder(0.0 * UP, UP, RADIUS), 1: Torus(0.0 * UP, UP, 15.2, 1.2)}
    new, found = grooved(replace(part, evidence=evidence), label, surfaces)
    assert found == {}
    np.testing.assert_array_equal(new, label)
