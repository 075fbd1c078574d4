"""The paper's experiment: every method on every feature, position, noise level and seed."""

from __future__ import annotations

import math
import signal
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from itertools import product
from multiprocessing import get_context
from typing import Protocol

from crispline.errors import InputError
from crispline.paper.rows import METHODS, RULES, Method, Row, Trial, published_rows, rows_of
from crispline.paper.windows import FEATURES
from crispline.shapes import SAMPLINGS
from crispline.stopwatch import Progress

PHASES = (0.0, 0.125, 0.25, 0.375, 0.5)
"""Positions of the feature between two columns of points, in cells."""
NOISE_LEVELS = (0.0, 0.005, 0.01, 0.02, 0.05, 0.1)
"""The paper's levels, and two where it says its method fails."""


class Run(Protocol):
    """A piece of the experiment that runs by itself."""

    @property
    def title(self) -> str:
        """What progress shows."""

    @property
    def cost(self) -> float:
        """About how long it takes, to be compared with other runs."""

    def trials(self, threads: int) -> list[Trial]:
        """Run it with so many threads, 0 for all cores; the result is the same."""


@dataclass(frozen=True)
class Plan:
    """What to run.

    Attributes
    ----------
    methods : see `METHODS`.
    phases : positions for the grids, 0 to 0.5.
    noise_levels : steps of the points over an eighth of the model's length.
    n_seeds : seeds for the grids; without noise the grids do not depend on the seed, so
        there one is run.
    n_whole_seeds : seeds for the pipeline, which takes most of the time.
    """

    methods: tuple[Method, ...] = METHODS
    phases: tuple[float, ...] = PHASES
    noise_levels: tuple[float, ...] = NOISE_LEVELS
    n_seeds: int = 10
    n_whole_seeds: int = 3

    def __post_init__(self) -> None:
        """Refuse what cannot be run, with an `InputError`."""
        for name, values in (
            ("method", self.methods),
            ("phase", self.phases),
            ("noise level", self.noise_levels),
        ):
            if not values:
                raise InputError(f"{name}s: expected at least one, got none")
            if len(set(values)) < len(values):
                raise InputError(f"{name}s: expected each once, got one twice in {list(values)}")
        for method in self.methods:
            if method not in METHODS:
                raise InputError(f"method: expected one of {', '.join(METHODS)}, got '{method}'")
        for phase in self.phases:
            if not 0.0 <= phase <= 0.5:
                raise InputError(f"phase: expected a position of 0 to 0.5 cells, got {phase}")
        for level in self.noise_levels:
            if not 0.0 <= level < math.inf:
                raise InputError(
                    f"noise level: expected a fraction of 0 or more, got {level}; 0.02 is 2 %"
                )
        for n in (self.n_seeds, self.n_whole_seeds):
            if n < 1:
                raise InputError(f"seeds: expected 1 or more, got {n}")

    def runs(self) -> Iterator[Run]:
        """Every single run, the long ones first."""
        rules = tuple(rule for rule in RULES if rule in self.methods)
        if "pipeline" in self.methods:
            from crispline.paper.whole import WholeRun

            for level, sampling in product(self.noise_levels, SAMPLINGS):
                is_fixed = level == 0.0 and sampling != "random"
                for seed in range(1 if is_fixed else self.n_whole_seeds):
                    yield WholeRun(sampling, level, seed)
        if rules:
            from crispline.paper.grids import GridRun

            for level, phase, feature in product(self.noise_levels, self.phases, FEATURES):
                for seed in range(1 if level == 0.0 else self.n_seeds):
                    yield GridRun(feature, phase, level, seed, rules)


def run(plan: Plan, *, n_jobs: int = 1, progress: Progress | None = None) -> list[Row]:
    """Run the experiment.

    Parameters
    ----------
    plan : what to run.
    n_jobs : processes to use; the rows do not depend on it.
    progress : called with what was run last and the share of the work that is done.

    Returns
    -------
    Rows ordered by method as in the plan, then noise, feature and sampling.
    """
    runs = list(plan.runs())
    found: list[list[Trial]] = [[] for _ in runs]
    total, spent = sum(each.cost for each in runs), 0.0
    for index, trials in _finished(runs, n_jobs):
        found[index] = trials
        spent += runs[index].cost
        if progress is not None:
            progress(runs[index].title, spent / total)
    rows = published_rows(plan.noise_levels) if "published" in plan.methods else []
    rows += rows_of([trial for trials in found for trial in trials])

    def place(row: Row) -> tuple[int, int, int, str]:
        return (
            plan.methods.index(row.method),
            plan.noise_levels.index(row.noise),
            FEATURES.index(row.feature),
            row.sampling,
        )

    return sorted(rows, key=place)


def _finished(runs: Sequence[Run], n_jobs: int) -> Iterator[tuple[int, list[Trial]]]:
    """Index and trials of every run, as they are done."""
    if n_jobs == 1:
        yield from ((index, each.trials(threads=0)) for index, each in enumerate(runs))
        return
    # Fresh interpreters: forking a process that has threads may lock it up.
    # Ctrl-C reaches them too, and ends them at once and silently.
    workers = ProcessPoolExecutor(
        n_jobs,
        mp_context=get_context("spawn"),
        initializer=signal.signal,
        initargs=(signal.SIGINT, signal.SIG_DFL),
    )
    with workers as pool:
        index_of = {pool.submit(_trials, each): index for index, each in enumerate(runs)}
        try:
            for future in as_completed(index_of):
                yield index_of[future], future.result()
        except BaseException:  # Ctrl-C must not wait for what has not begun
            pool.shutdown(cancel_futures=True)
            raise


def _trials(each: Run) -> list[Trial]:
    return each.trials(threads=1)
