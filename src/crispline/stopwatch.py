"""Seconds per stage of a run, and who is told about its progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from crispline.errors import CrisplineError, ReconstructionError

Progress = Callable[[str, float], None]
"""Called with the name of a stage that begins and the share of the run that is done."""


class Stopwatch:
    """Times consecutive stages."""

    def __init__(self, progress: Progress | None = None) -> None:
        self._progress = progress
        self._timings: dict[str, float] = {}
        self._stage: str | None = None
        self._since = 0.0

    def stage(self, name: str, done: float) -> None:
        """End the stage before and begin the next; ``done`` is the share of the run, 0 to 1."""
        self._close()
        self._stage = name
        if self._progress is not None:
            self._progress(name, done)

    @contextmanager
    def guard(self) -> Iterator[None]:
        """Turn an unforeseen error into one sentence that names the stage it came from.

        Raises
        ------
        ReconstructionError
            In place of any exception that is not of this package.
        """
        try:
            yield
        except CrisplineError:
            raise
        except Exception as error:
            raise ReconstructionError(
                f"stage '{self._stage}' broke down ({type(error).__name__}: {error}); "
                "this is a defect of crispline, please report it together with the cloud"
            ) from error

    def stop(self) -> dict[str, float]:
        """End the last stage; seconds per stage in their order."""
        self._close()
        if self._progress is not None:
            self._progress("done", 1.0)
        return dict(self._timings)

    def _close(self) -> None:
        now = time.perf_counter()
        if self._stage is not None:
            self._timings[self._stage] = now - self._since
        self._stage, self._since = None, now
