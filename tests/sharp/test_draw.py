"""Borders and corners of sculptures, on two planes that meet at an angle."""

import numpy as np
import pytest

from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain
from crispline.sharp.between import N_ROUNDS, curve_through, points_along
from crispline.sharp.draw import Drawing
from crispline.sharp.trace import guide_along
from crispline.surface import Cylinder, Plane, Sphere
from crispline.surface.intersect import angles, distance, newton_step

OPTIONS = LocateOptions(smooth_angle_deg=25.0)
UP = np.array([0.0, 0.0, 1.0])


def region(surface, orientation=1):
    return RegionFit(surface, orientation, np.zeros((0, 3)), np.zeros(0))


def between(angle_deg):
    """A drawing of a level plane and one that falls off beyond the x axis."""
    angle = np.radians(angle_deg)
    slope = np.array([0.0, np.sin(angle), np.cos(angle)])
    return Drawing({k: region(Plane(0.0 * UP, n)) for k, n in enumerate((UP, slope))}, OPTIONS)


def path(height=0.0):
    x = np.arange(21.0)
    return np.column_stack([x, 0.4 * (-1.0) ** np.arange(21), np.full(21, height)])


def border_of(drawing, points, right=1, is_closed=False):
    chain = Chain(np.arange(len(points)), 0, right)
    return chain, drawing.borders([chain], [guide_along(points, is_closed)])[0]


@pytest.mark.parametrize(("angle_deg", "is_sharp"), [(20.0, False), (30.0, True), (90.0, True)])
def test_the_angle_along_the_guide_tells_what_is_sharp(angle_deg, is_sharp):
    drawing = between(angle_deg)
    assert border_of(drawing, path())[1].is_contact != is_sharp
    rim = border_of(drawing, path(), right=-1)[1]
    assert not rim.is_contact
    assert len(rim.surfaces) == 1


def test_a_sharp_border_is_drawn_onto_its_edge_and_a_smooth_one_stays():
    for angle_deg, is_sharp in ((90.0, True), (10.0, False)):
        drawing = between(angle_deg)
        chain, border = border_of(drawing, path(0.3))
        (crease,) = drawing.creases([chain], [border], [(0.0 * UP, np.array([20.0, 0.0, 0.0]))])
        middle = crease.curve.samples(101)[30:71]
        assert abs(middle[:, 1]).max() < 0.1
        level = 0.0 if is_sharp else 0.3
        np.testing.assert_allclose(middle[:, 2], level, atol=0.1)
        assert np.degrees(crease.angle) == pytest.approx(angle_deg, abs=1e-9)


def test_a_closed_smooth_border_stays_closed():
    turn = np.linspace(0.0, 2.0 * np.pi, 41)
    ring = np.column_stack([6.0 * np.cos(turn), 6.0 * np.sin(turn), 0.0 * turn])
    drawing = between(5.0)
    chain, border = border_of(drawing, ring, is_closed=True)
    ends = drawing.creases([chain], [border], [None])[0].curve.samples(2)
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-9)


def test_an_end_of_a_sharp_border_goes_to_where_its_surfaces_meet_unless_that_is_far():
    ball, far = Sphere(np.array([9.0, 0.0, 0.0]), 7.0), Sphere(0.0 * UP, 20.0)
    planes = between(90.0).regions
    drawing = Drawing({**planes, 2: region(ball), 3: region(far)}, OPTIONS)
    pairs = [(0, 1), (0, 2), (0, 3), (1, 3)]
    chains = [Chain(np.arange(2), left, right) for left, right in pairs]
    borders = [border_of(between(90.0), path())[1]] * 3
    borders.append(border_of(between(10.0), path())[1])  # a smooth one holds no corner
    places = np.array([[3.0, 0.5, 0.4], [2.4, 0.5, 0.4], 3.0 * UP, [1.0, 2.0, 3.0]])
    edge, point, away, free = drawing.corners(places, [[0, 3], [0, 1], [2], [3]], chains, borders)
    np.testing.assert_allclose(edge.position, [3.0, 0.0, 0.0], atol=1e-12)
    assert edge.gap == pytest.approx(0.0, abs=1e-12)
    np.testing.assert_allclose(point.position, [2.0, 0.0, 0.0], atol=1e-3)
    np.testing.assert_array_equal(away.position, places[2])
    assert away.gap == pytest.approx(17.0)
    np.testing.assert_array_equal(free.position, places[3])
    assert free.gap == 0.0


def test_drawing_all_together_gives_what_drawing_one_by_one_does():
    rng = np.random.default_rng(1)
    surfaces = [
        Plane(0.0 * UP, UP),
        Plane(np.array([0.0, 2.0, 0.0]), np.array([0.0, 0.8, 0.6])),
        Sphere(np.array([0.0, 0.0, -9.0]), 9.5),
        Cylinder(np.array([0.0, 0.0, -6.0]), np.array([1.0, 0.0, 0.0]), 6.5),
    ]
    drawing = Drawing(
        {k: region(surface, (-1) ** (k == 2)) for k, surface in enumerate(surfaces)}, OPTIONS
    )
    names = [(0, 1), (2, 0), (3, 1), (1, -1), (3, 0), (2, 3)]
    chains = [Chain(np.arange(21), left, right) for left, right in names]
    paths = [path() + rng.normal(0.0, 0.2, (21, 3)) for _ in names]
    guides = [guide_along(points, is_closed=False) for points in paths]
    borders = drawing.borders(chains, guides)
    around = [[0, 2], [1, 3, 5], [4]]
    corners = drawing.corners(np.stack([p[0] for p in paths[:3]]), around, chains, borders)
    ends = [(points[0], points[-1]) for points in paths]
    creases = drawing.creases(chains, borders, ends)
    assert {border.is_contact for border in borders} == {True, False}

    for border, guide, tips, crease in zip(borders, guides, ends, creases, strict=True):
        at = np.linspace(0, len(guide.points) - 1, 15).astype(int)
        if len(border.surfaces) == 2:
            told = angles(guide.points[at], border.surfaces, border.orientations)
            assert border.is_contact == (np.degrees(np.median(told)) < 25.0)
        if not border.is_contact:
            start = points = points_along(guide)
            for _ in range(N_ROUNDS):
                points = np.mean([s.project(points)[0] for s in border.surfaces], axis=0)
            naive = curve_through(guide, start, points, tips)
            np.testing.assert_allclose(crease.curve.samples(50), naive.samples(50), atol=1e-9)
        samples = crease.curve.samples(25)
        assert crease.gap == pytest.approx(distance(samples, border.surfaces).max())
        assert crease.angle == pytest.approx(border.angle(samples), abs=1e-9)
    for corner, ending, points in zip(corners, around, paths[:3], strict=True):
        sharp = [names[index] for index in ending if not borders[index].is_contact]
        beside = [surfaces[name] for name in sorted({*np.ravel(sharp).astype(int)} - {-1})]
        position = points[:1]
        for _ in range(2 * bool(beside)):
            position = position + newton_step(position, beside)
        if np.linalg.norm(position - points[0]) > OPTIONS.corner_move:
            position = points[:1]
        np.testing.assert_allclose(corner.position, position[0], atol=1e-9)


def test_nothing_is_drawn_of_a_body_without_borders():
    drawing = between(90.0)
    assert drawing.borders([], []) == []
    assert drawing.corners(np.zeros((0, 3)), [], [], []) == []
    assert drawing.creases([], [], []) == []
