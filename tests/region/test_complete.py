"""Parts of a surface become the whole of it, on a rounded rim that is known exactly."""

from dataclasses import replace

import numpy as np
import pytest

from crispline.fit.choose import PRIMITIVE_FITS
from crispline.options import RegionOptions
from crispline.region.complete import completed
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Torus

MAJOR, MINOR, STRAIGHT = 10.0, 5.0, 8.0
SIGMA = 0.08
CYLINDER, ROUND, PLANE = 0, 1, 2
OPTIONS = RegionOptions()


def profile(s):
    """Radius, height and their normal along wall, quarter round and top; which face each is on."""
    arc = MINOR * np.pi / 2.0
    turn = np.clip((s - STRAIGHT) / MINOR, 0.0, np.pi / 2.0)
    radius = MAJOR + MINOR * np.cos(turn) - np.maximum(s - STRAIGHT - arc, 0.0)
    height = MINOR * np.sin(turn) + np.minimum(s - STRAIGHT, 0.0)
    face = np.where(s < STRAIGHT, CYLINDER, np.where(s <= STRAIGHT + arc, ROUND, PLANE))
    return radius, height, np.cos(turn), np.sin(turn), face


@pytest.fixture(scope="module")
def rim():
    """Graph and true face of the patches of a quarter of a rounded rim."""
    rng = np.random.default_rng(0)
    s = np.arange(0.5, 2.0 * STRAIGHT + MINOR * np.pi / 2.0, 1.0)
    phi = np.linspace(0.0, np.pi / 2.0, 24)
    radius, height, out, up, face = (a.repeat(len(phi)) for a in profile(s))
    spoke = np.column_stack([np.cos(phi), np.sin(phi)])[np.tile(np.arange(len(phi)), len(s))]
    normals = np.column_stack([out[:, None] * spoke, up])
    points = np.column_stack([radius[:, None] * spoke, height])
    points += SIGMA * rng.normal(size=(len(points), 1)) * normals
    number = np.arange(len(points)).reshape(len(s), len(phi))
    pairs = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ]
    )
    return PatchGraph(points, normals, pairs, 1.0), face


def fitted(graph, label, kinds):
    fits = {}
    for region, kind in kinds.items():
        members = label == region
        points, normals = graph.points[members], graph.normals[members]
        surface = PRIMITIVE_FITS[kind](points, normals, SIGMA)
        fits[region] = RegionFit(surface, 1, points, surface.signed_distance(points), True)
    return fits


def noise(graph):
    return np.full(len(graph.points), SIGMA)


@pytest.mark.parametrize("kind", ["sphere", "cylinder"])
def test_the_middle_of_a_round_becomes_the_torus(rim, kind):
    graph, face = rim
    left = np.abs(profile_place(graph) - 0.5) < 0.25
    label = np.where(face == ROUND, np.where(left, ROUND, CYLINDER), face)
    fits = fitted(graph, label, {CYLINDER: "cylinder", ROUND: kind, PLANE: "plane"})
    same, found = completed(label, fits, graph, noise(graph), OPTIONS)
    torus = found[ROUND].surface
    assert isinstance(torus, Torus)
    assert torus.major_radius == pytest.approx(MAJOR, rel=0.05)
    assert torus.minor_radius == pytest.approx(MINOR, rel=0.05)
    assert np.abs(torus.signed_distance(graph.points[face == ROUND])).max() < 5.0 * SIGMA
    assert found[PLANE] is fits[PLANE]
    np.testing.assert_array_equal(same, label)


def test_what_a_b_spline_has_of_it_comes_along(rim):
    graph, face = rim
    left = np.abs(profile_place(graph) - 0.5) < 0.25
    label = np.where(face == ROUND, np.where(left, ROUND, 3), face)
    fits = fitted(graph, label, {CYLINDER: "cylinder", ROUND: "sphere", PLANE: "plane"})
    fits[3] = replace(fits[CYLINDER], surface=_Free())
    given, found = completed(label, fits, graph, noise(graph), OPTIONS)
    assert found[ROUND].surface.kind == "torus"
    assert np.mean(given[face == ROUND] == ROUND) > 0.95
    np.testing.assert_array_equal(given[face != ROUND], label[face != ROUND])


def test_a_strip_of_a_cylinder_that_passes_for_a_plane_becomes_one():
    rng = np.random.default_rng(1)
    turn, along = np.meshgrid(np.linspace(-0.9, 0.9, 10), np.arange(20.0), indexing="ij")
    normals = np.column_stack([np.sin(turn).ravel(), np.zeros(turn.size), np.cos(turn).ravel()])
    points = 5.0 * normals + np.outer(along.ravel(), [0.0, 1.0, 0.0])
    points += SIGMA * rng.normal(size=(turn.size, 1)) * normals
    number = np.arange(turn.size).reshape(turn.shape)
    pairs = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ]
    )
    graph = PatchGraph(points, normals, pairs, 1.0)
    label = np.where(np.abs(turn.ravel()) < 0.35, 0, np.where(turn.ravel() > 0.0, 1, 2))
    fits = fitted(graph, label, {0: "plane", 1: "plane", 2: "plane"})
    _, found = completed(label, {0: fits[0]}, graph, noise(graph), OPTIONS)
    assert found[0].surface.kind == "cylinder"
    assert found[0].surface.radius == pytest.approx(5.0, rel=0.05)


def test_whole_faces_stay_what_they_are(rim):
    graph, face = rim
    fits = fitted(graph, face, {CYLINDER: "cylinder", ROUND: "torus", PLANE: "plane"})
    label, found = completed(face, fits, graph, noise(graph), OPTIONS)
    np.testing.assert_array_equal(label, face)
    assert all(found[region] is fits[region] for region in fits)


def profile_place(graph):
    """Where patches are on the round, 0 at the wall and 1 at the top."""
    rho = np.hypot(*graph.points[:, :2].T) - MAJOR
    return np.arctan2(graph.points[:, 2], rho) / (np.pi / 2.0)


class _Free:
    kind = "bspline"
