"""The table of the benchmark in Markdown."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import date
from typing import Any

import numpy as np

from parts.rows import Row

COLUMNS = (
    "part", "points", "noise", "result", "faces", "precision", "recall", "F1", "corner recall",
    "corner precision", "mean", "p99", "reverse p99", "under 3", "3 to 5", "over 5", "tolerance",
    "s", "MB", "warnings",
)  # fmt: skip


def report(rows: Sequence[Row], day: date, hides_names: bool = False) -> Iterator[str]:
    """Lines of Markdown: the table, means over what was reconstructed, failures.

    ``hides_names`` numbers the truths of others, for a table that is published.
    """
    rows = sorted(rows, key=_order)
    if hides_names:
        own = [row for row in rows if row.is_own]
        others = [row for row in rows if not row.is_own]
        rows = own + [
            replace(row, case=replace(row.case, name=f"other {number}"))
            for number, row in enumerate(others, start=1)
        ]
    yield f"{day.isoformat()}, {len(rows)} runs."
    yield ""
    yield "| " + " | ".join(COLUMNS) + " |"
    yield "|---" * COLUMNS.index("points") + "|---" + "|---:" * (len(COLUMNS) - 2) + "|"
    for row in rows:
        yield "| " + " | ".join(_cells(row)) + " |"
    yield ""
    yield from _summary(rows)
    failures = [row for row in rows if row.reason]
    if failures:
        yield ""
        yield "Failures:"
        yield ""
        for row in failures:
            end = "stopped" if row.exit_code is None else f"exit {row.exit_code}"
            yield f"- {_title(row)}: {end}; {row.reason}"


def _order(row: Row) -> tuple[bool, int, float, str]:
    return not row.is_own, row.n_points if row.is_own else 0, row.case.noise or 0.0, row.case.name


def _title(row: Row) -> str:
    if row.case.noise is None:
        return f"{row.case.name} ({row.n_points} points)"
    return f"{row.case.name} ({row.n_points} points, noise {row.case.noise:.2%})"


def _cells(row: Row) -> Iterator[str]:
    yield row.case.name
    yield f"{row.n_points:,}"
    yield f"{row.noise:.2f}"
    yield result(row)
    score = row.score
    if score is None:
        yield from ["-"] * 13
    else:
        true = score["n_true_faces"]
        yield f"{score['n_faces']}" + ("" if true is None else f" / {true}")
        for name in (
            "edge_precision", "edge_recall", "edge_f1", "corner_recall", "corner_precision",
            "surface_mean", "surface_p99", "reverse_p99",
        ):  # fmt: skip
            yield _number(score[name])
        groups = score["recovered"]
        yield from ["-"] * 3 if groups is None else [f"{found}/{n}" for found, n in groups]
        yield _number(score["tolerance"])
    yield f"{row.seconds:.0f}"
    yield "-" if row.peak_mb is None else f"{row.peak_mb:.0f}"
    yield str(len(row.warnings))


def result(row: Row) -> str:
    """What came out, in a word or two."""
    if row.exit_code is None:
        return "stopped"
    if row.exit_code != 0:
        return {2: "bad input", 3: "refused"}.get(row.exit_code, "broke down")
    if row.score is None:
        return "not scored"
    words = ["closed" if row.score["is_closed"] else "open"]
    if not row.score["is_valid"]:
        words.insert(0, "invalid")
    if row.representation:
        words.append(row.representation)
    return " ".join(words)


def _summary(rows: Sequence[Row]) -> Iterator[str]:
    """Means of each group of runs: own parts by size and noise, truths."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        level = "as given" if row.case.noise is None else f"{row.case.noise:.2%}"
        name = f"own, {row.n_points:,} points, {level}" if row.is_own else "truths"
        groups.setdefault(name, []).append(row)
    yield (
        "| group | valid closed | valid | F1 | corner recall | corner precision | mean | p99 "
        "| faces within 10 % | over 5 | 3 to 5 | under 3 | slowest | most MB |"
    )
    yield "|---" + "|---:" * 13 + "|"
    for name, group in groups.items():
        scores = [row.score for row in group if row.score is not None]
        done = [row.score for row in group if row.score is not None and row.exit_code == 0]
        sound = [score for score in done if score["is_valid"]]
        closed = [score for score in sound if score["is_closed"]]
        known = [score for score in scores if score["recovered"] is not None]
        near = [
            0.9 * score["n_true_faces"] <= score["n_faces"] <= 1.1 * score["n_cut_faces"]
            for score in known
        ]
        means = " | ".join(
            _mean(scores, key)
            for key in (
                "edge_f1", "corner_recall", "corner_precision", "surface_mean", "surface_p99",
            )
        )  # fmt: skip
        recovered = " | ".join(_total(known, size) for size in (2, 1, 0))
        memory = max((row.peak_mb for row in group if row.peak_mb is not None), default=math.nan)
        yield (
            f"| {name} | {len(closed)} of {len(group)} | {len(sound)} | {means} "
            f"| {sum(near)} of {len(known)} | {recovered} "
            f"| {max(row.seconds for row in group):.0f} | {_number(memory, 0)} |"
        )


def _mean(scores: Sequence[dict[str, Any]], key: str) -> str:
    return _number(float(np.mean([score[key] for score in scores]))) if scores else "-"


def _total(scores: Sequence[dict[str, Any]], size: int) -> str:
    found = sum(score["recovered"][size][0] for score in scores)
    n = sum(score["recovered"][size][1] for score in scores)
    return f"{found}/{n}"


def _number(value: float, digits: int = 3) -> str:
    return "-" if not math.isfinite(value) else f"{value:.{digits}f}"
