"""Straight ends of a bent tube that its arc has covered."""

import numpy as np
import pytest
from witnessed import witnessed

from crispline.fit.bend import Bend
from crispline.fit.torus import fit_torus
from crispline.options import RegionOptions
from crispline.region.fitting import held_fit
from crispline.region.narrow.straights import with_straights
from crispline.surface import Cylinder, Torus

ARC, PIECE = 0, 1
MAJOR, MINOR, SIGMA, N_AROUND = 40.0, 9.0, 0.15, 56
X, Y, Z = np.eye(3)
TUBE = Bend(Torus(np.zeros(3), Z, MAJOR, MINOR), X, -0.6, 0.6)
OPTIONS = RegionOptions()


def tube(lengths):
    """Unit patches of a tube, straight for so long before and after its arc."""
    arc = MAJOR * (TUBE.last - TUBE.first)
    at = np.arange(-lengths[0] + 0.5, arc + lengths[1]).repeat(N_AROUND)
    outward = TUBE.outward(TUBE.first + np.clip(at, 0.0, arc) / MAJOR)
    beyond = np.where(at < 0.0, at, np.maximum(at - arc, 0.0))[:, None]
    turn = np.tile(2.0 * np.pi * np.arange(N_AROUND) / N_AROUND, len(at) // N_AROUND)[:, None]
    normals = np.cos(turn) * outward + np.sin(turn) * Z
    points = MAJOR * outward + beyond * np.cross(Z, outward) + MINOR * normals
    number = np.arange(len(at)).reshape(-1, N_AROUND)
    pairs = [(number[1:], number[:-1]), (number, np.roll(number, 1, axis=1))]
    pairs = np.concatenate([np.column_stack([a.ravel(), b.ravel()]) for a, b in pairs])
    return witnessed(points, normals, pairs, SIGMA), np.where(at < 0.0, -1, at > arc)


def covered(evidence, label):
    """The surface of each region, as it is fitted to what the region has."""
    fits = {}
    for name in np.unique(label).tolist():
        rows = label[evidence.patch] == name
        surface = fit_torus(evidence.points[rows], evidence.normals[rows], SIGMA)
        if name == PIECE:
            surface = Cylinder(TUBE.straight(0).origin + 0.2, TUBE.straight(0).axis, 1.03 * MINOR)
        assert surface is not None
        fits[name] = held_fit(surface, np.flatnonzero(label == name), evidence)
    return fits


@pytest.mark.parametrize("lengths", [(9.0, 9.0), (0.0, 9.0)])
def test_an_arc_gives_back_the_straight_ends_it_has_covered(lengths):
    evidence, end = tube(lengths)
    label = np.full(len(end), ARC)
    new, bends = with_straights(label, covered(evidence, label), evidence, OPTIONS)
    sides = [side for side in (0, 1) if lengths[side]]
    assert len(bends) == 1 + len(sides)
    assert bends[ARC].surface.major_radius == pytest.approx(MAJOR, abs=0.2)
    for side in sides:
        own = end == (-1, 1)[side]
        (name,) = set(new[own & (np.abs(end) == 1)].tolist()) - {ARC}
        assert (new[own] == name).mean() > 0.75
        assert (new[~own] == name).mean() < 0.1
        straight = bends[name].surface
        assert isinstance(straight, Cylinder)
        assert straight.radius == bends[ARC].surface.minor_radius
        assert abs(straight.axis @ TUBE.straight(side).axis) == pytest.approx(1.0, abs=1e-3)


def test_a_piece_of_a_straight_end_gives_way_to_all_of_it():
    evidence, end = tube((9.0, 0.0))
    half = evidence.graph.points[:, 2] > 0.0
    label = np.where((end == -1) & half, PIECE, ARC)
    new, bends = with_straights(label, covered(evidence, label), evidence, OPTIONS)
    (name,) = set(bends) - {ARC}
    assert not (new == PIECE).any()
    assert (new[end == -1] == name).mean() > 0.75


def test_a_bend_without_straight_ends_stays():
    evidence, end = tube((0.0, 0.0))
    label = np.full(len(end), ARC)
    new, bends = with_straights(label, covered(evidence, label), evidence, OPTIONS)
    assert not bends
    assert (new == ARC).all()


def test_what_goes_all_round_has_no_end():
    turn = 2.0 * np.pi * np.arange(48) / 48
    whole = Torus(np.zeros(3), Z, 15.0, 6.0)
    around, across = (grid.ravel()[:, None] for grid in np.meshgrid(turn, turn))
    outward = np.cos(around) * X + np.sin(around) * Y
    normals = np.cos(across) * outward + np.sin(across) * Z
    points = 15.0 * outward + 6.0 * normals
    number = np.arange(len(points)).reshape(48, 48)
    pairs = np.column_stack([number.ravel(), np.roll(number, 1, axis=1).ravel()])
    evidence = witnessed(points, normals, pairs, SIGMA)
    label = np.zeros(len(points), dtype=int)
    fits = {ARC: held_fit(whole, np.arange(len(points)), evidence)}
    assert with_straights(label, fits, evidence, OPTIONS)[1] == {}
