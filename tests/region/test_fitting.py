"""The surfaces of the regions of a sculpture: planes and free forms."""

import numpy as np
import pytest

from crispline.options import FitOptions
from crispline.region.fitting import SCULPTURE_KINDS, LabelledCloud, fit_regions
from crispline.region.patches import PatchGraph

SIGMA = 0.1


def rounds():
    """A quarter of a cylinder, a square and a whole ball, 800 points each, far apart."""
    rng = np.random.default_rng(0)
    angle, along = rng.uniform(0.0, np.pi / 2, 800), rng.uniform(0.0, 25.0, 800)
    pipe = np.column_stack([along, np.cos(angle), np.sin(angle)]), np.array([1.0, 20.0, 20.0])
    ball = rng.normal(size=(800, 3))
    ball /= np.linalg.norm(ball, axis=1, keepdims=True)
    flat = np.column_stack([rng.uniform(0.0, 28.0, (800, 2)), np.zeros(800)])
    normals = [np.column_stack([0.0 * along, pipe[0][:, 1:]]), np.tile([0.0, 0, 1], (800, 1)), ball]
    east, north, _ = 100.0 * np.eye(3)
    points = [pipe[0] * pipe[1], flat + east, 8.0 * ball + north]
    everything, heading = np.concatenate(points), np.concatenate(normals)
    everything = everything + SIGMA * rng.normal(size=(2400, 1)) * heading
    region = np.repeat(np.arange(3), 800)
    far, noise = np.full(2400, np.inf), np.full(2400, SIGMA)
    return LabelledCloud(everything, heading, region, far, noise)


@pytest.fixture(scope="module")
def fitted():
    labelled = rounds()
    graph = PatchGraph(labelled.points, labelled.normals, np.zeros((0, 2), np.int64), 1.0)
    label = labelled.region

    def of_kinds(*kinds):
        found = fit_regions(labelled, graph, label, FitOptions(), {}, *kinds)
        return [fit for fit, _ in found.values()]

    return of_kinds


def test_a_part_has_primitives(fitted):
    assert [fit.surface.kind for fit in fitted()] == ["cylinder", "plane", "sphere"]


def test_a_sculpture_has_free_forms_and_planes_and_what_is_neither(fitted):
    found = fitted(SCULPTURE_KINDS)
    kinds = [fit.surface.kind for fit in found]
    assert kinds[1:] == ["plane", "sphere"]
    assert kinds[0] in ("bspline", "extrusion")
    for fit in found:
        assert fit.is_accepted
        assert np.sqrt(np.mean(fit.residuals**2)) < 1.1 * SIGMA
