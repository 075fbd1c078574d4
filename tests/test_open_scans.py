"""Scans that are not closed, and several bodies, from points to a checked shape."""

import numpy as np
import pytest

import crispline
from crispline.errors import ReconstructionError
from crispline.options import Options

CREASE_DEG = 60.0


@pytest.fixture(scope="module")
def sheet():
    """A sheet of 30 x 25 with a crease across its middle, and its spacing."""
    rng = np.random.default_rng(0)
    spacing = 0.8
    n = int(30.0 * 25.0 / spacing**2)
    x, y = rng.uniform(-15.0, 15.0, n), rng.uniform(0.0, 25.0, n)
    bend = np.radians(CREASE_DEG)
    down = np.maximum(x, 0.0)
    points = np.column_stack([np.minimum(x, 0.0) + down * np.cos(bend), y, -down * np.sin(bend)])
    return points + 0.1 * spacing * rng.normal(size=points.shape), spacing


@pytest.fixture(scope="module")
def shell(sheet):
    return crispline.reconstruct(sheet[0], Options(model="trimmed"))


def test_a_creased_sheet_is_a_valid_open_shell(shell):
    assert shell.valid
    assert not shell.closed
    assert [face.kind for face in shell.faces] == ["plane", "plane"]
    assert shell.summary()["closed"] is False
    assert any(text.startswith("open shell: ") for text in shell.warnings)


def test_its_edges_are_a_crease_and_a_rim(shell, sheet):
    _, spacing = sheet
    crease = [edge for edge in shell.edges if edge.is_sharp]
    rims = [edge for edge in shell.edges if -1 in edge.faces]
    assert len(crease) == 1
    # Six sides; where the points thin out at a corner of the sheet, the rim may be bevelled.
    assert 6 <= len(rims) <= 8
    assert len(shell.edges) == len(rims) + 1
    assert crease[0].angle_deg == pytest.approx(CREASE_DEG, abs=2.0)
    assert np.abs(crease[0].points[:, [0, 2]]).max() < 0.3 * spacing
    for rim in rims:
        x, y = rim.points[:, 0], rim.points[:, 1]
        far = 15.0 * np.cos(np.radians(CREASE_DEG))
        away = np.min([np.abs(x + 15.0), np.abs(x - far), np.abs(y), np.abs(y - 25.0)], axis=0)
        assert away.max() < 1.5 * spacing
    assert sum(rim.kind == "line" for rim in rims) >= 4


def test_an_open_shell_is_written_and_read(shell, tmp_path):
    path = tmp_path / "shell.step"
    shell.write(path)
    text = path.read_text()
    assert "OPEN_SHELL" in text
    assert "MANIFOLD_SOLID_BREP" not in text


def test_two_boxes_are_two_solids():
    rng = np.random.default_rng(1)
    points = []
    for offset in (0.0, 20.0):
        side = rng.integers(0, 6, 1500)
        box = rng.uniform(0.0, 10.0, (1500, 3))
        box[np.arange(1500), side // 2] = 10.0 * (side % 2)
        points.append(box + np.array([offset, 0.0, 0.0]))
    cloud = np.concatenate(points)
    result = crispline.reconstruct(cloud, Options(model="trimmed"))
    assert result.valid
    assert result.closed
    assert result.solid.check.n_solids == 2
    assert len(result.faces) == 12
    assert result.solid.check.volume == pytest.approx(2000.0, rel=0.02)


def test_a_net_that_thin_walls_tear_is_refused_before_anything_is_fitted(monkeypatch):
    rng = np.random.default_rng(2)
    points = rng.uniform(0.0, 30.0, (1800, 3))
    points[:, 2] = 0.8 * (np.arange(1800) % 2)
    points += 0.16 * rng.normal(size=points.shape)
    monkeypatch.setattr("crispline.net.halfedge.HalfEdges.tears", lambda _: 30)
    monkeypatch.setattr("crispline.features.segment", lambda *_: pytest.fail("went on"))
    with pytest.raises(ReconstructionError, match=r"torn at 30 places: .* under 2 spacings"):
        crispline.reconstruct(points)


def test_ripples_that_neighbours_share_are_no_faces():
    rng = np.random.default_rng(3)
    n, spacing, bend = 4687, 0.4, np.radians(CREASE_DEG)
    x, y = rng.uniform(-15.0, 15.0, n), rng.uniform(0.0, 25.0, n)
    waves = rng.normal(size=(40, 2)) * 0.35 / spacing
    phase = rng.uniform(0.0, 2.0 * np.pi, 40)
    ripple = np.cos(np.column_stack([x, y]) @ waves.T + phase).sum(axis=1)
    off = spacing * (0.1 * rng.normal(size=n) + 0.2 * ripple / ripple.std())
    down = np.maximum(x, 0.0)
    points = np.column_stack([np.minimum(x, 0.0) + down * np.cos(bend), y, -down * np.sin(bend)])
    lean = np.where(x > 0.0, bend, 0.0)
    points += off[:, None] * np.column_stack([np.sin(lean), np.zeros(n), np.cos(lean)])
    result = crispline.reconstruct(points)
    assert result.valid
    assert result.representation == "trimmed"
    # Without it there are dozens, cones and tori among them; a ripple may still be one.
    assert {face.kind for face in result.faces} == {"plane"}
    assert len(result.faces) <= 3
    assert result.noise == pytest.approx(np.hypot(0.1, 0.2) * spacing, rel=0.2)
