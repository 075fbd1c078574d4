import numpy as np
import pytest

from crispline.surface import Cone, Cylinder, Plane, Similarity, Sphere, Torus, unit

AXIS = unit(np.array([1.0, -2.0, 0.5]))
AT = np.array([1.0, 2.0, 3.0])
SURFACES = [
    Plane(AT, AXIS),
    Cylinder(AT, AXIS, 4.0),
    Sphere(AT, 4.0),
    Cone(AT, AXIS, 0.5),
    Torus(AT, AXIS, 6.0, 2.0),
]
POINTS = np.random.default_rng(0).uniform(-10, 10, (500, 3))


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: s.kind)
def test_feet_stay_where_they_are(surface):
    feet, normals = surface.project(POINTS)
    again, same = surface.project(feet)
    np.testing.assert_allclose(again, feet, atol=1e-12)
    beside = np.linalg.norm(feet - AT, axis=1) > 1e-9  # the apex of the cone has no normal
    np.testing.assert_allclose(same[beside], normals[beside], atol=1e-9)


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: s.kind)
def test_the_normal_is_the_gradient_of_the_distance(surface):
    feet, normals = surface.project(POINTS)
    if surface.kind == "cone":
        regular = np.linalg.norm(feet - AT, axis=1) > 1e-3
        feet, normals = feet[regular], normals[regular]
    h = 1e-6
    gradient = [
        (surface.signed_distance(feet + h * e) - surface.signed_distance(feet - h * e)) / (2 * h)
        for e in np.eye(3)
    ]
    np.testing.assert_allclose(np.stack(gradient, axis=1), normals, atol=1e-5)


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: s.kind)
def test_distances_follow_a_similarity(surface):
    rotation, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    rotation *= np.sign(np.linalg.det(rotation))
    motion = Similarity(3.0, rotation, np.array([1.0, -20.0, 7.0]))
    moved = surface.transformed(motion).signed_distance(motion.points(POINTS))
    np.testing.assert_allclose(moved, 3.0 * surface.signed_distance(POINTS), atol=1e-11)


@pytest.mark.parametrize("surface", SURFACES, ids=lambda s: s.kind)
def test_points_without_a_unique_foot_get_one(surface):
    feet, normals = surface.project(np.array([AT, AT + 2.0 * AXIS]))
    assert np.isfinite(feet).all()
    assert np.isfinite(normals).all()
