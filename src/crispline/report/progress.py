"""Progress of a run on the terminal, or as lines in a log."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn


@contextmanager
def show_progress(console: Console) -> Iterator[Callable[[str, float], None]]:
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


def _line_per_stage(console: Console) -> Callable[[str, float], None]:
    seen: set[str] = set()

    def report(stage: str, fraction: float) -> None:
        if stage not in seen:
            seen.add(stage)
            console.print(f"{fraction:4.0%}  {stage}", markup=False, highlight=False)

    return report
