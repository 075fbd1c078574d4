"""Distances to shapes whose distances are known, and counts of their features."""

import brep_models
import numpy as np
import pytest

from crispline.brep.build import build_shape
from crispline.gauge.accuracy import feature_counts, shape_distances, surface_samples


def distance_to_the_box(points):
    """Box from 0 to (60, 40, 30): to its surface from outside and from inside."""
    size = np.array([60.0, 40.0, 30.0])
    outside = np.linalg.norm(points - np.clip(points, 0.0, size), axis=1)
    inside = np.minimum(points, size - points).min(axis=1)
    return np.where(outside > 0.0, outside, inside)


def test_distances_to_a_box():
    shape = build_shape(brep_models.box().model).shape
    points = np.random.default_rng(0).uniform(-20.0, 80.0, size=(40, 3))
    expected = distance_to_the_box(points)
    np.testing.assert_allclose(shape_distances(points, shape), expected, atol=1e-9)


def test_distances_to_a_rim_are_exact_and_not_those_of_its_triangles():
    shape = build_shape(brep_models.box_cylinder().model).shape
    angle = np.linspace(0.0, 6.0, 25)
    rim = np.column_stack([30 + 12 * np.cos(angle), 20 + 12 * np.sin(angle), np.full(25, 50.0)])
    assert shape_distances(rim, shape).max() < 1e-9
    np.testing.assert_allclose(
        shape_distances(rim + np.array([0.0, 0.0, 0.5]), shape), 0.5, atol=1e-9
    )


def test_samples_are_uniform_by_area_on_the_surface_and_the_same_again():
    shape = build_shape(brep_models.box().model).shape
    points = surface_samples(shape, 20_000, 0.01)
    assert distance_to_the_box(points).max() < 1e-9
    on_top = np.isclose(points[:, 2], 30.0).mean()
    area = 2.0 * (60 * 40 + 60 * 30 + 40 * 30)
    assert on_top == pytest.approx(60 * 40 / area, abs=0.02)
    np.testing.assert_array_equal(points, surface_samples(shape, 20_000, 0.01))


def test_counts_leave_seams_out():
    counts = {
        name: feature_counts(build_shape(getattr(brep_models, name)().model).shape)
        for name in ("box", "box_cylinder", "l_shape")
    }
    assert counts == {"box": (6, 12, 8), "box_cylinder": (8, 14, 8), "l_shape": (8, 18, 12)}
