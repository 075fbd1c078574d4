"""Creases between surfaces of every kind, from ragged chains."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.sharp.contact import Contact
from crispline.sharp.crease import border_between, locate_crease
from crispline.sharp.network import corner_vertices, split
from crispline.sharp.trace import forward, guide_along, is_sane
from crispline.surface import (
    BSplineSurface,
    Cone,
    Cylinder,
    Plane,
    Sphere,
    Torus,
    perpendicular_frame,
    unit,
)
from crispline.surface.intersect import intersect

X, Y, Z = np.eye(3)
ORIGIN = np.zeros(3)
TURN = 2.0 * np.pi


def wavy(n=12, size=50.0):
    knots = np.concatenate([np.zeros(3), np.linspace(0.0, 1.0, n - 2), np.ones(3)])
    greville = np.array([knots[i + 1 : i + 4].mean() for i in range(n)])
    x, y = np.meshgrid((greville - 0.5) * size, (greville - 0.5) * size, indexing="ij")
    return BSplineSurface(
        knots, knots, np.stack([x, y, 3.0 * np.sin(x / 8.0) * np.cos(y / 9.0)], axis=2)
    )


def oblique_section(cone, normal):
    def curve(t):
        x, y = perpendicular_frame(cone.axis)
        around = np.cos(TURN * t)[:, None] * x + np.sin(TURN * t)[:, None] * y
        rulings = np.cos(cone.half_angle) * cone.axis + np.sin(cone.half_angle) * around
        return cone.apex - ((cone.apex @ normal) / (rulings @ normal))[:, None] * rulings

    return curve


def saddle(radius, through):
    def curve(t):
        x, y = radius * np.cos(TURN * t), radius * np.sin(TURN * t)
        return np.column_stack([x, y, np.sqrt(through**2 - y**2)])

    return curve


def closed_case(name, ring):
    """Two surfaces, their closed crease and the kind of curve expected for it."""
    tilted = unit(np.array([0.4, 0.0, 1.0]))
    cone = Cone(20.0 * Z, -Z, np.radians(30.0))
    cylinder = Cylinder(ORIGIN, Z, 6.0)
    spline = wavy()
    return {
        "plane-cylinder": (Plane(ORIGIN, Z), cylinder, ring(6.0, 0.0), "circle"),
        "small hole": (Plane(ORIGIN, Z), Cylinder(ORIGIN, Z, 3.0), ring(3.0, 0.0), "circle"),
        "sphere-cylinder": (Sphere(ORIGIN, 10.0), cylinder, ring(6.0, 8.0), "circle"),
        "cone-cylinder": (
            Cone(-8.0 * Z, Z, np.arctan(0.75)),
            cylinder,
            ring(6.0, 0.0),
            "circle",
        ),
        "torus-plane": (Torus(ORIGIN, Z, 12.0, 5.0), Plane(3.0 * Z, Z), ring(16.0, 3.0), "circle"),
        "cylinder-cylinder": (Cylinder(ORIGIN, X, 15.0), cylinder, saddle(6.0, 15.0), "bspline"),
        "nearly equal": (
            Cylinder(ORIGIN, X, 15.0),
            Cylinder(ORIGIN, Z, 14.0),
            saddle(14.0, 15.0),
            "bspline",
        ),
        "plane-cone": (Plane(ORIGIN, tilted), cone, oblique_section(cone, tilted), "bspline"),
        "spline-cylinder": (
            spline,
            Cylinder(ORIGIN, Z, 12.0),
            lambda t: intersect(ring(12.0, 0.0)(t), [spline, Cylinder(ORIGIN, Z, 12.0)])[0],
            "bspline",
        ),
    }[name]


@pytest.mark.parametrize(("raggedness", "seed"), [(0.0, 0), (1.5, 1)])
@pytest.mark.parametrize(
    "name",
    [
        "plane-cylinder",
        "small hole",
        "sphere-cylinder",
        "cone-cylinder",
        "torus-plane",
        "cylinder-cylinder",
        "nearly equal",
        "plane-cone",
        "spline-cylinder",
    ],
)
def test_closed_crease_is_recovered(shapes, name, raggedness, seed):
    network = shapes["Network"](raggedness, seed)
    first, second, curve, kind = closed_case(name, shapes["ring"])
    network.region(0, first)
    network.region(1, second)
    network.chain(1, 0, curve=curve)
    model, warnings = network.located()
    assert warnings == ()
    (edge,) = model.edges
    assert edge.start == edge.end
    assert edge.curve.kind == kind
    assert edge.is_sharp
    assert edge.gap < (1e-9 if kind == "circle" else 1e-5)
    # No fold, and once round: the length is the truth's.
    samples, truth = edge.curve.samples(4000), network.truth[0]
    assert shapes["length"](samples) == pytest.approx(shapes["length"](truth), rel=1e-3)
    assert cKDTree(samples).query(truth)[0].max() < 0.05
    # In the chain's direction.
    middle = edge.curve.evaluate(np.array([edge.curve.start, edge.curve.start + 1e-3]))
    at = cKDTree(truth[:-1]).query(middle[0])[1]
    assert (middle[1] - middle[0]) @ (truth[at + 1] - truth[at]) > 0.0


def test_a_tangent_dome_touches_along_its_equator(shapes):
    network = shapes["Network"](1.0, 0)
    network.region(0, Cylinder(ORIGIN, Z, 8.0))
    network.region(1, Sphere(ORIGIN, 8.04))
    network.chain(1, 0, curve=shapes["ring"](8.0, 0.0))
    model, warnings = network.located()
    assert warnings == ()
    (edge,) = model.edges
    assert edge.curve.kind == "circle"
    assert not edge.is_sharp
    assert edge.gap == pytest.approx(0.02, abs=1e-6)
    np.testing.assert_allclose(edge.curve.samples(30)[:, 2], 0.0, atol=1e-6)


def test_the_long_way_round_is_taken_if_the_chain_takes_it(shapes):
    """A round post with a narrow flat: its arcs span nine tenths of a turn."""
    network = shapes["Network"](0.8, 0)
    ring, end = shapes["ring"], 0.9 * TURN
    middle = np.array([np.cos(0.5 * end), np.sin(0.5 * end), 0.0])
    network.region(0, Plane(ORIGIN, -Z))
    network.region(1, Cylinder(ORIGIN, Z, 12.0))
    network.region(2, Plane(12.0 * X, -middle))
    network.region(3, Plane(10.0 * Z, Z))
    corners = [
        (network.corner(12.0, 0.0, z), network.corner(12.0 * np.cos(end), 12.0 * np.sin(end), z))
        for z in (0.0, 10.0)
    ]
    for (first, last), height, (left, right) in zip(
        corners, (0.0, 10.0), ((1, 0), (3, 1)), strict=True
    ):
        network.chain(left, right, first, last, lambda t, z=height: ring(12.0, z)(0.9 * t))
    network.chain(2, 0, corners[0][1], corners[0][0])
    network.chain(3, 2, corners[1][1], corners[1][0])
    network.chain(2, 1, corners[0][0], corners[1][0])
    network.chain(1, 2, corners[0][1], corners[1][1])
    model, warnings = network.located()
    assert warnings == ()
    assert [edge.curve.kind for edge in model.edges] == ["circle"] * 2 + ["line"] * 4
    for edge, truth in zip(model.edges, network.truth, strict=True):
        np.testing.assert_allclose(edge.curve.samples(2001), truth, atol=1e-8)


def test_contact_of_plane_and_cylinder_is_the_sheet_through_the_axis():
    contact = Contact(Plane(5.0 * Z, Z), Cylinder(ORIGIN, X, 5.0), 1)
    points = np.array([[0.0, 1.0, 5.0], [7.0, -2.0, 4.5], [3.0, 0.5, 6.0]])
    for _ in range(20):
        points, normals = contact.project(points)
    np.testing.assert_allclose(points[:, 1], 0.0, atol=1e-9)
    np.testing.assert_allclose(np.abs(normals), [Y] * 3, atol=1e-9)


def test_two_planes_have_no_contact():
    _, normals = Contact(Plane(ORIGIN, Z), Plane(Z, Z), 1).project(np.ones((4, 3)))
    np.testing.assert_array_equal(normals, 0.0)


def test_forward_drops_what_runs_backwards():
    x = np.array([0.0, 1.0, 2.0, 1.5, 1.2, 2.5, 4.0, 5.5])
    points = np.column_stack([x, np.zeros((8, 2))])
    ends = (0.5 * X, 5.0 * X)
    kept = forward(points, np.tile(X, (8, 1)), ends)
    np.testing.assert_array_equal(kept[:, 0], [0.5, 1.0, 2.0, 2.5, 4.0, 5.0])


def test_a_fold_and_a_stray_are_not_sane():
    line = np.column_stack([np.linspace(0.0, 20.0, 21), np.zeros((21, 2))])
    guide, cloud = guide_along(line, False), cKDTree(line)
    assert is_sane(line, guide, 0.0, cloud, 2.2)
    folded = line.copy()
    folded[10, 0] = 8.5
    assert not is_sane(folded, guide, 0.0, cloud, 2.2)
    strayed = line + np.sin(np.linspace(0.0, np.pi, 21))[:, None] * 2.5 * Y
    assert not is_sane(strayed, guide, 0.0, cloud, 2.2)


@pytest.mark.parametrize(
    ("opening_deg", "away", "is_found"),
    [(45.0, 5.0, True), (90.0, 5.0, False), (90.0, 3.6, True), (90.0, 2.0, True)],
)
def test_a_net_rounds_off_an_acute_edge_farther(opening_deg, away, is_found):
    radius = 20.0  # and the chain runs ``away`` spacings beside the edge
    half_angle = np.radians(opening_deg)
    sides = [
        RegionFit(Cylinder(ORIGIN, Z, radius), 1, np.empty((0, 3)), np.empty(0)),
        RegionFit(
            Cone(-radius / np.tan(half_angle) * Z, Z, half_angle), -1, np.empty((0, 3)), np.empty(0)
        ),
    ]
    angle = np.linspace(0.0, TURN, 121)
    edge = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(121)])
    guide = guide_along(edge + away * Z, is_closed=True)
    border = border_between(guide, sides, LocateOptions())
    assert np.degrees(border.angle(edge)) == pytest.approx(180.0 - opening_deg)
    crease = locate_crease(border, None, cKDTree(edge), 2.2, LocateOptions())
    assert crease.is_fallback != is_found
    assert (crease.gap < 1e-9) == is_found


def test_splitting_a_chain_keeps_the_loops(shapes):
    topology = shapes["box"](0.0, 0).topology()
    cut = split(topology, 0, 5)
    assert len(cut.chains) == 13
    assert len(corner_vertices(cut)) == 9
    for region in (topology.chains[0].left, topology.chains[0].right):
        assert [len(loop) for loop in cut.loops[region]] == [5]
        (loop,) = cut.loops[region]
        ends = [cut.chains[i].vertices[::side][[0, -1]] for i, side in loop]
        assert all(a[1] == b[0] for a, b in zip(ends, ends[1:] + ends[:1], strict=True))


@pytest.mark.parametrize("seed", range(3))
def test_a_round_that_begins_to_bend_has_a_border_that_does_not_wander(seed):
    """A cylinder and the torus it goes over into curve alike at the top of the round."""
    rng = np.random.default_rng(seed)
    turn = np.linspace(0.0, np.pi / 2.0, 200)
    arc = np.column_stack([np.zeros(200), 10.0 + 5.0 * np.cos(turn), 5.0 * np.sin(turn)])
    cylinder = Cylinder(np.array([0.0, 10.01, 0.0]), unit(np.array([1.0, 0.002, -0.003])), 5.0)
    sides = [
        RegionFit(surface, 1, arc, np.zeros(200))
        for surface in (cylinder, Torus(ORIGIN, Z, 10.0, 5.01))
    ]
    ragged = arc[::25] + 0.5 * rng.uniform(-1.0, 1.0, (8, 3))
    guide = guide_along(np.concatenate([arc[:1], ragged[1:], arc[-1:]]), False)
    options = LocateOptions()
    border = border_between(guide, sides, options)
    assert border.is_contact
    found = locate_crease(border, (arc[0], arc[-1]), cKDTree(arc), 2.0, options)
    assert not found.is_fallback
    assert found.gap < 0.03
    points = found.curve.samples(400)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length == pytest.approx(5.0 * np.pi / 2.0, rel=0.1)


@pytest.mark.parametrize(("noise", "seed"), [(5e-3, 0), (5e-3, 2), (1e-2, 1), (1e-2, 2)])
def test_a_smooth_border_does_not_wander_where_the_surfaces_are_nearly_one(noise, seed):
    """A plane and what leaves it by ``y**2 / 2000`` and the noise of a fit."""
    n, size = 12, 24.0
    knots = np.concatenate([np.zeros(3), np.linspace(0.0, 1.0, n - 2), np.ones(3)])
    greville = np.array([knots[i + 1 : i + 4].mean() for i in range(n)])
    x, y = np.meshgrid(greville * size, (greville - 0.5) * size, indexing="ij")
    z = y**2 / 2000.0 + noise * np.random.default_rng(seed).normal(size=x.shape)
    surfaces = [Plane(ORIGIN, Z), BSplineSurface(knots, knots, np.stack([x, y, z], axis=2))]
    sides = [RegionFit(surface, 1, np.empty((0, 3)), np.empty(0)) for surface in surfaces]
    line = np.column_stack([np.linspace(2.0, 22.0, 21), np.zeros((21, 2))])
    border = border_between(guide_along(line, is_closed=False), sides, LocateOptions())
    ends = (line[0], line[-1])
    crease = locate_crease(border, ends, cKDTree(line), 15.0, LocateOptions())
    assert crease.curve.kind == "line"
    assert crease.gap < 0.02


def test_the_foot_of_a_boss_does_not_take_the_short_way_under_its_rib():
    """A fillet between a plane and a boss, round all of it but for a rib of 6 spacings."""
    torus = Torus(np.array([0.0, 0.0, 4.0]), Z, 20.0, 4.0)
    half = np.arcsin(3.0 / 20.0)
    turn = np.linspace(half, 2.0 * np.pi - half, 150)
    foot = 20.0 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(150)])
    sides = [
        RegionFit(Plane(ORIGIN, Z), 1, foot, np.zeros(150)),
        RegionFit(torus, -1, foot, np.zeros(150)),
    ]
    border = border_between(guide_along(foot, is_closed=False), sides, LocateOptions())
    assert border.is_contact
    found = locate_crease(border, (foot[0], foot[-1]), cKDTree(foot), 2.0, LocateOptions())
    steps = np.diff(found.curve.samples(400), axis=0)
    length = np.linalg.norm(steps, axis=1).sum()
    assert length == pytest.approx(20.0 * (turn[-1] - turn[0]), rel=0.01)
    assert found.gap < 1e-6


def test_surfaces_that_touch_nowhere_have_a_border_that_does_not_wander():
    """A chamfer and the cone that goes on from it, fitted a few degrees apart."""
    lean = np.radians(4.0)
    flat = Plane(ORIGIN, Z)
    axis = unit(np.array([0.0, np.cos(lean), np.sin(lean)]))
    round_ = Cylinder(np.array([0.3, 0.0, -25.05]), axis, 25.0)
    line = np.column_stack([np.zeros(9), np.linspace(-1.2, 1.2, 9), np.zeros(9)])
    sides = [RegionFit(surface, 1, line, np.zeros(9)) for surface in (flat, round_)]
    border = border_between(guide_along(line, is_closed=False), sides, LocateOptions())
    assert border.is_contact
    ends = (np.array([3.0, -1.2, 0.0]), np.array([-3.0, 1.2, 0.0]))
    found = locate_crease(border, ends, cKDTree(line), 4.0, LocateOptions())
    points = found.curve.samples(200)
    length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
    assert length < 1.05 * np.linalg.norm(ends[1] - ends[0])
