"""Pieces of one ribbon become one face; tangent cylinders stay two."""

import numpy as np

from crispline.fit.choose import choose_surface
from crispline.options import FitOptions, RegionOptions
from crispline.region.extrude import with_extrusions
from crispline.region.fitting import LabelledCloud, fitted_region
from crispline.region.patches import PatchGraph
from crispline.surface import ExtrudedSurface

SIGMA = 0.15
WIDTH = 24.0


def ribbon(curvature, length, cut, seed=0):
    """A plane curve swept over ``WIDTH``, labelled 0 before ``cut`` and 1 behind it.

    ``curvature`` maps lengths along the curve to its curvature there, 1 / spacing.
    """
    rng = np.random.default_rng(seed)
    fine = np.linspace(0.0, length, 2000)
    step = fine[1]
    turn = np.concatenate([[0.0], np.cumsum(curvature(fine[1:] - step / 2.0) * step)])
    turn -= turn[-1] / 2.0
    middle = 0.5 * (turn[1:] + turn[:-1])
    x, y = (np.concatenate([[0.0], np.cumsum(f(middle) * step)]) for f in (np.cos, np.sin))

    def at(t, height):
        angle = np.interp(t, fine, turn)
        normals = np.column_stack([-np.sin(angle), np.cos(angle), 0.0 * t])
        return np.column_stack([np.interp(t, fine, x), np.interp(t, fine, y), height]), normals

    along, across = np.arange(0.5, length), np.arange(0.5, WIDTH)
    t, height = (grid.ravel() for grid in np.meshgrid(along, across, indexing="ij"))
    index = np.arange(len(t)).reshape(len(along), len(across))
    pairs = [
        np.column_stack([index[1:].ravel(), index[:-1].ravel()]),
        np.column_stack([index[:, 1:].ravel(), index[:, :-1].ravel()]),
    ]
    graph = PatchGraph(*at(t, height), np.concatenate(pairs), 1.0)
    n = 2 * len(t)
    raw = rng.uniform(0.0, length, n)
    points, normals = at(raw, rng.uniform(0.0, WIDTH, n))
    points += SIGMA * rng.normal(size=(n, 1)) * normals
    noise = np.full(n, SIGMA)
    cloud = LabelledCloud(points, normals, (raw > cut).astype(int), np.abs(raw - cut), noise)
    return graph, (t > cut).astype(np.int64), cloud


def joined(scene, kinds=("cylinder", "cylinder")):
    graph, label, cloud = scene
    options = FitOptions()
    fits = {}
    for region, kind in enumerate(kinds):
        points, normals, _ = cloud.samples(region, options)
        fit = choose_surface(points, normals, SIGMA, options, (kind,))
        fits[region] = fitted_region(fit.surface, points, normals, fit.is_accepted)
    return with_extrusions(label, fits, cloud, graph, RegionOptions(), options)


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
