"""``reconstruct --report`` and ``view``."""

import sys
import webbrowser
from types import ModuleType

import numpy as np
import pytest
from click.testing import CliRunner

import crispline
from crispline import cli
from crispline.errors import ReconstructionError


@pytest.fixture
def run(monkeypatch, tmp_path, points):
    """The command on the cube's cloud with a pipeline that gives what it is told to."""
    cloud = tmp_path / "cube.npy"
    np.save(cloud, points)

    def run(outcome):
        def reconstruct(cloud, options, progress):
            if isinstance(outcome, BaseException):
                raise outcome
            return outcome

        fake = ModuleType("crispline.pipeline")
        fake.reconstruct = reconstruct
        monkeypatch.setitem(sys.modules, "crispline.pipeline", fake)
        monkeypatch.setattr(crispline, "pipeline", fake, raising=False)
        arguments = ["reconstruct", cloud, "-o", tmp_path / "cube.step", "--report"]
        page = tmp_path / "cube.html"
        done = CliRunner().invoke(cli.main, [*map(str, arguments), str(page)])
        return done, page

    return run


def test_the_page_has_the_name_of_the_cloud_and_its_options(run, cube):
    done, page = run(cube)
    assert done.exit_code == 0, done.output
    text = page.read_text()
    assert "<h1>cube.npy</h1>" in text
    assert "net.edge_lengths" in text


def test_a_failed_run_leaves_a_page_that_says_why(run, unbuilt):
    done, page = run(ReconstructionError("the net is open near (1, 2, 3)", unbuilt))
    assert done.exit_code == 3
    assert "the net is open near (1, 2, 3)" in page.read_text()


def test_a_run_that_found_nothing_leaves_none(run):
    done, page = run(ReconstructionError("no surface at all"))
    assert done.exit_code == 3
    assert not page.exists()


def test_view_opens_the_page(report, monkeypatch):
    opened = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    assert CliRunner().invoke(cli.main, ["view", str(report)]).exit_code == 0
    assert opened == [report.resolve().as_uri()]


def test_view_without_a_browser_names_the_address(report, monkeypatch):
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    done = CliRunner().invoke(cli.main, ["view", str(report)])
    assert done.exit_code == 2
    assert f"open this address in one: {report.resolve().as_uri()}" in done.stderr


def test_view_refuses_what_is_no_report(tmp_path):
    (tmp_path / "a.html").write_text("<!DOCTYPE html><p>hello")
    for name, words in (("a.html", "got another file"), ("b.html", "No such file")):
        done = CliRunner().invoke(cli.main, ["view", str(tmp_path / name)])
        assert done.exit_code == 2
        assert words in done.stderr
