"""Small B-splines that are a few primitives, on a fillet that goes round a corner."""

import numpy as np
import pytest

from crispline.options import FitOptions, RegionOptions
from crispline.region.patches import PatchGraph
from crispline.region.resolve import resolved

RADIUS, MAJOR, LENGTH = 5.0, 10.0, 18.0
SIGMA = 0.08
OPTIONS, FIT = RegionOptions(), FitOptions()


def grid_pairs(rows, columns):
    number = np.arange(rows * columns).reshape(rows, columns)
    along = np.column_stack([number[:-1].ravel(), number[1:].ravel()])
    return np.concatenate([along, np.column_stack([number[:, :-1].ravel(), number[:, 1:].ravel()])])


def noisy(points, normals, shape):
    rng = np.random.default_rng(0)
    points = points + SIGMA * rng.normal(size=(len(points), 1)) * normals
    return PatchGraph(points, normals, grid_pairs(*shape), 1.0)


@pytest.fixture(scope="module")
def fillet():
    """A quarter round along a straight edge and an eighth of a circle, and where it bends."""
    turn = np.linspace(0.05, np.pi / 2 - 0.05, 8)
    path = np.arange(0.5, LENGTH + (MAJOR + RADIUS) * np.pi / 4, 1.0)
    bend = np.maximum(path - LENGTH, 0.0) / (MAJOR + RADIUS)
    spoke = np.column_stack([np.cos(bend), np.sin(bend), np.zeros(len(path))])
    start = np.minimum(path - LENGTH, 0.0)[:, None] * [0.0, 1.0, 0.0]
    out = spoke[:, None] * np.cos(turn)[:, None] + np.sin(turn)[:, None] * [0.0, 0.0, 1.0]
    points = (start + MAJOR * spoke)[:, None] + RADIUS * out
    graph = noisy(points.reshape(-1, 3), out.reshape(-1, 3), (len(path), len(turn)))
    return graph, np.repeat(bend > 0.0, len(turn))


def taken_apart(graph, candidates=(0,)):
    label = np.zeros(len(graph.points), dtype=np.int64)
    is_sharp = np.zeros(len(label), dtype=bool)
    return resolved(label, candidates, graph, is_sharp, np.full(len(label), SIGMA), OPTIONS, FIT)


def test_a_fillet_that_bends_is_a_cylinder_and_a_torus(fillet):
    graph, bends = fillet
    label = taken_apart(graph)
    parts = np.unique(label)
    assert 2 <= len(parts) <= 3
    straight = np.bincount(label[~bends]).argmax()
    assert np.mean(label[~bends] == straight) > 0.9
    assert np.mean(label[bends] != straight) > 0.6


def test_a_free_form_stays_whole():
    x, y = (a.ravel() for a in np.meshgrid(np.arange(16.0), np.arange(16.0), indexing="ij"))
    z = 1.5 * np.sin(x / 2.5) * np.cos(y / 2.5)
    slope = np.column_stack(
        [
            -0.6 * np.cos(x / 2.5) * np.cos(y / 2.5),
            0.6 * np.sin(x / 2.5) * np.sin(y / 2.5),
            np.ones(len(x)),
        ]
    )
    normals = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    graph = noisy(np.column_stack([x, y, z]), normals, (16, 16))
    assert not taken_apart(graph).any()


def test_others_are_left_alone(fillet):
    graph, _ = fillet
    assert not taken_apart(graph, candidates=()).any()
