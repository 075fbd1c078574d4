"""The pages of docs/: their commands and Python run, their links lead somewhere, they build.

Every command is checked to be good usage; those of the tutorial are run word for word, on a
smaller cloud. Python blocks are run one page after the other; `reconstruct` then gives one
result that was really made, whatever cloud a page names, and no window is opened.
"""

import os
import re
import shlex
import subprocess
import sys
import webbrowser
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import crispline
from crispline import cli, shapes
from crispline.cloud.write import write_points
from crispline.configuration import to_toml
from crispline.result import Reconstruction

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md"))
TEXTS = {page: (DOCS / page).read_text(encoding="utf-8") for page in PAGES}
TEXTS["README"] = (ROOT / "README.md").read_text(encoding="utf-8")
_BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```", re.MULTILINE | re.DOTALL)
_LINK = re.compile(r"\]\(([^)\s]+)\)")


def blocks(page, language):
    return [text for kind, text in _BLOCK.findall(TEXTS[page]) if kind == language]


def commands(page):
    """The commands of crispline in the shell blocks, without comments and redirections."""
    lines = "\n".join(blocks(page, "sh")).replace("\\\n", " ").splitlines()
    words = [shlex.split(line.split(" > ")[0], comments=True) for line in lines]
    return [one[1:] for one in words if one and one[0] == "crispline"]


def having(find):
    return [page for page in TEXTS if find(page)]


@pytest.mark.parametrize("page", having(commands))
def test_commands_are_good_usage(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    for words in commands(page):
        if words[0].startswith("-"):
            assert CliRunner().invoke(cli.main, words).exit_code == 0
            continue
        context = cli.main.make_context("crispline", list(words))
        cli.main.commands[words[0]].make_context(words[0], words[1:], parent=context)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder like the repository's, with a smaller scan of the same part."""
    folder = tmp_path_factory.mktemp("tutorial")
    (folder / "examples").mkdir()
    scan = shapes.sample(shapes.SHAPES["bracket"](), 5000, noise=0.01, outliers=0.005, seed=1)
    write_points(folder / "examples" / "bracket.ply", scan.points)
    return folder


def test_the_tutorial_runs_word_for_word(folder, monkeypatch):
    monkeypatch.chdir(folder)
    monkeypatch.setattr(webbrowser, "open", lambda address: True)
    assert "mkdir out\n" in "".join(blocks("tutorial.md", "sh"))
    (folder / "out").mkdir()
    steps = commands("tutorial.md")
    assert {words[0] for words in steps} >= {"inspect", "reconstruct", "view", "compare", "detect"}
    outcomes = {words[0]: CliRunner().invoke(cli.main, words) for words in steps}
    for name, outcome in outcomes.items():
        assert outcome.exit_code == 0, f"{name}: {outcome.output}"
    assert "one solid\nof 11 faces" in TEXTS["tutorial.md"]
    text = (folder / "out" / "bracket.step").read_text()
    assert (text.count("ADVANCED_FACE"), text.count("MANIFOLD_SOLID_BREP(")) == (11, 1)
    names = {path.name for path in (folder / "out").iterdir()}
    assert names == {"bracket.step", "bracket.html", "bracket.stl", "edges.json"}


@pytest.fixture(scope="module")
def made():
    """A scan and the one result that the pages share."""
    scan = shapes.sample(shapes.SHAPES["box-cylinder"](), 5000, noise=0.01, seed=1)
    return scan, crispline.reconstruct(scan.points)


@pytest.fixture
def workplace(made, tmp_path, monkeypatch):
    """The files and names that pages speak of."""
    scan, part = made
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(crispline, "reconstruct", lambda *given, **more: part, raising=False)
    monkeypatch.setattr(Reconstruction, "show", lambda self, *given, **more: None)
    for name in ("out", "examples"):
        (tmp_path / name).mkdir()
    for name in ("scan.ply", "examples/bracket.ply"):
        write_points(tmp_path / name, scan.points)
    (tmp_path / "run.toml").write_text(to_toml())
    steps = np.linspace(-1.0, 1.0, 33)
    u, v = np.meshgrid(steps, steps, indexing="ij")
    grid = np.stack([u, v, np.abs(u)], axis=-1)
    np.save(tmp_path / "image.npy", grid)
    return scan.points, grid, part


@pytest.mark.parametrize("page", having(lambda page: blocks(page, "python")))
def test_python_runs(page, workplace):
    cloud, grid, part = workplace
    points = grid if page == "sharpen.md" else cloud
    names = {"crispline": crispline, "points": points, "part": part}
    for text in blocks(page, "python"):
        if "crispline[view]" in text:
            pytest.importorskip("pyvista")
        exec(compile(text, page, "exec"), names)


def test_options_of_the_tuning_page_are_those_of_the_code():
    from crispline.configuration import read_text, settings

    page = TEXTS["howto/tuning.md"]
    (table,) = re.findall(r"^```toml\n(.*?)^```", page, re.MULTILINE | re.DOTALL)
    assert read_text(table).options.net.fill_holes == 10.0
    names = {(one.table, one.key) for one in settings()}
    named = re.findall(r"`(\w+)`(?: and `(\w+)`)? under `\[(\w+)\]`", page)
    assert named
    assert {(table, key) for *keys, table in named for key in keys if key} <= names


@pytest.mark.parametrize("page", list(TEXTS))
def test_links_lead_somewhere(page):
    base = ROOT if page == "README" else (DOCS / page).parent
    for link in _LINK.findall(TEXTS[page]):
        if not link.startswith(("http://", "https://", "#")):
            assert (base / link.partition("#")[0]).exists(), link


def test_every_page_is_in_the_contents():
    listed = set(re.findall(r"^([\w/-]+)$", TEXTS["index.md"], re.MULTILINE))
    assert {page.removesuffix(".md") for page in PAGES} - {"index"} <= listed


def test_the_site_builds_without_a_warning_and_needs_no_network(tmp_path):
    command = [sys.executable, "-m", "sphinx", "-W", "--keep-going", "-q", "-d", "doctrees"]
    done = subprocess.run(
        [*command, str(DOCS), "site"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    site = tmp_path / "site"
    assert "<code" in (site / "options.html").read_text()
    assert "fill_holes" in (site / "options.html").read_text()
    assert "Usage: crispline reconstruct" in (site / "commands.html").read_text()
    for path in site.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"<(script|img|iframe)[^>]+src=\"(https?:)?//", text), path
        assert not re.search(r"<link[^>]+href=\"(https?:)?//", text), path
    for path in site.rglob("*.css"):
        assert not re.search(r"url\(\"?(https?:)?//|@import", path.read_text()), path
