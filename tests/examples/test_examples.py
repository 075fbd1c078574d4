"""The scripts in examples/, each held against what is exactly known."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "examples"


def script(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_script_is_tested():
    names = {path.stem for path in FOLDER.glob("*.py")}
    assert names == {"noisy_scan", "open_scan", "iga_export", "compare_with_cad"}


def test_noisy_scan(tmp_path, capsys):
    """Edges are located a tenth of a spacing well, in noise of 0.1 spacings and 5 % strays."""
    assert script("noisy_scan").main(tmp_path, n_points=5000) < 0.1
    assert (tmp_path / "noisy.step").exists()
    assert "outliers" in capsys.readouterr().out


def test_open_scan(tmp_path):
    """Without its bottom the box with cylinder has 7 faces and 10 edges, four rims aside."""
    shell = script("open_scan").main(tmp_path, n_points=4000)
    assert (shell.valid, shell.closed, len(shell.faces)) == (True, False, 7)
    assert sum(edge.is_sharp and min(edge.faces) >= 0 for edge in shell.edges) == 10
    assert b"OPEN_SHELL" in (tmp_path / "shell.step").read_bytes()


def test_iga_export(tmp_path):
    """Area and volume of a cube of side 70 with a cylinder of radius 25 and height 29 on it."""
    import json

    area, volume = script("iga_export").main(tmp_path, n_points=4000)
    assert area == pytest.approx(6 * 70**2 + 2 * np.pi * 25 * 29, rel=1e-3)
    assert volume == pytest.approx(70**3 + np.pi * 25**2 * 29, rel=1e-3)
    patches = json.loads((tmp_path / "patches.json").read_text())["shape"]["data"]
    edges = json.loads((tmp_path / "edges.json").read_text())
    assert all(len(edge["sides"]) == 2 for edge in edges)
    used = {side["patch"] for edge in edges for side in edge["sides"]}
    assert used == set(range(len(patches)))


def test_compare_with_cad(tmp_path):
    """Every point was moved by 0.0875 in all; the model may add little to that."""
    found = script("compare_with_cad").main(tmp_path, n_points=4000)
    assert found.is_within
    assert len(found.faces) == 8
    assert found.whole.max < 0.0875 + 0.05
    assert (tmp_path / "compare.html").exists()
