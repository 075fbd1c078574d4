"""A chamfer two patches wide, in pieces."""

import numpy as np
import pytest
from turned import turned

from crispline.options import FitOptions, RegionOptions
from crispline.region.narrow.strips import joined_strips
from crispline.surface import Cylinder, Plane

TOP, STRIP, SIDE, OTHER, THIRD = range(5)
UP, ACROSS = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
LEAN = np.sqrt(0.5) * (UP + ACROSS)
EDGE = 14.0
PLANES = {TOP: Plane(np.zeros(3), UP), SIDE: Plane((EDGE + 2.0) * ACROSS, ACROSS)}
PIECE = Plane(EDGE * ACROSS, LEAN)


def chamfered(n_along=60):
    """A block with a chamfer; its patches, faces and where they stand along it."""
    part = turned([(3.0, 0.0), (EDGE, 0.0), (EDGE + 2.0, -2.0), (EDGE + 2.0, -9.0)], n_along, True)
    return part, part.evidence.graph.points[:, 1]


def closed_over(part, is_gap):
    """Labels with the strip shared by its neighbours in a gap."""
    above = part.evidence.graph.points[:, 2] > -1.0
    return np.where((part.face == STRIP) & is_gap, np.where(above, TOP, SIDE), part.face)


def joined(part, label, pieces):
    surfaces = PLANES | pieces
    return joined_strips(
        label, part.fits(surfaces, label), part.evidence, RegionOptions(), FitOptions()
    )


def in_three(part, along, width=2.0):
    label = closed_over(part, (np.abs(along - 20.0) < width) | (np.abs(along - 40.0) < width))
    label = np.where((label == STRIP) & (along > 20.0), OTHER, label)
    return np.where((label == OTHER) & (along > 40.0), THIRD, label)


def test_pieces_of_one_plane_are_joined_over_their_gaps():
    part, along = chamfered()
    label = in_three(part, along)
    new = joined(part, label, {STRIP: PIECE, OTHER: PIECE, THIRD: PIECE})
    assert not np.isin(new, (OTHER, THIRD)).any()
    assert (new == STRIP)[part.face == STRIP].mean() > 0.95
    assert not (new == STRIP)[part.face != STRIP].any()
    touching = np.sort(new[part.evidence.graph.pairs], axis=1)
    assert not (touching == (TOP, SIDE)).all(axis=1).any()


def test_pieces_that_touch_are_joined():
    part, along = chamfered()
    label = np.where((part.face == STRIP) & (along > 30.0), OTHER, part.face)
    np.testing.assert_array_equal(joined(part, label, {STRIP: PIECE, OTHER: PIECE}), part.face)


def test_pieces_between_other_faces_are_joined_where_they_touch():
    # As on the rim of a thin wall, which goes on round a corner.
    part, along = chamfered()
    beyond = along > 30.0
    label = np.where(beyond, part.face + 3, part.face)
    surfaces = {3: PLANES[TOP], 4: PIECE, 5: PLANES[SIDE], STRIP: PIECE, **PLANES}
    fits = part.fits(surfaces, label)
    new = joined_strips(
        label, fits, part.evidence, RegionOptions(max_pruned_patches=150), FitOptions()
    )
    np.testing.assert_array_equal(new == STRIP, part.face == STRIP)
    np.testing.assert_array_equal(new[part.face != STRIP], label[part.face != STRIP])


def test_pieces_of_one_cylinder_are_joined_where_they_touch():
    radius = 20.0
    part = turned([(3.0, 0.0), (radius, 0.0), (radius, -3.0), (3.0, -3.0)], 126)
    turn = np.arctan2(*part.evidence.graph.points[:, 1::-1].T)
    rim, piece = 1, 3
    label = np.where((part.face == rim) & (turn > 1.0), piece, part.face)
    leaning = np.array([0.06, 0.0, np.sqrt(1.0 - 0.06**2)])
    surfaces = {
        0: Plane(np.zeros(3), UP),
        rim: Cylinder(np.zeros(3), UP, radius),
        piece: Cylinder(np.zeros(3), leaning, radius),
        2: Plane(-3.0 * UP, -UP),
    }
    fits = part.fits(surfaces, label)
    new = joined_strips(label, fits, part.evidence, RegionOptions(), FitOptions())
    np.testing.assert_array_equal(new, part.face)


@pytest.mark.parametrize("tilt", [0.2, -0.2])
def test_planes_that_differ_stay_apart(tilt):
    part, along = chamfered()
    label = np.where((part.face == STRIP) & (along > 30.0), OTHER, part.face)
    leaning = PIECE.normal + tilt * np.array([0.0, 1.0, 0.0])
    other = Plane(PIECE.origin + 30.0 * np.array([0.0, 1.0, 0.0]), leaning / np.sqrt(1 + tilt**2))
    fits = part.fits(PLANES | {STRIP: PIECE, OTHER: other}, label)
    moved = fits[OTHER].points - fits[OTHER].residuals[:, None] * other.normal
    fits[OTHER] = type(fits[OTHER])(other, 1, moved, 0.0 * fits[OTHER].residuals)
    new = joined_strips(label, fits, part.evidence, RegionOptions(), FitOptions())
    np.testing.assert_array_equal(new, label)


def test_a_sharp_edge_between_two_chamfers_stays_sharp():
    sharp = turned([(3.0, 0.0), (EDGE + 1.0, 0.0), (EDGE + 1.0, -9.0)], 60, True)
    points = sharp.evidence.graph.points
    near = np.abs(points[:, 0] - EDGE - points[:, 2] - 1.0) < 1.0
    label = np.where(sharp.face == 1, SIDE, TOP)
    label = np.where(near & (points[:, 1] < 15.0), STRIP, label)
    label = np.where(near & (points[:, 1] > 45.0), OTHER, label)
    stub = Plane((EDGE + 0.3) * ACROSS, LEAN)
    surfaces = PLANES | {SIDE: Plane((EDGE + 1.0) * ACROSS, ACROSS), STRIP: stub, OTHER: stub}
    fits = sharp.fits(surfaces, label)
    new = joined_strips(label, fits, sharp.evidence, RegionOptions(), FitOptions())
    np.testing.assert_array_equal(new, label)
