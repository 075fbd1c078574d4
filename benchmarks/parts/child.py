"""Run a program of its own with a time limit, and say what it took."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import dataclass
from pathlib import Path

_LAUNCH = Path(__file__).with_name("launch.py")


@dataclass(frozen=True)
class Ended:
    """How a program ended.

    Attributes
    ----------
    exit_code : negative for the signal that killed it; None if the time was up.
    seconds : wall clock.
    peak_mb : most memory held, in MB; None if it was stopped, or where the system does not
        tell (Windows).
    output, complaint : what it wrote.
    """

    exit_code: int | None
    seconds: float
    peak_mb: float | None
    output: str
    complaint: str


def run(limit: float, scratch: Path, *command: object) -> Ended:
    """Run a command; kill it with its children at the limit.

    ``scratch`` is a folder for what it writes and takes; it is made if need be.
    """
    scratch.mkdir(parents=True, exist_ok=True)
    words = [str(word) for word in command]
    out, err, usage = (scratch / name for name in ("stdout.txt", "stderr.txt", "usage.txt"))
    usage.unlink(missing_ok=True)
    if sys.platform != "win32":
        words = [sys.executable, "-I", "-S", str(_LAUNCH), str(usage), *words]
    start = time.perf_counter()
    with out.open("wb") as to_out, err.open("wb") as to_err:
        child = subprocess.Popen(words, stdout=to_out, stderr=to_err, start_new_session=True)
        is_late = threading.Event()

        def stop() -> None:
            is_late.set()
            _kill(child)

        timer = threading.Timer(limit, stop)
        timer.start()
        try:
            exit_code = child.wait()
        except BaseException:  # Ctrl-C: leave nothing running
            _kill(child)
            raise
        finally:
            timer.cancel()
    peak_mb = None
    if usage.exists():
        first, second = usage.read_text(encoding="ascii").split()
        exit_code, peak_mb = int(first), float(second)
    return Ended(
        exit_code=None if is_late.is_set() else exit_code,
        seconds=time.perf_counter() - start,
        peak_mb=peak_mb,
        output=out.read_text(encoding="utf-8", errors="replace"),
        complaint=err.read_text(encoding="utf-8", errors="replace"),
    )


def _kill(child: subprocess.Popen[bytes]) -> None:
    if sys.platform == "win32":
        child.kill()
    else:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
