"""The whole program over parts of our own and, if there are any, over truths of others.

    python benchmarks/parts_table.py [--points 50000,200000] [--noise 0,0.0005,0.001,0.002]
        [--parts flange,elbow] [--truth DIR] [--markdown FILE]

Each scan is made, reconstructed (``crispline reconstruct``) and scored in processes of their
own, under a time limit. Rows go to ``rows.jsonl`` in the output folder as they come, and
cases that have a row are not run again: a run that was broken off goes on. Clouds, truths
and models stay in that folder, so one can be scored or looked at by hand.

``--truth`` (or the environment variable ``CRISPLINE_TRUTH``) names a folder of truths, see
``docs/benchmark.md``; they are run as they are.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from crispline.files import write_text
from parts.catalogue import PARTS
from parts.child import Ended, run
from parts.rows import Case, Row, append_row, own_cases, read_rows
from parts.table import report, result
from parts.truth import Truth, read_truth

HERE = Path(__file__).parent
_SCORING_LIMIT = 900.0
_HEADING = "# The parts benchmark: last table"


def run_case(case: Case, folder: Path, truths: Path | None, limit: float) -> Row:
    """Scan, reconstruct and score one case; every failure is a row too."""
    place = folder / case.key
    place.mkdir(parents=True, exist_ok=True)
    cloud, model, summary_path = place / "cloud.npy", place / "model.step", place / "summary.json"
    for old in (model, summary_path):
        old.unlink(missing_ok=True)
    truth_path = _truth_path(case, place, truths)
    truth = read_truth(truth_path)
    np.save(cloud, truth.points)
    ended = run(
        limit,
        place / "program",
        *(sys.executable, "-m", "crispline", "reconstruct", cloud),
        *("-o", model, "--summary", summary_path),
    )
    summary: dict[str, Any] = {}
    if summary_path.exists():
        summary = json.loads(summary_path.read_text(encoding="utf-8"))
    score, reason = None, _reason(ended, summary, limit)
    if model.exists():
        score, complaint = _score(model, truth_path, place)
        reason = reason or complaint
    return Row(
        case=case,
        is_own=case.n_points is not None,
        n_points=len(truth.points),
        noise=_noise(truth),
        exit_code=ended.exit_code,
        reason=reason,
        seconds=ended.seconds,
        peak_mb=ended.peak_mb,
        representation=str(summary.get("representation") or ""),
        warnings=tuple(summary.get("warnings", ())),
        score=score,
    )


def rescored(row: Row, folder: Path, truths: Path | None) -> Row:
    """The same run, its model judged anew; for a referee that has changed."""
    place = folder / row.case.key
    model = place / "model.step"
    if not model.exists():
        return row
    score, complaint = _score(model, _truth_path(row.case, place, truths), place)
    return replace(row, score=score, reason=complaint if row.exit_code == 0 else row.reason)


def _truth_path(case: Case, place: Path, truths: Path | None) -> Path:
    """The truth of a case, made if the part is our own."""
    if case.n_points is None or case.noise is None:
        if truths is None:
            raise FileNotFoundError(f"no folder of truths was named for '{case.name}'")
        return truths / f"{case.name}.npz"
    path = place / "truth.npz"
    if not path.exists():
        ended = run(
            _SCORING_LIMIT,
            place / "scan",
            *(sys.executable, HERE / "parts_scan.py", case.name, path),
            *("--points", case.n_points, "--noise", case.noise, "--seed", case.seed),
        )
        if ended.exit_code != 0:
            raise RuntimeError(f"part '{case.name}' cannot be scanned: {ended.complaint}")
    return path


def _reason(ended: Ended, summary: dict[str, Any], limit: float) -> str:
    """Why there is no model; empty if there is one."""
    if ended.exit_code == 0:
        return ""
    if ended.exit_code is None:
        return f"no end within {limit:g} s"
    lines = [line.strip() for line in ended.complaint.splitlines() if line.strip()]
    if ended.exit_code < 0:
        return f"killed by signal {-ended.exit_code}"
    return str(summary.get("error") or (lines[-1] if lines else "no message"))


def _score(model: Path, truth: Path, place: Path) -> tuple[dict[str, Any] | None, str]:
    """The referee's score, or None and why."""
    words = (sys.executable, HERE / "referee.py", model, truth, "--json")
    ended = run(_SCORING_LIMIT, place / "referee", *words)
    if ended.exit_code != 0:
        last = (ended.complaint.strip().splitlines() or ["no message"])[-1]
        return None, f"the referee ended with {ended.exit_code}: {last}"
    score: dict[str, Any] = json.loads(ended.output)
    return score, ""


def _noise(truth: Truth) -> float:
    """Standard deviation of a coordinate in spacings."""
    return truth.noise * truth.diagonal / truth.spacing


def _listed(kind: Callable[[str], Any]) -> Callable[[str], list[Any]]:
    return lambda text: [kind(word) for word in text.split(",") if word]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--points", type=_listed(int), default=[50_000, 200_000])
    parser.add_argument("--noise", type=_listed(float), default=[0.0, 0.0005, 0.001, 0.002])
    parser.add_argument("--parts", type=_listed(str), default=list(PARTS), help="only these")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--truth", type=Path, default=os.environ.get("CRISPLINE_TRUTH") or None)
    parser.add_argument("--limit", type=float, default=600.0, help="seconds for one run")
    parser.add_argument("--out", type=Path, default=Path("out/parts"))
    parser.add_argument("--again", action="store_true", help="run cases that have a row, too")
    parser.add_argument("--rescore", action="store_true", help="judge the kept models anew")
    parser.add_argument("--no-run", action="store_true", help="only print the table")
    parser.add_argument("--markdown", type=Path, help="also write the table to this file")
    return parser.parse_args()


def main() -> None:
    """Run what has no row yet, then print the table."""
    arguments = _arguments()
    unknown = sorted(set(arguments.parts) - set(PARTS))
    if unknown:
        sys.exit(f"unknown parts: {', '.join(unknown)}; there are {', '.join(PARTS)}")
    truths = arguments.truth
    cases = list(own_cases(arguments.parts, arguments.points, arguments.noise, arguments.seed))
    if truths is not None:
        cases += [Case(path.stem) for path in sorted(truths.glob("*.npz"))]
    arguments.out.mkdir(parents=True, exist_ok=True)
    file = arguments.out / "rows.jsonl"
    wanted = {case.key for case in cases}
    if arguments.rescore:
        for row in read_rows(file):
            if row.case.key in wanted:
                append_row(file, rescored(row, arguments.out, truths))
    done = set() if arguments.again else {row.case.key for row in read_rows(file)}
    for number, case in enumerate(cases, start=1):
        if case.key in done or arguments.no_run:
            continue
        row = run_case(case, arguments.out, truths, arguments.limit)
        append_row(file, row)
        print(f"{number}/{len(cases)} {case.key}: {result(row)}, {row.seconds:.0f} s", flush=True)
    rows = [row for row in read_rows(file) if row.case.key in wanted]
    print(*report(rows, date.today()), sep="\n")
    if arguments.markdown:
        lines = report(rows, date.today(), hides_names=True)
        write_text(arguments.markdown, "\n".join([_HEADING, "", *lines, ""]))


if __name__ == "__main__":
    main()
