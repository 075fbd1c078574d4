import numpy as np
import pytest

from crispline.fit.constrained import Adjustment, estimate
from crispline.fit.cylinder import fit_cylinder
from crispline.fit.plane import fit_plane
from crispline.fit.regularize import regularize
from crispline.fit.starts import extent
from crispline.surface import Cylinder, Plane

SIGMA = 0.1
X, Y, Z = np.eye(3)


def flat(rng, normal, n=900, size=30.0):
    """A square plane through its place: points with noise and its normals."""
    _, _, axes = np.linalg.svd(normal[None])
    points = size * normal + rng.uniform(-size / 2, size / 2, (n, 2)) @ axes[1:]
    return points + SIGMA * rng.normal(size=(n, 1)) * normal, np.tile(normal, (n, 1))


def tube(rng, radius, height, n=600, origin=(0.0, 0.0, 0.0)):
    """A whole cylinder about the z axis."""
    angle = rng.uniform(0.0, 2.0 * np.pi, n)
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])
    points = radius * normals + rng.uniform(*height, n)[:, None] * Z + np.asarray(origin)
    return points + SIGMA * rng.normal(size=(n, 1)) * normals, normals


def regular(surfaces, clouds):
    """The number of regularities found, and all surfaces after it."""
    adjustment = Adjustment({i: estimate(s, clouds[i][0], SIGMA) for i, s in enumerate(surfaces)})
    sizes = np.array([extent(points) for points, _ in clouds])
    count = regularize(adjustment, dict(enumerate(surfaces)), sizes)
    return count, {**dict(enumerate(surfaces)), **adjustment.solved()}


def test_the_sides_of_a_noisy_box_become_exactly_parallel_and_perpendicular():
    turn, _ = np.linalg.qr(np.random.default_rng(9).normal(size=(3, 3)))
    before, after = [], []
    for seed in range(5):
        rng = np.random.default_rng(seed)
        truth = [sign * axis @ turn for axis in np.eye(3) for sign in (1.0, -1.0)]
        clouds = [flat(rng, normal) for normal in truth]
        fits = [fit_plane(*cloud, SIGMA) for cloud in clouds]
        count, planes = regular(fits, clouds)
        assert count == 3
        normals = np.stack([plane.normal for plane in planes.values()])
        products = np.abs(normals @ normals.T)
        assert np.minimum(products, np.abs(1.0 - products)).max() < 1e-9
        before += [np.arccos(fit.normal @ n) for fit, n in zip(fits, truth, strict=True)]
        after += [np.arccos(normal @ n) for normal, n in zip(normals, truth, strict=True)]
    assert np.linalg.norm(after) < 0.8 * np.linalg.norm(before)


@pytest.mark.parametrize("angle_deg", [0.0, 1.0])
def test_a_draft_angle_that_the_points_show_stays(angle_deg):
    rng = np.random.default_rng(6)
    angle = np.radians(angle_deg)
    clouds = [flat(rng, Z), flat(rng, np.cos(angle) * Z + np.sin(angle) * X)]
    count, planes = regular([fit_plane(*cloud, SIGMA) for cloud in clouds], clouds)
    between = np.degrees(np.arccos(min(planes[0].normal @ planes[1].normal, 1.0)))
    assert count == (1 if angle_deg == 0.0 else 0)
    assert between == pytest.approx(angle_deg, abs=0.15)
    assert (between < 1e-6) == (angle_deg == 0.0)


def test_a_stepped_bore_gets_one_axis_and_equal_steps_one_radius():
    rng = np.random.default_rng(7)
    clouds = [
        tube(rng, 8.0, (0.0, 12.0)),
        tube(rng, 12.0, (12.0, 20.0)),
        tube(rng, 8.0, (20.0, 30.0)),
        tube(rng, 8.4, (0.0, 12.0), origin=(50.0, 0.0, 0.0)),
    ]
    fits = [fit_cylinder(*cloud, SIGMA) for cloud in clouds]
    _, found = regular(fits, clouds)
    assert all(isinstance(surface, Cylinder) for surface in found.values())
    for other in (1, 2):
        offset = found[other].origin - found[0].origin
        assert np.linalg.norm(np.cross(found[0].axis, found[other].axis)) < 1e-9
        assert np.linalg.norm(np.cross(found[0].axis, offset)) < 1e-8
    assert found[0].radius == pytest.approx(found[2].radius, abs=1e-9)
    assert found[3].radius == pytest.approx(8.4, abs=0.05)
    assert abs(np.cross(found[0].axis, found[3].axis)).max() < 1e-9


def test_surfaces_in_no_regular_position_are_left_alone():
    rng = np.random.default_rng(8)
    normal = np.array([0.6, 0.64, 0.48])
    clouds = [flat(rng, Z), flat(rng, normal / np.linalg.norm(normal))]
    fits = [fit_plane(*cloud, SIGMA) for cloud in clouds]
    count, found = regular(fits, clouds)
    assert count == 0
    assert all(isinstance(found[i], Plane) and found[i] is fits[i] for i in (0, 1))
