"""``crispline paper`` with tiny settings."""

import json

import pytest
from click.testing import CliRunner

from crispline import cli
from crispline.paper import grids
from crispline.paper.windows import windows


def run(*arguments):
    return CliRunner().invoke(cli.main, ["paper", *map(str, arguments)])


def test_both_files_are_written(tmp_path, monkeypatch):
    monkeypatch.setattr(grids, "windows", lambda feature, phase: windows(feature, phase)[:1])
    table, text = tmp_path / "T.json", tmp_path / "T.md"
    outcome = run(
        *("--json", table, "--markdown", text, "--methods", "published,robust"),
        *("--noise", "2%", "--phases", "0.25", "--seeds", 1, "--jobs", 1),
    )
    assert outcome.exit_code == 0, outcome.output
    assert "grids at 2 % noise" in outcome.stderr
    rows = json.loads(table.read_text())
    found = [(row["method"], row["noise"], row["feature"], row["sampling"]) for row in rows]
    features = ("straight", "lower circle", "upper circle", "corner")
    assert found == [
        (method, 0.02, feature, sampling)
        for method, sampling in (("published", "not stated"), ("robust", "grid 0.25"))
        for feature in features
    ]
    for row in rows:
        assert row["final"] < row["initial"]
    assert "| 2 % | 34 dB | corner | 0.2468" in text.read_text()


def test_the_tables_go_to_the_terminal_without_a_file():
    outcome = run("--methods", "published", "--noise", "0.5%")
    assert outcome.exit_code == 0
    assert "| 0.5 % | 46 dB | straight | 0.0444" in outcome.stdout


def test_processes_do_not_change_the_rows(tmp_path):
    settings = ("--methods", "paper", "--noise", "1%", "--phases", "0.5", "--seeds", 1)
    for jobs in (1, 2):
        outcome = run(*settings, "--jobs", jobs, "--json", tmp_path / f"{jobs}.json")
        assert outcome.exit_code == 0, outcome.output
    assert (tmp_path / "1.json").read_text() == (tmp_path / "2.json").read_text()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--methods", "magic"), "method: expected one of published, paper, robust, pipeline"),
        (("--noise", "a,b"), "expected fractions separated by commas"),
        (("--noise", "-1"), "noise level: expected a fraction of 0 or more"),
        (("--noise", "nan"), "noise level: expected a fraction of 0 or more"),
        (("--phases", "0.7"), "phase: expected a position of 0 to 0.5"),
        (("--phases", ""), "expected numbers from 0 to 0.5 separated by commas"),
        (("--seeds", "0"), "--seeds"),
        (("--json", "table.txt"), "expected a name that ends in .json"),
        (("--markdown", "missing/table.md"), "the folder 'missing' does not exist"),
    ],
)
def test_bad_usage_is_one_sentence(arguments, message):
    outcome = run(*arguments)
    assert outcome.exit_code == 2
    assert message in outcome.stderr
    assert "Traceback" not in outcome.output
