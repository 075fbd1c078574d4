"""Crumbs of a chamfer become one cone about the shaft's axis, where the truth is known."""

import numpy as np
import pytest
from turned import turned

from crispline.fit.choose import PRIMITIVE_FITS
from crispline.options import RegionOptions
from crispline.region.narrow.restore import closed_rings
from crispline.region.narrow.ring import with_rings
from crispline.surface import Cone, Cylinder, Plane

END, CHAMFER, SHAFT = 0, 1, 2
CRUMBS = (3, 4, 5)
RADIUS, WIDTH = 14.0, 2.0
OPTIONS = RegionOptions()
UP = np.array([0.0, 0.0, 1.0])
LARGER = {SHAFT: Cylinder(np.zeros(3), UP, RADIUS), END: Plane(WIDTH * UP, UP)}


def shaft(chamfer=WIDTH):
    corners = [(4.0, WIDTH), (RADIUS - chamfer, WIDTH), (RADIUS, WIDTH - chamfer), (RADIUS, -8.0)]
    return turned(corners if chamfer else [*corners[:2], corners[3]], 90)


def crumbled(part):
    """Thirds of the chamfer are crumbs, each with the plane of its own; a gap is left to others."""
    points = part.evidence.graph.points
    turn = np.arctan2(points[:, 1], points[:, 0])
    third = np.floor(3.0 * (turn + np.pi) / (2.0 * np.pi + 1e-9)).astype(int)
    crumb = np.where(np.abs(turn) < 0.15, SHAFT, np.array(CRUMBS)[third])
    label = np.where(part.face == CHAMFER, crumb, part.face)
    normals = part.evidence.graph.normals
    surfaces = dict(LARGER)
    for name in CRUMBS:
        own = label == name
        surfaces[name] = PRIMITIVE_FITS["sphere"](points[own], normals[own], 0.1)
    return label, surfaces


def test_crumbs_of_a_chamfer_become_one_cone():
    part = shaft()
    label, surfaces = crumbled(part)
    fits = part.fits(surfaces, label)
    new, rings = with_rings(label, fits, part.evidence, OPTIONS)
    ((name, ring),) = rings.items()
    assert isinstance(ring.surface, Cone)
    assert abs(ring.surface.axis @ UP) == pytest.approx(1.0, abs=1e-12)
    np.testing.assert_allclose(ring.surface.apex, [0.0, 0.0, RADIUS], atol=0.5)
    assert ring.surface.half_angle == pytest.approx(np.pi / 4.0, abs=0.05)
    assert ring.orientation == 1
    assert (new[part.face == CHAMFER] == name).mean() > 0.9
    assert (new[part.face != CHAMFER] != name).mean() > 0.95
    assert not np.isin(new, [c for c in CRUMBS if c != name]).any()


def test_a_part_of_a_chamfer_yields_to_all_of_it_even_if_that_hardly_explains_more():
    part = shaft(chamfer=1.8)
    points = part.evidence.graph.points
    is_seen = np.abs(np.arctan2(points[:, 1], points[:, 0])) < 0.8
    beside = np.where(points[:, 2] > WIDTH - 0.9, END, SHAFT)
    label = np.where((part.face == CHAMFER) & ~is_seen, beside, part.face)
    fits = part.fits(
        {**LARGER, CHAMFER: Cone((WIDTH + RADIUS - 1.8) * UP, -UP, np.pi / 4.0)}, label
    )
    new, rings = with_rings(label, fits, part.evidence, OPTIONS)
    assert isinstance(rings[CHAMFER].surface, Cone)
    assert (new[part.face == CHAMFER] == CHAMFER).mean() > 0.8


def test_a_sharp_rim_stays_sharp():
    part = shaft(chamfer=0.0)
    label = np.where(part.face == 0, END, SHAFT)
    new, rings = with_rings(label, part.fits(LARGER, label), part.evidence, OPTIONS)
    assert not rings
    np.testing.assert_array_equal(new, label)


def test_a_whole_chamfer_keeps_its_surface():
    part = shaft()
    cone = Cone(RADIUS * UP, -UP, np.pi / 4.0)
    fits = part.fits({**LARGER, CHAMFER: cone}, part.face)
    _, rings = with_rings(part.face, fits, part.evidence, OPTIONS)
    assert not rings


def test_gaps_of_a_ring_are_closed():
    part = shaft()
    points = part.evidence.graph.points
    turn = np.arctan2(points[:, 1], points[:, 0])
    label = np.where((part.face == CHAMFER) & (np.abs(turn) < 0.5), SHAFT, part.face)
    rings = part.fits({CHAMFER: Cone(RADIUS * UP, -UP, np.pi / 4.0)}, label)
    closed = closed_rings(label, rings, part.evidence.graph, OPTIONS)
    ends = np.sort(closed[part.evidence.graph.pairs], axis=1)
    assert not (ends == (SHAFT, END)).all(axis=1).any()
    assert (closed == CHAMFER).sum() > (label == CHAMFER).sum()
