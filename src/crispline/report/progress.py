"""Progress of a run: a bar on the terminal, lines in a log, or JSON for programs."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

Report = Callable[[str, float], None]
"""Called with the name of a stage that begins and the share of the run that is done."""


@contextmanager
def show_progress(console: Console) -> Iterator[Report]:
    """Yield a callback ``(stage, fraction done of the whole run)`` that reports to ``console``.

    On a terminal there is one moving bar; elsewhere every stage writes one line.
    """
    if not console.is_terminal:
        yield _line_per_stage(console)
        return
    columns = (BarColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("start", total=1.0)
        yield lambda stage, fraction: bar.update(task, description=stage, completed=fraction)


def timed_lines(console: Console) -> Report:
    """A callback that writes every stage with the seconds since the start, on any console."""
    start = time.perf_counter()

    def report(stage: str, fraction: float) -> None:
        seconds = time.perf_counter() - start
        console.print(f"{fraction:4.0%} {seconds:8.2f} s  {stage}", markup=False, highlight=False)

    return report


def events(write: Callable[[dict[str, Any]], None], start: float) -> Report:
    """A callback that hands on every stage as an event with its share and the seconds so far.

    Parameters
    ----------
    write : takes one event.
    start : what ``time.perf_counter`` said when the command began.
    """

    def report(stage: str, fraction: float) -> None:
        seconds = round(time.perf_counter() - start, 3)
        write({"event": "stage", "stage": stage, "share": fraction, "seconds": seconds})

    return report


def _line_per_stage(console: Console) -> Report:
    seen: set[str] = set()

    def report(stage: str, fraction: float) -> None:
        if stage not in seen:
            seen.add(stage)
            console.print(f"{fraction:4.0%}  {stage}", markup=False, highlight=False)

    return report
