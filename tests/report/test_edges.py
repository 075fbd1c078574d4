import json
from types import SimpleNamespace

import numpy as np
import pytest

from crispline.errors import InputError
from crispline.report.edges import write_edges

TURN = np.linspace(0.0, 2.0 * np.pi, 9)[:-1]
RING = np.column_stack([5.0 + np.cos(TURN), np.sin(TURN), 0.1 * TURN])
EDGES = [
    SimpleNamespace(points=np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]), angle_deg=90.0),
    SimpleNamespace(points=np.array([[2.0, 0, 0], [2, 1, 0]]), angle_deg=45.0),
    SimpleNamespace(points=np.vstack([RING, RING[:1]]), angle_deg=60.0),
]
CORNERS = np.array([[2.0, 0, 0]])


def test_json(tmp_path):
    write_edges(tmp_path / "e.json", EDGES, CORNERS, spacing=0.5, noise=0.1)
    content = json.loads((tmp_path / "e.json").read_text())
    assert list(content) == ["spacing", "noise", "edges", "corners"]
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


@pytest.mark.parametrize("suffix", [".json", ".obj"])
def test_nothing_found_is_still_a_file(tmp_path, suffix):
    path = tmp_path / f"e{suffix}"
    write_edges(path, [], np.empty((0, 3)), spacing=0.5, noise=0.1)
    assert path.exists()


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"got '\.dxf'"):
        write_edges(tmp_path / "e.dxf", [], CORNERS, spacing=0.5, noise=0.1)
