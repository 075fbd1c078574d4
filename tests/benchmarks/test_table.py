"""Runs under a time limit, rows on disk, the table; no case is lost, whatever comes of it."""

import sys
from dataclasses import replace
from datetime import date

import numpy as np
import pytest

import parts_table
from parts.child import run
from parts.modelling import box
from parts.rows import Case, Row, append_row, own_cases, read_rows
from parts.scan import scan
from parts.table import COLUMNS, report
from parts.truth import write_truth

SCORE = {
    "is_valid": True, "is_closed": True, "n_solids": 1, "n_faces": 10, "n_true_faces": 9,
    "n_cut_faces": 10, "tolerance": 0.01, "edge_precision": 0.5, "edge_recall": 1.0,
    "edge_f1": 2 / 3, "edge_error": 0.1, "corner_precision": 0.75, "corner_recall": 0.25,
    "feature_to_surface": 0.1, "surface_mean": 0.02, "surface_p99": 0.2, "surface_max": 1.0,
    "reverse_mean": 0.03, "reverse_p99": float("nan"), "reverse_max": 2.0,
    "recovered": [[1, 2], [3, 4], [5, 6]],
}  # fmt: skip
GOOD = Row(
    Case("flange", 50_000, 0.001), True, 50_000, 0.16, 0, "", 12.3, 400.0, "trimmed", ("a",), SCORE
)
REFUSED = replace(
    GOOD, case=Case("elbow", 50_000, 0.001), exit_code=3, reason="region 7", score=None
)
LATE = replace(REFUSED, case=Case("scan"), is_own=False, exit_code=None, reason="no end")


def test_a_program_ends_by_itself(tmp_path):
    ended = run(60.0, tmp_path, sys.executable, "-c", "print('yes'); raise SystemExit(3)")
    assert (ended.exit_code, ended.output.strip()) == (3, "yes")


@pytest.mark.skipif(sys.platform == "win32", reason="the system does not tell")
def test_memory_is_that_of_the_program(tmp_path):
    lean = run(60.0, tmp_path, sys.executable, "-c", "pass").peak_mb
    fat = run(60.0, tmp_path, sys.executable, "-c", "b'x' * (300 * 2**20)").peak_mb
    assert fat - lean == pytest.approx(300, abs=20)


def test_a_program_is_stopped_at_the_limit(tmp_path):
    ended = run(0.5, tmp_path, sys.executable, "-c", "import time; time.sleep(60)")
    assert ended.exit_code is None
    assert ended.seconds < 20


def test_rows_come_back_and_the_last_of_a_case_counts(tmp_path):
    file = tmp_path / "rows.jsonl"
    assert read_rows(file) == []
    append_row(file, REFUSED)
    append_row(file, LATE)
    append_row(file, replace(REFUSED, reason="other"))
    assert read_rows(file) == [replace(REFUSED, reason="other"), LATE]


def test_every_case_has_a_key_of_its_own():
    cases = list(own_cases(["a", "b"], [100, 200], [0.0, 0.0005], seed=1))
    assert len({case.key for case in cases}) == len(cases) == 8


def test_the_table_shows_every_row_and_why_some_failed():
    lines = list(report([GOOD, REFUSED, LATE], date(2000, 1, 2)))
    table = [line for line in lines if line.count("|") == len(COLUMNS) + 1]
    assert len(table) == 2 + 3
    assert "refused" in table[2]  # by name: the elbow first
    assert "10 / 9 | 0.500 | 1.000 | 0.667 | 0.250 | 0.750" in table[3]
    assert "1/2 | 3/4 | 5/6" in table[3]
    assert "stopped" in table[4]
    text = "\n".join(lines)
    assert "elbow (50000 points, noise 0.10%): exit 3; region 7" in text
    assert "| own, 50,000 points, 0.10% | 1 of 2 |" in text
    assert "nan" not in text


def test_a_published_table_does_not_name_the_files_of_others():
    text = "\n".join(report([GOOD, LATE], date(2000, 1, 2), hides_names=True))
    assert "| other 1 |" in text
    assert "| scan |" not in text
    assert "scan (" not in text
    assert "| flange |" in text


def test_a_cloud_that_is_refused_is_a_row(tmp_path):
    truth, area = scan(box((3, 2, 1)), 100)
    few = replace(truth, points=truth.points[:5])
    write_truth(tmp_path / "few.npz", few, area)
    row = parts_table.run_case(Case("few"), tmp_path / "out", tmp_path, limit=60.0)
    assert (row.exit_code, row.score, row.is_own) == (2, None, False)
    assert "points" in row.reason
    assert row.seconds > 0
    [line] = [line for line in report([row], date(2000, 1, 2)) if line.startswith("| few")]
    assert "bad input" in line


def test_a_model_is_scored_in_the_row(tmp_path, monkeypatch):
    # In place of the program, one that writes the right model at once.
    truth, area = scan(box((3, 2, 1)), 500)
    write_truth(tmp_path / "box.npz", truth, area)
    program = tmp_path / "crispline.py"
    program.write_text(
        "import sys\n"
        "from pathlib import Path\n"
        "target = sys.argv[sys.argv.index('-o') + 1]\n"
        f"Path(target).write_bytes(Path({str(tmp_path / 'model.step')!r}).read_bytes())\n"
    )
    from crispline.cadfile.step import write_step

    write_step(box((3, 2, 1)), tmp_path / "model.step")
    real = parts_table.run

    def pretend(limit, scratch, *command):
        words = [program if word == "crispline" else word for word in command if word != "-m"]
        return real(limit, scratch, *words)

    monkeypatch.setattr(parts_table, "run", pretend)
    row = parts_table.run_case(Case("box"), tmp_path / "out", tmp_path, limit=60.0)
    assert row.reason == ""
    assert row.score["edge_f1"] == 1.0
    assert np.isclose(row.noise, 0.0)
    stale = replace(row, score=None)
    assert parts_table.rescored(stale, tmp_path / "out", tmp_path) == row
