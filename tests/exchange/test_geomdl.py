"""Objects and JSON files of geomdl, made and read by geomdl itself."""

import json

import numpy as np
import pytest
from geomdl import NURBS, BSpline, exchange

from crispline.errors import InputError
from crispline.exchange.geomdl import from_geomdl, read_json, to_geomdl, write_json


def geomdl_surface(is_rational, degree_u=3, degree_v=2):
    rng = np.random.default_rng(4)
    surface = (NURBS if is_rational else BSpline).Surface(normalize_kv=False)
    surface.degree_u, surface.degree_v = degree_u, degree_v
    surface.set_ctrlpts(rng.uniform(1.0, 2.0, (30, 4 if is_rational else 3)).tolist(), 6, 5)
    surface.knotvector_u = [0, 0, 0, 0, 1.5, 2, 4, 4, 4, 4][: 7 + degree_u]
    surface.knotvector_v = [-1, -1, -1, 0, 2, 3, 3, 3]
    return surface


@pytest.mark.parametrize("is_rational", [False, True])
def test_values_and_derivatives_are_those_of_geomdl(is_rational):
    surface = geomdl_surface(is_rational)
    spline = from_geomdl(surface)
    rng = np.random.default_rng(5)
    u, v = rng.uniform(0, 4, 20), rng.uniform(-1, 3, 20)
    expected = [surface.derivatives(u=a, v=b, order=2) for a, b in zip(u, v, strict=True)]
    for du, dv in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)):
        reference = [skl[du][dv] for skl in expected]
        np.testing.assert_allclose(spline.evaluate(u, v, du, dv), reference, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["creased", "rational"])
def test_objects_go_there_and_back(name, request, assert_same):
    spline = request.getfixturevalue(name)
    surface = to_geomdl(spline)
    assert surface.rational is (name == "rational")
    assert_same(from_geomdl(surface), spline, 1e-15)
    (u0, u1), (v0, v1) = spline.domain
    u, v = np.linspace(u0, u1, 7)[1:-1], np.linspace(v0, v1, 7)[1:-1]
    points = surface.evaluate_list(list(zip(u.tolist(), v.tolist(), strict=True)))
    np.testing.assert_allclose(spline.evaluate(u, v), points, atol=1e-12)


@pytest.mark.parametrize("is_rational", [False, True])
def test_what_geomdl_writes_is_read(tmp_path, is_rational, assert_same):
    surface = geomdl_surface(is_rational)
    path = tmp_path / "a.json"
    exchange.export_json(surface, str(path))
    (found,), n_trimmed = read_json(path)
    assert n_trimmed == 0
    assert_same(found, from_geomdl(surface))


@pytest.mark.parametrize("name", ["creased", "rational"])
def test_geomdl_reads_what_is_written(tmp_path, name, request):
    spline = request.getfixturevalue(name)
    path = tmp_path / "a.json"
    write_json(path, [spline, spline])
    surfaces = exchange.import_json(str(path))
    assert len(surfaces) == 2
    found = from_geomdl(surfaces[0])  # over knots from 0 to 1
    np.testing.assert_allclose(found.control_points, spline.control_points, rtol=1e-14, atol=1e-14)
    (u0, u1), (v0, v1) = found.domain
    s, t = np.linspace(0.0, 1.0, 9), np.linspace(1.0, 0.0, 9)
    (a0, a1), (b0, b1) = spline.domain
    np.testing.assert_allclose(
        found.evaluate(u0 + s * (u1 - u0), v0 + t * (v1 - v0)),
        spline.evaluate(a0 + s * (a1 - a0), b0 + t * (b1 - b0)),
        atol=1e-12,
    )


def test_files_keep_every_digit(tmp_path, creased, rational, assert_same):
    path = tmp_path / "a.json"
    write_json(path, [creased, rational])
    found, _ = read_json(path)
    assert_same(found[0], creased)
    assert_same(found[1], rational)


def test_trims_are_counted(tmp_path):
    surface, trim = geomdl_surface(False), BSpline.Curve()
    trim.degree = 1
    trim.ctrlpts = [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.2]]
    trim.knotvector = [0, 0, 1, 2, 3, 3]
    surface.trims = [trim]
    exchange.export_json(surface, str(tmp_path / "a.json"))
    assert read_json(tmp_path / "a.json")[1] == 1


def test_an_unfinished_surface_has_no_control_points():
    surface = BSpline.Surface()
    with pytest.raises(InputError, match="the geomdl surface: expected control points, found none"):
        from_geomdl(surface)


def test_other_objects_are_refused():
    with pytest.raises(InputError, match="expected a surface of geomdl, found Curve"):
        from_geomdl(BSpline.Curve())


def record(**changes):
    fields = {
        "degree_u": 1,
        "degree_v": 1,
        "knotvector_u": [0, 0, 1, 1],
        "knotvector_v": [0, 0, 1, 1],
        "size_u": 2,
        "size_v": 2,
        "control_points": {"points": [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0]]},
    }
    return {**fields, **changes}


def file_with(*data, kind="surface"):
    return json.dumps({"shape": {"type": kind, "count": len(data), "data": data}})


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("{", "content that cannot be read as such"),
        ("[1, 2]", "content that cannot be read as such"),
        ('{"surface": 1}', r"content that cannot be read as such \('shape'\)"),
        (file_with({}, kind="curve"), "found 1 of type 'curve'"),
        (file_with(), "found 0 of type 'surface'"),
        (file_with({"degree_u": 3}), "surface 1: .* found a record without them"),
        (file_with(3), "surface 1: .* found a record without them"),
        (file_with(record(), record(size_u=3)), r"surface 2: .* 3 x 2 = 6 control points, found 4"),
        (file_with(record(size_u=0, control_points={"points": []})), "control points, found none"),
        (
            file_with(record(control_points={"points": [[0, 0, 0]] * 4, "weights": [1, 2]})),
            "one weight for each of 4 control points, found 2",
        ),
        (
            file_with(record(control_points={"points": [[0, 0]] * 4})),
            r"\(n_u, n_v, 3\), found shape \(2, 2, 2\)",
        ),
        (file_with(record(degree_u="3")), "degree_u"),
        (file_with(record(knotvector_v=[0, 0, 1])), r"expected 4 knots_v"),
    ],
)
def test_other_files_are_refused(tmp_path, text, sentence):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(InputError, match=rf"a\.json'.*{sentence}"):
        read_json(path)
