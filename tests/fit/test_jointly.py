"""One primitive for several regions."""

import numpy as np
import pytest

from crispline.fit.jointly import fit_jointly
from crispline.options import FitOptions
from crispline.surface import Cylinder, Plane

OPTIONS = FitOptions()


def test_parts_of_one_cylinder_are_joined_and_of_two_are_not(patches):
    rng = np.random.default_rng(5)
    truth, points, normals = patches.scanned(patches.cylinder(900, rng, 15.0, 200.0), 0.1, rng)
    along = points @ truth.axis
    middle = np.median(along)
    one, other = along < middle - 1, along > middle + 1
    parts = [(points[side], normals[side]) for side in (one, other)]
    joint = fit_jointly(("plane", "cylinder"), parts, 0.1, OPTIONS)
    assert isinstance(joint, Cylinder)
    assert joint.radius == pytest.approx(15.0, abs=0.05)
    _, outward = truth.project(parts[1][0])
    stepped = [parts[0], (parts[1][0] + 0.5 * outward, parts[1][1])]
    assert fit_jointly(("plane", "cylinder"), stepped, 0.1, OPTIONS) is None


def test_a_small_step_between_two_planes_is_seen(patches):
    rng = np.random.default_rng(6)
    _, points, normals = patches.plane(400, rng)
    parts = [(points, normals), (points[:40] + np.array([30.0, 0.0, 0.0]), normals[:40])]
    assert isinstance(fit_jointly(("plane",), parts, 0.05, OPTIONS), Plane)
    raised = [parts[0], (parts[1][0] + np.array([0.0, 0.0, 0.2]), parts[1][1])]
    assert fit_jointly(("plane",), raised, 0.05, OPTIONS) is None


def test_pieces_of_a_rippled_plane_lie_off_it_by_what_neighbours_share(patches):
    rng = np.random.default_rng(6)
    _, points, normals = patches.plane(400, rng)
    parts = [
        (points, normals),
        (points + np.array([30.0, 0.0, 0.0]), normals),
        (points[:40] + np.array([60.0, 0.0, 0.15]), normals[:40]),
    ]
    assert fit_jointly(("plane",), parts, 0.15, OPTIONS) is None
    assert isinstance(fit_jointly(("plane",), parts, 0.15, FitOptions(noise_growth=3.0)), Plane)
