"""Half a cylinder and the narrow step beside it, which one free form has taken."""

import numpy as np
import pytest

from crispline.options import RegionOptions
from crispline.region.patches import PatchGraph
from crispline.region.reclaim import reclaimed
from crispline.region.regionfit import RegionFit
from crispline.surface import BSplineSurface, Cylinder

RADIUS, SIGMA, STEP = 30.0, 0.13, 2.0
HALF, FREE = 0, 1


@pytest.fixture(scope="module")
def wall():
    """40 x 24 patches of a cylinder about z, with a step of two along its end; which are of it."""
    rng = np.random.default_rng(0)
    s, z = np.meshgrid(np.arange(26.0), np.arange(40.0), indexing="ij")
    angle = np.minimum(s, 23.0) / RADIUS
    spoke = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    on_step = s > 23.0
    points = (RADIUS - np.maximum(s - 23.0, 0.0))[..., None] * spoke + z[..., None] * [0, 0, 1]
    aside = np.stack([-np.sin(angle), np.cos(angle), 0.0 * angle], axis=-1)
    normals = np.where(on_step[..., None], aside, spoke)
    points = points + SIGMA * rng.normal(size=(*s.shape, 1)) * normals
    number = np.arange(s.size).reshape(s.shape)
    pairs = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()]),
        ]
    )
    graph = PatchGraph(points.reshape(-1, 3), normals.reshape(-1, 3), pairs, 1.0)
    return graph, s.ravel(), on_step.ravel()


def half(graph, label):
    members = label == HALF
    cylinder = Cylinder(np.zeros(3), np.array([0.0, 0.0, 1.0]), RADIUS)
    residuals = cylinder.signed_distance(graph.points[members])
    return RegionFit(cylinder, 1, graph.points[members], residuals, True)


def free(graph, label):
    """That it explains its points is all that counts."""
    points = graph.points[label == FREE]
    knots = np.repeat([0.0, 1.0], 4)
    surface = BSplineSurface(knots, knots, points[:16].reshape(4, 4, 3))
    return RegionFit(surface, 1, points, np.zeros(len(points)), True)


def given_back(wall, begin):
    graph, s, _ = wall
    label = np.where(s < begin, HALF, FREE)
    fits = {HALF: half(graph, label), FREE: free(graph, label)}
    noise = np.full(len(s), SIGMA)
    return label, reclaimed(label, fits, graph, noise, RegionOptions())


def test_a_free_form_that_is_mostly_its_neighbours_keeps_only_what_is_left(wall):
    on_step = wall[2]
    label, new = given_back(wall, 10.0)
    assert (new[label == HALF] == HALF).all()
    assert (new[~on_step] == HALF).mean() > 0.97
    assert (new[on_step] == FREE).mean() > 0.9


def test_a_free_form_that_is_mostly_something_else_stays(wall):
    label, new = given_back(wall, 23.0)
    np.testing.assert_array_equal(new, label)
