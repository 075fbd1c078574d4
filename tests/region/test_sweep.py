"""Pieces of one ribbon or one turned spline become one face; tangent primitives stay two."""

import numpy as np

from crispline.fit.choose import choose_surface
from crispline.options import FitOptions, RegionOptions
from crispline.region import sweep
from crispline.region.fitting import LabelledCloud, fitted_region
from crispline.region.patches import PatchGraph
from crispline.region.sweep import with_sweeps
from crispline.surface import ExtrudedSurface, RevolvedSurface

SIGMA = 0.15
WIDTH = 24.0


def ribbon(curvature, length, cut, radius=None, seed=0):
    """A plane curve swept over ``WIDTH``, labelled 0 before ``cut`` and 1 behind it;
    and so on for several cuts.

    ``curvature`` maps lengths along the curve to its curvature there, 1 / spacing. With a
    ``radius`` the curve is turned about an axis that far from its start instead.
    """
    rng = np.random.default_rng(seed)
    fine = np.linspace(0.0, length, 2000)
    step = fine[1]
    turn = np.concatenate([[0.0], np.cumsum(curvature(fine[1:] - step / 2.0) * step)])
    turn -= turn[-1] / 2.0
    middle = 0.5 * (turn[1:] + turn[:-1])
    x, y = (np.concatenate([[0.0], np.cumsum(f(middle) * step)]) for f in (np.cos, np.sin))
    width = WIDTH if radius is None else 2.0 * np.pi * radius

    def at(t, height):
        angle = np.interp(t, fine, turn)
        along, out = np.interp(t, fine, x), np.interp(t, fine, y)
        if radius is None:
            normals = np.column_stack([-np.sin(angle), np.cos(angle), 0.0 * t])
            return np.column_stack([along, out, height]), normals
        spoke = np.column_stack([np.cos(height / radius), np.sin(height / radius)])
        normals = np.column_stack([np.cos(angle)[:, None] * spoke, -np.sin(angle)])
        return np.column_stack([(radius + out)[:, None] * spoke, along]), normals

    along, across = np.arange(0.5, length), np.arange(0.5, width)
    t, height = (grid.ravel() for grid in np.meshgrid(along, across, indexing="ij"))
    index = np.arange(len(t)).reshape(len(along), len(across))
    pairs = [
        np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
        np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
    ]
    graph = PatchGraph(*at(t, height), np.concatenate(pairs), 1.0)
    n = 2 * len(t)
    raw = rng.uniform(0.0, length, n)
    points, normals = at(raw, rng.uniform(0.0, width, n))
    points += SIGMA * rng.normal(size=(n, 1)) * normals
    noise = np.full(n, SIGMA)
    cuts = np.atleast_1d(cut)
    clearance = np.abs(raw[:, None] - cuts).min(axis=1)
    cloud = LabelledCloud(points, normals, np.digitize(raw, cuts), clearance, noise)
    return graph, np.digitize(t, cuts), cloud


def joined(scene, kinds=("cylinder", "cylinder")):
    graph, label, cloud = scene
    options = FitOptions()
    fits = {}
    for region, kind in enumerate(kinds):
        points, normals, _ = cloud.samples(region, options)
        fit = choose_surface(points, normals, SIGMA, options, (kind,))
        fits[region] = fitted_region(fit.surface, points, normals, fit.is_accepted)
    return with_sweeps(label, fits, cloud, graph, RegionOptions(), options)


def test_pieces_of_a_spline_become_one_face():
    label, found = joined(ribbon(lambda t: 0.005 + 0.06 * (t / 40.0) ** 2, 40.0, 22.0))
    assert np.unique(label).tolist() == [0]
    assert isinstance(found[0].surface, ExtrudedSurface)
    assert found[0].is_accepted
    assert abs(found[0].surface.direction[2]) > np.cos(np.radians(1.0))


def test_two_arcs_that_touch_stay_two_cylinders():
    label, found = joined(ribbon(lambda t: np.where(t < 22.0, 1 / 80.0, 1 / 25.0), 40.0, 22.0))
    assert np.unique(label).tolist() == [0, 1]
    assert found == {}


def test_a_bend_the_other_way_stays_another_face():
    label, found = joined(ribbon(lambda t: np.where(t < 22.0, 1 / 30.0, -1 / 30.0), 40.0, 22.0))
    assert np.unique(label).tolist() == [0, 1]
    assert found == {}


def test_a_strip_that_passes_for_a_plane_is_a_piece_too():
    scene = ribbon(lambda t: 0.03 * np.cos(1.4 * t / 40.0), 40.0, 33.0)
    label, found = joined(scene, ("cylinder", "plane"))
    assert np.unique(label).tolist() == [0]
    assert isinstance(found[0].surface, ExtrudedSurface)


def test_a_round_that_goes_over_into_a_plane_stays_a_cylinder():
    scene = ribbon(lambda t: np.where(t < 30.0, 1 / 25.0, 0.0), 44.0, 30.0)
    label, found = joined(scene, ("cylinder", "plane"))
    assert np.unique(label).tolist() == [0, 1]
    assert found == {}


def test_pieces_of_a_turned_spline_become_one_face():
    scene = ribbon(lambda t: 0.02 + 0.05 * (t / 40.0) ** 2, 40.0, 26.0, radius=25.0)
    label, found = joined(scene, ("torus", "torus"))
    assert np.unique(label).tolist() == [0]
    assert isinstance(found[0].surface, RevolvedSurface)
    assert found[0].is_accepted
    assert abs(found[0].surface.axis[2]) > np.cos(np.radians(0.2))


def test_two_rounds_about_one_axis_that_touch_stay_two_tori():
    scene = ribbon(lambda t: np.where(t < 22.0, 1 / 80.0, 1 / 25.0), 40.0, 22.0, radius=15.0)
    label, found = joined(scene, ("torus", "torus"))
    assert np.unique(label).tolist() == [0, 1]
    assert found == {}


def test_a_taper_and_its_round_stay_cone_and_torus():
    scene = ribbon(lambda t: np.where(t < 25.0, 0.0, 1 / 20.0), 40.0, 25.0, radius=15.0)
    label, found = joined(scene, ("cone", "torus"))
    assert np.unique(label).tolist() == [0, 1]
    assert found == {}


def test_rings_that_leave_little_each_are_joined_all_together(monkeypatch):
    scene = ribbon(
        lambda t: 0.05 * np.cos(2.0 * np.pi * t / 40.0),
        40.0,
        np.array([8.0, 16.0, 24.0, 32.0]),
        radius=12.0,
    )
    kinds = ("torus", "cone", "sphere", "cone", "torus")
    label, found = joined(scene, kinds)
    assert np.unique(label).tolist() == [0]
    assert isinstance(found[0].surface, RevolvedSurface)
    monkeypatch.setattr(sweep._Search, "join_groups", lambda _: None)
    assert joined(scene, kinds)[1] == {}
