import json
from types import SimpleNamespace

import ezdxf
import numpy as np
import pytest

from crispline.curve import BSplineCurve, Circle, Line
from crispline.errors import InputError
from crispline.exchange.edges import write_edges

X, Y, Z = np.eye(3)
TILT = np.array([2.0, -3.0, 6.0]) / 7.0
ACROSS = np.array([3.0, 2.0, 0.0]) / np.sqrt(13.0)
NET = np.array([[0.0, 0, 0], [1, 2, 0], [3, 2, 1], [4, 0, 0], [5, 5, 5]])


def edge(curve, n_points, angle_deg):
    points = curve.samples(n_points)
    if np.allclose(points[0], points[-1]):
        points[-1] = points[0]
    return SimpleNamespace(curve=curve, points=points, angle_deg=angle_deg)


EDGES = [
    edge(Line(np.zeros(3), X, 0.0, 2.0), 3, 90.0),
    edge(Line(2.0 * X, Y, 0.0, 1.0), 2, 45.0),
    edge(Circle(5.0 * X, Z, X, 1.0, 0.0, 2.0 * np.pi), 9, 60.0),
]
EXACT = [
    *(one.curve for one in EDGES),
    Circle(np.array([1.0, 2, 3]), TILT, ACROSS, 2.5, 0.7, 3.9),
    Circle(np.array([1.0, 2, 3]), -Z, Y, 2.5, -1.0, 1.0),
    Circle(np.array([1.0, 2, 3]), -TILT, ACROSS, 0.5, 1.0, 1.0 + 2.0 * np.pi),
    BSplineCurve(np.array([0.0, 0, 0, 0, 0.4, 1, 1, 1, 1]), NET),
]
CORNERS = np.array([[2.0, 0, 0]])


def test_json(tmp_path):
    write_edges(tmp_path / "e.json", EDGES, CORNERS, spacing=0.5, noise=0.1)
    content = json.loads((tmp_path / "e.json").read_text())
    assert list(content) == ["unit", "spacing", "noise", "edges", "corners"]
    assert (content["spacing"], content["noise"]) == (0.5, 0.1)
    assert [edge["closed"] for edge in content["edges"]] == [False, False, True]
    assert [edge["angle_deg"] for edge in content["edges"]] == [90.0, 45.0, 60.0]
    for written, edge in zip(content["edges"], EDGES, strict=True):
        np.testing.assert_array_equal(written["points"], edge.points)
    assert content["corners"] == CORNERS.tolist()


def test_obj_polylines_share_the_vertices_where_they_meet(tmp_path):
    write_edges(tmp_path / "e.obj", EDGES, CORNERS, spacing=0.5, noise=0.1)
    records = [line.split() for line in (tmp_path / "e.obj").read_text().splitlines()]
    vertices = np.array([record[1:] for record in records if record[0] == "v"], dtype=float)
    lines = [np.array(record[1:], dtype=int) - 1 for record in records if record[0] == "l"]
    assert len(vertices) == 3 + 1 + 8
    for line, edge in zip(lines, EDGES, strict=True):
        np.testing.assert_array_equal(vertices[line], edge.points)
    assert lines[0][-1] == lines[1][0]
    assert lines[2][0] == lines[2][-1]
    assert [record for record in records if record[0] == "p"] == [["p", "3"]]


@pytest.mark.parametrize("suffix", [".dxf", ".json", ".obj"])
def test_nothing_found_is_still_a_file(tmp_path, suffix):
    path = tmp_path / f"e{suffix}"
    write_edges(path, [], np.empty((0, 3)), spacing=0.5, noise=0.1)
    assert path.exists()


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"got '\.svg'"):
        write_edges(tmp_path / "e.svg", [], CORNERS, spacing=0.5, noise=0.1)


def samples_of(entity):
    """201 points along a DXF entity, by the library's own evaluation."""
    match entity.dxftype():
        case "LINE":
            return np.linspace(entity.dxf.start, entity.dxf.end, 201)
        case "CIRCLE":
            return np.array(list(entity.vertices(np.linspace(0.0, 360.0, 201))))
        case "ARC":
            return np.array(list(entity.vertices(entity.angles(201))))
    spline = entity.construction_tool()
    return np.array(list(spline.approximate(200)))


def test_dxf_has_the_exact_curves(tmp_path):
    edges = [edge(curve, 20, 90.0) for curve in EXACT]
    for _ in range(2):
        write_edges(tmp_path / "e.dxf", edges, CORNERS, spacing=0.5, noise=0.1, unit="m")
    document = ezdxf.readfile(tmp_path / "e.dxf")
    assert document.header["$INSUNITS"] == 6
    assert not document.audit().has_errors
    found = list(document.modelspace().query("*[layer=='EDGES']"))
    kinds = ["LINE", "LINE", "CIRCLE", "ARC", "ARC", "CIRCLE", "SPLINE"]
    assert [entity.dxftype() for entity in found] == kinds
    for entity, curve in zip(found, EXACT, strict=True):
        points, expected = samples_of(entity), curve.samples(2001)
        apart = np.linalg.norm(points[:, None] - expected[None], axis=2)
        step = np.linalg.norm(np.diff(expected, axis=0), axis=1).max()
        assert apart.min(axis=1).max() < step
        assert apart.min(axis=0).max() < 20.0 * step
        if entity.dxftype() != "CIRCLE":
            ends = points[[0, -1]]
            np.testing.assert_allclose(ends, expected[[0, -1]], atol=1e-9)
    (point,) = document.modelspace().query("*[layer=='CORNERS']")
    assert tuple(point.dxf.location) == (2.0, 0.0, 0.0)


def test_dxf_has_the_same_bytes(tmp_path):
    contents = []
    for _ in range(2):
        write_edges(tmp_path / "e.dxf", EDGES, CORNERS, spacing=0.5, noise=0.1)
        contents.append((tmp_path / "e.dxf").read_bytes())
    assert contents[0] == contents[1]


@pytest.mark.parametrize("suffix", [".dxf", ".json", ".obj", ".step"])
def test_an_unknown_unit_is_refused(tmp_path, suffix):
    with pytest.raises(InputError, match="expected a length unit"):
        write_edges(tmp_path / f"e{suffix}", EDGES, CORNERS, spacing=1, noise=0, unit="ell")
    assert list(tmp_path.iterdir()) == []


def test_a_missing_package_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ezdxf", None)
    with pytest.raises(InputError, match=r"pip install 'crispline\[dxf\]'"):
        write_edges(tmp_path / "e.dxf", EDGES, CORNERS, spacing=0.5, noise=0.1)
