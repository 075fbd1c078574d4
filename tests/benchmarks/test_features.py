"""Sharp edges and corners of shapes where they are plain to see."""

import numpy as np
import pytest

from parts.catalogue import PARTS
from parts.features import shape_features
from parts.modelling import box, cone, cut, cylinder, fillet


def counts(features):
    kinds = [*features.kinds, *features.corner_kinds]
    return {kind: kinds.count(kind) for kind in sorted(set(kinds))}


def lengths(features):
    return [np.linalg.norm(np.diff(line, axis=0), axis=1).sum() for line in features.polylines]


def test_a_box_has_12_edges_and_8_corners():
    features = shape_features(box((3, 4, 5)), 7.0)
    assert counts(features) == {"corner": 8, "sharp": 12}
    assert sum(lengths(features)) == pytest.approx(4 * (3 + 4 + 5))
    corners = {tuple(corner) for corner in np.round(features.corners, 9)}
    assert corners == {(x, y, z) for x in (0, 3) for y in (0, 4) for z in (0, 5)}


def test_a_seam_is_no_edge_and_a_circle_has_no_corner():
    features = shape_features(cylinder(2, 5), 6.0)
    assert counts(features) == {"sharp": 2}
    assert sum(lengths(features)) == pytest.approx(2 * 2 * np.pi * 2, rel=1e-4)


def test_a_cone_has_an_apex():
    features = shape_features(cone(2, 0, 5), 6.0)
    assert counts(features) == {"apex": 1, "sharp": 1}
    assert len(features.scored_corners()) == 0


def test_tangent_edges_are_not_sharp():
    rounded = fillet(box((30, 20, 10)), 3.0, lambda m: bool(0.1 < m[2] < 9.9))
    features = shape_features(rounded, 37.0)
    assert counts(features) == {"sharp": 16}
    assert sum(lengths(features)) == pytest.approx(2 * (2 * 24 + 2 * 14 + 2 * np.pi * 3), rel=1e-4)


def test_an_edge_inside_is_found_like_one_outside():
    features = shape_features(cut(box((9, 9, 9)), box((3, 3, 9), (3, 3, 4))), 15.0)
    assert counts(features) == {"corner": 16, "sharp": 24}


def test_a_fading_crease_ends_where_it_falls_to_ten_degrees():
    features = shape_features(PARTS["fading-crease"](), 99.0)
    [end] = [k for k, kind in enumerate(features.corner_kinds) if kind == "end"]
    # Slope 0.6 ((56 - x) / 56)^2 beside a level roof, along y = 20, z = 30.
    x = 56 - 56 * np.sqrt(np.tan(np.radians(10)) / 0.6)
    np.testing.assert_allclose(features.corners[end], [x, 20, 30], atol=0.1)


def test_borders_of_a_sheet_are_not_sharp_edges():
    features = shape_features(PARTS["bent-sheet"](), 103.0)
    found = counts(features)
    assert found["boundary"] == 12
    assert found["sharp"] == 2
    assert len(features.sharp(1.0)) == 2 * 51


def test_points_along_edges_are_as_near_as_asked_and_reach_the_ends():
    points = shape_features(box((3, 4, 5)), 7.0).sharp(0.3)
    along_x = points[(points[:, 1] == 0) & (points[:, 2] == 0)][:, 0]
    assert {along_x.min(), along_x.max()} == {0.0, 3.0}
    assert np.diff(np.unique(np.round(along_x, 9))).max() <= 0.3 + 1e-9
