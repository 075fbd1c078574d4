"""Surfaces as NumPy archives."""

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.exchange.npz import read_npz, write_npz


def test_surfaces_go_there_and_back(tmp_path, creased, rational, assert_same):
    path = tmp_path / "a.npz"
    write_npz(path, [creased, rational, creased])
    found = read_npz(path)
    for one, other in zip(found, [creased, rational, creased], strict=True):
        assert_same(one, other)


def test_the_fields_are_those_of_the_surface(tmp_path, rational):
    write_npz(tmp_path / "a.npz", [rational])
    with np.load(tmp_path / "a.npz") as archive:
        names = ["degree_u", "degree_v", "knots_u", "knots_v", "control_points", "weights"]
        assert archive.files == names
        np.testing.assert_array_equal(archive["weights"], rational.weights)


def test_equal_surfaces_give_equal_bytes(tmp_path, creased):
    for name in ("a.npz", "b.npz"):
        write_npz(tmp_path / name, [creased])
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()


def fields(**changes):
    knots = np.array([0.0, 0.0, 1.0, 1.0])
    given = {
        "degree_u": 1,
        "degree_v": 1,
        "knots_u": knots,
        "knots_v": knots,
        "control_points": np.ones((2, 2, 3)),
    }
    return {name: value for name, value in {**given, **changes}.items() if value is not None}


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"knots_u": None, "degree_v": None}, "found no degree_v and no knots_u"),
        ({"control_points_2": np.ones((2, 2, 3))}, "surface 2: .* found no degree_u_2"),
        ({"degree_u": 1.5}, "a whole number for each degree, found 1.5 and 1"),
        ({"degree_u": [1, 2]}, "a whole number for each degree"),
        ({"weights": np.ones((3, 2))}, "one weight for each control point"),
        ({"knots_v": np.array([0.0, 1.0, 0.0, 1.0])}, "found 1 followed by 0 at place 2"),
    ],
)
def test_other_archives_are_refused(tmp_path, changes, sentence):
    np.savez(tmp_path / "a.npz", **fields(**changes))
    with pytest.raises(InputError, match=rf"a\.npz'.*{sentence}"):
        read_npz(tmp_path / "a.npz")


@pytest.mark.parametrize("content", [b"points", b"PK\x03\x04 cut off"])
def test_other_content_is_refused(tmp_path, content):
    (tmp_path / "a.npz").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.npz': expected an NPZ archive, found content"):
        read_npz(tmp_path / "a.npz")


def test_a_lone_array_is_refused(tmp_path):
    with (tmp_path / "a.npz").open("wb") as file:
        np.save(file, np.ones((4, 4, 3)))
    with pytest.raises(InputError, match=r"a\.npz': expected an NPZ archive, .*a single array"):
        read_npz(tmp_path / "a.npz")
