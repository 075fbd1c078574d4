import numpy as np
import pytest
from scipy.optimize import least_squares

from crispline.fit.constrained import Adjustment, Estimate, estimate, is_proper
from crispline.fit.cylinder import fit_cylinder
from crispline.fit.regularize import Regularity
from crispline.fit.sphere import fit_sphere
from crispline.surface import BSplineSurface, Cone, Cylinder, Plane, Sphere, Torus

SIGMA = 0.1


@pytest.mark.parametrize("kind", ["plane", "cylinder", "sphere", "cone", "torus"])
def test_the_factor_tells_how_the_chi_square_rises(patches, kind):
    """Against the residuals themselves, after a small step of the parameters."""
    rng = np.random.default_rng(1)
    surface, points, _ = patches.scanned(patches.PATCHES[kind](800, rng), 0.0, rng)
    found = estimate(surface, points, SIGMA)
    step = 1e-3 * rng.normal(size=len(found.factor))
    moved = found.moved(step).surface.signed_distance(points)
    rise = np.sum(np.square(moved)) / (2.0 * SIGMA**2)
    assert np.sum(np.square(found.factor @ step)) == pytest.approx(rise, rel=0.02)


def test_a_shared_radius_is_that_of_the_joint_fit(patches):
    """Against the obvious twin: one least-squares problem with one radius."""
    rng = np.random.default_rng(2)
    clouds = []
    for n in (300, 1500):
        _, points, normals = patches.scanned(patches.sphere(n, rng), SIGMA, rng)
        clouds.append((points, normals))
    fits = {i: fit_sphere(p, n, SIGMA) for i, (p, n) in enumerate(clouds)}
    adjustment = Adjustment({i: estimate(fits[i], clouds[i][0], SIGMA) for i in fits})
    assert adjustment.propose(Regularity((0, 1), "equal radius"))
    solved = adjustment.solved()
    assert solved[0].radius == pytest.approx(solved[1].radius, abs=1e-9)

    def residuals(x):
        both = (Sphere(x[:3], x[6]), Sphere(x[3:6], x[6]))
        return np.concatenate(
            [s.signed_distance(p) for s, (p, _) in zip(both, clouds, strict=True)]
        )

    start = np.concatenate([fits[0].centre, fits[1].centre, [fits[1].radius]])
    joint = least_squares(residuals, start).x[6]
    spread = abs(fits[0].radius - fits[1].radius)
    assert spread > 0.01
    assert solved[0].radius == pytest.approx(joint, abs=0.1 * spread)


def test_a_relation_that_noise_does_not_explain_is_refused(patches):
    rng = np.random.default_rng(3)
    fits = {}
    for name, radius in enumerate((20.0, 20.5)):
        _, points, normals = patches.scanned(patches.cylinder(2000, rng, radius), SIGMA, rng)
        fits[name] = estimate(fit_cylinder(points, normals, SIGMA), points, SIGMA)
    adjustment = Adjustment(fits)
    assert not adjustment.propose(Regularity((0, 1), "equal radius"))
    assert adjustment.relations == ()
    assert adjustment.solved() == {}


def test_relations_that_follow_from_others_cost_nothing_and_forgotten_ones_do_not_bind(patches):
    rng = np.random.default_rng(4)
    fits = {}
    for name in range(3):
        _, points, normals = patches.scanned(patches.sphere(500, rng), SIGMA, rng)
        fits[name] = estimate(fit_sphere(points, normals, SIGMA), points, SIGMA)
    adjustment = Adjustment(fits)
    for pair in ((0, 1), (1, 2), (0, 2)):
        assert adjustment.propose(Regularity(pair, "equal radius"))
    radii = [s.radius for s in adjustment.solved().values()]
    assert np.ptp(radii) < 1e-9
    adjustment.forget(2)
    assert sorted(adjustment.solved()) == [0, 1]


def test_the_iteration_ends_where_a_surface_is_none_any_more():
    """The linear step towards one radius takes a loosely held ball below zero."""

    class Logarithms(Regularity):
        """Equal radii, by an equation that is far from linear."""

        def values(self, first, second):
            radii = [max(surface.radius, 1e-3) for surface in (first, second)]
            return np.array([np.log(radii[0] / radii[1])])

    firm = Estimate("sphere", Sphere(np.zeros(3), 0.3), 1e3 * np.eye(4))
    loose = Estimate("sphere", Sphere(np.ones(3), 1.0), 0.1 * np.eye(4))
    adjustment = Adjustment({0: firm, 1: loose})
    assert adjustment.propose(Logarithms((0, 1), "equal radius"))
    solved = adjustment.solved()
    assert not is_proper(solved[1], loose.surface)
    assert solved[1].radius == pytest.approx(1.0 - np.log(1.0 / 0.3), abs=1e-3)
    assert solved[0].radius == pytest.approx(0.3, abs=1e-3)


def test_free_forms_and_open_parameters_have_no_estimate(patches):
    rng = np.random.default_rng(5)
    knots = np.repeat([0.0, 1.0], 4)
    free = BSplineSurface(knots, knots, rng.normal(size=(4, 4, 3)))
    points = rng.normal(size=(50, 3))
    assert estimate(free, points, SIGMA) is None
    surface, points, _ = patches.cylinder(5, rng)
    assert estimate(surface, points, SIGMA) is None


def test_a_surface_must_stay_what_its_kind_says():
    origin, z = np.zeros(3), np.array([0.0, 0.0, 1.0])
    proper = [
        Plane(origin, z),
        Cylinder(origin, z, 2.0),
        Cone(origin, z, np.radians(45.0)),
        Torus(origin, z, 3.0, 1.0),
    ]
    assert all(is_proper(surface, surface) for surface in proper)
    degenerate = [
        Cylinder(origin, z, -0.1),
        Sphere(origin, 0.0),
        Cone(origin, z, np.radians(90.0)),
        Cone(origin, z, np.radians(0.1)),
    ]
    assert not any(is_proper(surface, surface) for surface in degenerate)


def test_a_torus_becomes_no_spindle_but_may_be_one():
    origin, z = np.zeros(3), np.array([0.0, 0.0, 1.0])
    ring, spindle = Torus(origin, z, 3.0, 1.0), Torus(origin, z, 1.0, 1.5)
    assert not is_proper(spindle, ring)
    assert is_proper(spindle, spindle)
    assert not is_proper(Torus(origin, z, -0.1, 1.5), spindle)
