import io

import pytest
from rich.console import Console

from crispline.report.progress import show_progress
from crispline.report.summary import render_summary

FACE = {"area": 4900.0, "n_points": 4810, "rms": 0.1, "p95": 0.2, "max": 0.35, "mean": 0.001}
SUMMARY = {
    "valid": True,
    "closed": True,
    "spacing": 1.0,
    "noise": 0.1,
    "n_faces": 3,
    "faces": [
        {"kind": "plane", "parameters": {"origin": [0, 0, 35.0], "normal": [1e-9, 0, 1.0]}, **FACE},
        {"kind": "cone", "parameters": {"half_angle_deg": 45.0, "axis": [0, 1.0, 0]}, **FACE},
        {"kind": "bspline", "parameters": {"control_points": [[0, 0, 0]] * 3}, **FACE},
    ],
    "edges": [
        {"kind": "line", "length": 70.0, "angle_deg": 90.0, "is_sharp": True, "faces": [0, 1]},
        {"kind": "line", "length": 9.0, "angle_deg": 0.1, "is_sharp": False, "faces": [0, 2]},
    ],
    "corners": [[35.0, 35.0, 35.0]],
    "timings": {"net": 2.0, "fit": 1.5},
    "warnings": ["12 points were dropped [see --help]"],
}


def shown(summary) -> str:
    console = Console(file=io.StringIO(), width=140)
    console.print(render_summary(summary))
    return console.file.getvalue()


def test_says_everything_a_person_asks_for():
    text = shown(SUMMARY)
    for part in (
        "valid closed solid, 3 faces",
        "spacing 1, noise 0.1 (0.10 spacings)",
        "normal (0 0 1)",
        "half angle 45°",
        "1 sharp edge (1 line; length 70), 1 corner",
        "3.5 s (net 2.0, fit 1.5)",
        "warning: 12 points were dropped [see --help]",
    ):
        assert part in text
    assert "control" not in text


@pytest.mark.parametrize(
    ("change", "verdict"),
    [
        ({"closed": False}, "valid open shell"),
        ({"valid": False}, "no valid model"),
        ({"n_faces": 900, "faces": []}, "valid closed solid, 900 bicubic patches\n"),
    ],
)
def test_the_verdict_comes_first(change, verdict):
    assert shown({**SUMMARY, **change}).startswith(verdict)


def test_patches_are_counted_and_not_listed():
    patches = [{"kind": "patch", "parameters": {}, **FACE}] * 40
    text = shown({**SUMMARY, "n_faces": 43, "faces": SUMMARY["faces"] + patches})
    assert text.startswith("valid closed solid, 3 faces and 40 bicubic patches\n")
    assert "plane" in text
    assert "\n3  " not in text


def test_an_empty_run_is_shown_too():
    empty = {"faces": [], "edges": [], "corners": [], "timings": {}, "warnings": []}
    assert "0 sharp edges, 0 corners" in shown({**SUMMARY, **empty, "valid": False})


def test_progress_writes_one_line_a_stage_where_there_is_no_terminal():
    console = Console(file=io.StringIO())
    with show_progress(console) as progress:
        for stage, fraction in (("net", 0.0), ("net", 0.2), ("fit", 0.5)):
            progress(stage, fraction)
    assert console.file.getvalue() == "  0%  net\n 50%  fit\n"


def test_progress_cleans_up_on_a_terminal():
    console = Console(file=io.StringIO(), force_terminal=True)
    with show_progress(console) as progress:
        progress("net", 0.5)
    assert not console._live_stack
