"""Neighbours that one surface explains, and neighbours that none does."""

import numpy as np
import pytest

from crispline.fit.choose import choose_surface
from crispline.options import FitOptions, RegionOptions
from crispline.region.fitting import LabelledCloud
from crispline.region.merge import chi_square, merge_regions
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Plane

SIGMA = 0.15


def swept(spine, radius, length, arc_deg=90.0, seed=0):
    """A tube of ``radius`` about ``spine(t)``, cut in two at half its length.

    ``spine`` maps lengths to points and unit tangents in the xy plane.
    """
    rng = np.random.default_rng(seed)
    arc = np.radians(arc_deg)
    along, around = np.arange(0.5, length), np.arange(0.5, radius * arc) / radius

    def points_at(t, angle):
        centre, tangent = spine(t)
        side = np.column_stack([tangent[:, 1], -tangent[:, 0], 0.0 * t])
        normals = np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * [0.0, 0.0, 1.0]
        return centre + radius * normals, normals

    t, angle = (grid.ravel() for grid in np.meshgrid(along, around, indexing="ij"))
    centres, centre_normals = points_at(t, angle)
    index = np.arange(len(t)).reshape(len(along), len(around))
    pairs = np.concatenate(
        [
            np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
            np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
        ]
    )
    graph = PatchGraph(centres, centre_normals, pairs, 1.0)
    label = (t > length / 2).astype(np.int64)
    n = 2 * len(t)
    raw_t, raw_angle = rng.uniform(0.0, length, n), rng.uniform(0.0, arc, n)
    points, normals = points_at(raw_t, raw_angle)
    points = points + SIGMA * rng.normal(size=(n, 1)) * normals
    region = (raw_t > length / 2).astype(np.int64)
    clearance = np.abs(raw_t - length / 2)
    return graph, label, LabelledCloud(points, normals, region, clearance, np.full(n, SIGMA))


def straight(kink_deg=0.0, at=30.0):
    def spine(t):
        turn = np.radians(kink_deg) * (t > at)
        tangent = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * t])
        past = np.maximum(t - at, 0.0)
        return np.minimum(t, at)[:, None] * [1.0, 0.0, 0.0] + past[:, None] * tangent, tangent

    return spine


def bent(radius):
    def spine(t):
        turn = t / radius
        tangent = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * t])
        centre = radius * np.column_stack([np.sin(turn), 1.0 - np.cos(turn), 0.0 * t])
        return centre, tangent

    return spine


def wavy(t):
    tangent = np.column_stack([np.ones_like(t), 0.25 * np.cos(t / 16.0), 0.0 * t])
    centre = np.column_stack([t, 4.0 * np.sin(t / 16.0), 0.0 * t])
    return centre, tangent / np.linalg.norm(tangent, axis=1, keepdims=True)


def merged(scene, kinds, refused=None, is_accepted=True):
    """Labels after merging; each half is first fitted alone, with the given kinds."""
    graph, label, cloud = scene
    refused = {} if refused is None else refused
    options = FitOptions(max_points=1000)
    fits = {}
    for region in (0, 1):
        points, normals, _ = cloud.samples(region, options)
        surface = choose_surface(points, normals, SIGMA, options, kinds).surface
        residuals = surface.signed_distance(points)
        fits[region] = RegionFit(surface, 1, points, residuals, is_accepted)
    return merge_regions(label, fits, cloud, graph, RegionOptions(), options, refused)


@pytest.mark.parametrize(
    ("spine", "kinds"),
    [
        (straight(), ("cylinder",)),
        (bent(25.0), ("torus",)),
        (bent(400.0), ("cylinder",)),
    ],
    ids=["cylinder", "torus", "bent fillet"],
)
def test_halves_of_one_face_are_joined(spine, kinds):
    label = merged(swept(spine, 8.0, 60.0), kinds)
    assert len(np.unique(label)) == 1


def test_cylinders_that_meet_in_a_mitre_stay_apart():
    label = merged(swept(straight(kink_deg=12.0), 8.0, 60.0), ("cylinder",))
    assert len(np.unique(label)) == 2


@pytest.mark.parametrize(("is_accepted", "n_faces"), [(True, 1), (False, 2)])
def test_a_free_form_that_does_not_explain_its_own_points_takes_no_neighbour(is_accepted, n_faces):
    scene = swept(wavy, 20.0, 60.0, 40.0)
    label = merged(scene, ("bspline",), is_accepted=is_accepted)
    assert len(np.unique(label)) == n_faces


@pytest.mark.parametrize(("share", "n_faces"), [(0.97, 2), (0.9, 1)])
def test_what_was_refused_is_tried_again_only_when_it_has_changed(share, n_faces):
    scene = swept(straight(), 8.0, 60.0)
    sizes = tuple(int(share * n) for n in np.bincount(scene[1]))
    label = merged(scene, ("cylinder",), refused={(0, 1): sizes})
    assert len(np.unique(label)) == n_faces


def test_very_many_points_are_told_by_an_even_sample(monkeypatch):
    heights = np.random.default_rng(0).normal(0.0, SIGMA, 90_000)
    points = np.column_stack([np.arange(90_000.0), np.zeros(90_000), heights])
    plane = Plane(np.zeros(3), np.array([0.0, 0.0, 1.0]))
    seen = []
    known = Plane.signed_distance
    monkeypatch.setattr(
        Plane, "signed_distance", lambda self, where: seen.append(len(where)) or known(self, where)
    )
    found = chi_square([(plane, points), (plane, points[:500])], SIGMA)
    assert sum(seen) < 20_000
    capped = np.minimum(np.square(np.append(heights, heights[:500]) / SIGMA), 16.0)
    assert abs(found / capped.sum() - 1.0) < 0.05
