"""Points that lie apart from the net: small pieces, and what is no small piece."""

import numpy as np
import pytest

from crispline.net.strays import stray_pieces, strays_sentence


def square(side, place, seed=0):
    rng = np.random.default_rng(seed)
    flat = rng.uniform(0.0, side, (int(side**2), 2))
    return np.column_stack([flat, 0.05 * rng.normal(size=len(flat))]) + place


@pytest.fixture
def scene():
    """A sheet with its net, a piece of 49 and one of 16 points beside it, and one of 400."""
    x, y = np.meshgrid(np.arange(31.0), np.arange(31.0))
    vertices = np.column_stack([x.ravel(), y.ravel(), 0.0 * x.ravel()])
    parts = [
        square(30.0, [0.0, 0.0, 0.0]),
        square(7.0, [0.0, 0.0, 8.0]),
        square(4.0, [40.0, 0.0, 0.0]),
        square(20.0, [0.0, 0.0, 20.0]),
    ]
    part = np.repeat(np.arange(4), [len(points) for points in parts])
    return np.concatenate(parts), vertices, part


def test_small_pieces_are_told_from_the_net_and_from_what_it_lacks(scene):
    points, vertices, part = scene
    piece = stray_pieces(points, vertices, 100)
    assert (piece[np.isin(part, [0, 3])] == -1).all()
    assert sorted(piece[part == 1]) == [piece[part == 1][0]] * 49
    assert sorted(piece[part == 2]) == [piece[part == 2][0]] * 16
    assert set(piece.tolist()) == {-1, 0, 1}


def test_a_large_piece_counts_as_small_if_the_least_size_is_larger(scene):
    points, vertices, part = scene
    assert (stray_pieces(points, vertices, 500)[part == 3] >= 0).all()


def test_the_user_is_told_how_many_and_where(scene):
    points, vertices, _ = scene
    sentence = strays_sentence(points, stray_pieces(points, vertices, 100))
    assert "65 points on 2 small pieces" in sentence
    assert "has 49 points" in sentence


def test_nothing_is_said_of_a_net_that_covers_its_points(scene):
    points, vertices, part = scene
    covered = points[part == 0]
    piece = stray_pieces(covered, vertices, 100)
    assert (piece == -1).all()
    assert strays_sentence(covered, piece) == ""
