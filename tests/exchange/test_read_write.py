"""Files by their suffix: there and back, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.exchange import read_surface_file, read_surfaces, to_geomdl, write_surfaces
from crispline.exchange.read import READ_SUFFIXES
from crispline.exchange.write import WRITE_SUFFIXES
from crispline.spline.tensor import TensorSpline, spline_over_grid

BOTH = sorted({*READ_SUFFIXES} & {*WRITE_SUFFIXES})
KEEPS_KNOTS = (".json", ".npz")


@pytest.mark.parametrize("suffix", [*BOTH, ".STEP", ".Json"])
@pytest.mark.parametrize("name", ["creased", "rational"])
def test_every_format_goes_there_and_back(tmp_path, suffix, name, request, assert_same):
    spline = request.getfixturevalue(name)
    path = tmp_path / f"a{suffix}"
    write_surfaces(path, spline)
    (found,) = read_surfaces(path)
    if suffix.lower() in KEEPS_KNOTS:
        assert_same(found, spline)
    else:
        assert_same(found, spline.clamped(), 1e-12)


@pytest.mark.parametrize("suffix", WRITE_SUFFIXES)
def test_several_surfaces_go_into_one_file(tmp_path, suffix, creased, rational):
    moved = replace(rational, control_points=rational.control_points + np.array([0.0, 0.0, 20.0]))
    path = tmp_path / f"a{suffix}"
    write_surfaces(path, [creased, moved])
    if suffix in READ_SUFFIXES:
        found = read_surfaces(path)
        assert [s.weights is None for s in found] == [True, False]
    else:
        import trimesh

        mesh = trimesh.load_mesh(path, process=False)
        assert mesh.body_count == 2


def test_lower_degrees_are_elevated(tmp_path):
    net = np.random.default_rng(0).normal(size=(3, 2, 3))
    flat = TensorSpline(2, 1, np.repeat([0.0, 1.0], 3), np.repeat([0.0, 1.0], 2), net)
    u, v = np.random.default_rng(1).uniform(size=(2, 20))
    for suffix in BOTH:
        write_surfaces(tmp_path / f"a{suffix}", flat)
        (found,) = read_surfaces(tmp_path / f"a{suffix}")
        assert (found.degree_u, found.degree_v) == (3, 3)
        np.testing.assert_allclose(found.evaluate(u, v), flat.evaluate(u, v), atol=1e-12)


@pytest.mark.parametrize("suffix", BOTH)
def test_higher_degrees_are_refused(tmp_path, suffix):
    net = np.random.default_rng(0).normal(size=(5, 4, 3))
    steep = TensorSpline(4, 3, np.repeat([0.0, 1.0], 5), np.repeat([0.0, 1.0], 4), net)
    write_surfaces(tmp_path / f"a{suffix}", steep)
    with pytest.raises(InputError, match="surface 1: expected degrees 1 to 3, found 4 and 3; "):
        read_surfaces(tmp_path / f"a{suffix}")


def test_grids_are_arrays(tmp_path):
    points = np.random.default_rng(0).normal(size=(5, 6, 3))
    np.save(tmp_path / "a.npy", points)
    (found,) = read_surfaces(str(tmp_path / "a.npy"))
    np.testing.assert_array_equal(found, points)


def test_a_file_tells_its_unit_if_it_has_one(tmp_path, creased, assert_same):
    for suffix in BOTH:
        write_surfaces(tmp_path / f"a{suffix}", creased, unit="in")
        found = read_surface_file(tmp_path / f"a{suffix}")
        assert found.unit == (None if suffix in KEEPS_KNOTS else "in")
        np.testing.assert_allclose(
            found.surfaces[0].evaluate([3.0], [2.0]), creased.evaluate([3.0], [2.0]), rtol=1e-13
        )


def test_triangles_have_the_pieces_asked_for(tmp_path, creased):
    write_surfaces(tmp_path / "a.ply", creased, per_span=1)
    assert b"element vertex 72\n" in (tmp_path / "a.ply").read_bytes()


def test_a_hole_cannot_be_written(tmp_path):
    points = np.random.default_rng(0).normal(size=(8, 8, 3))
    points[4, 4] = np.nan
    for suffix in WRITE_SUFFIXES:
        with pytest.raises(InputError, match="finite control points, surface 1 has 1 that are not"):
            write_surfaces(tmp_path / f"a{suffix}", spline_over_grid(points))
    assert list(tmp_path.iterdir()) == []


def test_nothing_cannot_be_written(tmp_path):
    with pytest.raises(InputError, match="expected at least one surface, got none"):
        write_surfaces(tmp_path / "a.step", [])


def test_unknown_suffixes_are_refused(tmp_path, creased):
    with pytest.raises(InputError, match=r"cannot write .* ends in \.step or \.stp .* got '\.3dm'"):
        write_surfaces(tmp_path / "a.3dm", creased)
    (tmp_path / "a.3dm").write_text("x")
    with pytest.raises(InputError, match=r"ends in one of \.step, \.stp, .* found '\.3dm'"):
        read_surfaces(tmp_path / "a.3dm")


@pytest.mark.parametrize("suffix", READ_SUFFIXES)
def test_missing_empty_and_folder_are_refused(tmp_path, suffix):
    path = tmp_path / f"a{suffix}"
    with pytest.raises(InputError, match="no such file"):
        read_surfaces(path)
    path.write_bytes(b"")
    with pytest.raises(InputError, match="expected a surface, found an empty file"):
        read_surfaces(path)
    path.unlink()
    path.mkdir()
    with pytest.raises(InputError, match="expected a file, found a folder"):
        read_surfaces(path)


def test_a_surface_of_geomdl_sharpened_elsewhere_stays_as_it_is(tmp_path, creased):
    from geomdl import exchange

    surface = to_geomdl(creased)
    exchange.export_json(surface, str(tmp_path / "a.json"))
    (found,) = read_surfaces(tmp_path / "a.json")
    write_surfaces(tmp_path / "a.step", found)
    (again,) = read_surfaces(tmp_path / "a.step")
    u, v = np.linspace(0.0, 8.0, 33), np.linspace(7.0, 0.0, 33)
    np.testing.assert_allclose(again.evaluate(u, v), creased.evaluate(u, v), atol=1e-12)
