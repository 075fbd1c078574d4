"""Narrow faces in a net: rings and steps one after the other, and what is fitted again."""

import numpy as np
from turned import turned

from crispline.net.halfedge import half_edges
from crispline.options import FitOptions, RegionOptions
from crispline.region.narrow.restore import restored
from crispline.surface import Cone, Cylinder, Plane, Sphere

TOP, WALL, SHOULDER, CHAMFER, SHAFT = range(5)
CRUMBS = (5, 6)
N_AROUND = 90
UP = np.array([0.0, 0.0, 1.0])
OPTIONS = RegionOptions()
SURFACES = {
    TOP: Plane(1.5 * UP, UP),
    SHOULDER: Plane(np.zeros(3), UP),
    SHAFT: Cylinder(np.zeros(3), UP, 16.0),
}


def stepped_shaft():
    """A pad on the end of a shaft with a chamfered rim; its wall and the chamfer are lost."""
    corners = [(3.0, 1.5), (9.0, 1.5), (9.0, 0.0), (14.0, 0.0), (16.0, -2.0), (16.0, -9.0)]
    part = turned(corners, N_AROUND)
    points = part.evidence.graph.points
    above = np.where(points[:, 2] > 0.75, TOP, SHOULDER)
    label = np.where(part.face == WALL, above, part.face)
    halves = np.where(points[:, 1] > 0.0, *CRUMBS)
    return part, np.where(part.face == CHAMFER, halves, label)


def connectivity(part):
    row, turn = np.divmod(np.arange(len(part.face)), N_AROUND)
    first, second = row * N_AROUND + turn, row * N_AROUND + (turn + 1) % N_AROUND
    quads = np.column_stack([first, second, second + N_AROUND, first + N_AROUND])
    points = part.evidence.graph.points
    vertices = np.concatenate([points, points[-N_AROUND:]])  # near enough
    return vertices, half_edges(quads, len(vertices))


def run(part, label, fits, refit):
    return restored(label, fits, refit, *connectivity(part), part.evidence, OPTIONS, FitOptions())


def test_the_wall_and_the_chamfer_come_back():
    part, label = stepped_shaft()
    surfaces = {**SURFACES, **{crumb: Sphere(-4.0 * UP, 15.6) for crumb in CRUMBS}}
    fits = part.fits(surfaces, label)
    asked = []

    def refit(new):
        asked.append(new)
        return {name: fits.get(name, fits[TOP]) for name in np.unique(new).tolist()}

    new, found = run(part, label, fits, refit)
    assert len(asked) == 2  # after the ring, after the wall
    assert sorted(found) == np.unique(new).tolist()
    (chamfer,) = np.unique(new[part.face == CHAMFER]).tolist()
    assert isinstance(found[chamfer].surface, Cone)
    wall, shaft = sorted(
        fit.surface.radius for fit in found.values() if isinstance(fit.surface, Cylinder)
    )
    np.testing.assert_allclose([wall, shaft], [9.0, 16.0], atol=0.3)
    assert len(found) == 5
    ends = np.sort(new[part.evidence.graph.pairs], axis=1)
    for lost in ((TOP, SHOULDER), (SHOULDER, SHAFT)):
        assert not (ends == lost).all(axis=1).any()


def test_what_is_whole_is_not_touched():
    part, _ = stepped_shaft()
    surfaces = {**SURFACES, WALL: Cylinder(np.zeros(3), UP, 9.0)}
    fits = part.fits({**surfaces, CHAMFER: Cone(14.0 * UP, -UP, np.pi / 4.0)}, part.face)
    new, found = run(part, part.face, fits, _never)
    np.testing.assert_array_equal(new, part.face)
    assert all(found[name] is fit for name, fit in fits.items())


def _never(_label):
    raise AssertionError("nothing has changed")
