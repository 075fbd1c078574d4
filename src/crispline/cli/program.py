"""The program that the commands belong to, and how they end."""

from __future__ import annotations

import errno
import os
import signal
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from types import FrameType
from typing import Any

import click

from crispline import __version__
from crispline.cli import messages
from crispline.cli.options import dump_option
from crispline.errors import CrisplineError

_INTERRUPTED = 130  # 128 and the number of the signal, as shells have it
_TERMINATED = 143


class _Terminated(BaseException):
    """The system, a batch queue or a container asked the program to end."""


@contextmanager
def _heeding_termination() -> Iterator[None]:
    """Let SIGTERM end a command as Ctrl-C does: nothing half-written stays behind."""
    if threading.current_thread() is not threading.main_thread():
        yield  # signals belong to the main thread, and to whoever runs the command in another
        return

    def end(number: int, frame: FrameType | None) -> None:
        raise _Terminated

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


class _Command(click.Command):
    """A command with the options that all have; --quiet silences it."""

    def __init__(self, *args: Any, **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.params += messages.message_options()

    def invoke(self, context: click.Context) -> Any:
        with messages.timed():
            if not messages.is_quiet():
                return super().invoke(context)
            with open(os.devnull, "w", encoding="utf-8") as nowhere, redirect_stdout(nowhere):
                return super().invoke(context)


class _Program(click.Group):
    """Turns whatever ends a command early into one sentence and an exit code."""

    command_class = _Command

    def invoke(self, context: click.Context) -> Any:
        try:
            with _heeding_termination():
                return super().invoke(context)
        except click.ClickException as error:
            if not messages.is_json():
                raise
            exit_code = error.exit_code
            messages.tell_error(error.format_message(), exit_code)
        except (click.exceptions.Exit, click.Abort):
            raise
        except KeyboardInterrupt:
            exit_code = _INTERRUPTED
            message = "Interrupted; files that were not finished are not written"
            messages.tell_error(message, exit_code, prefix="")
        except _Terminated:
            exit_code = _TERMINATED
            message = "Terminated; files that were not finished are not written"
            messages.tell_error(message, exit_code, prefix="")
        except CrisplineError as error:
            exit_code = error.exit_code
            if messages.is_verbose() and error.__cause__ is not None:
                messages.note("".join(traceback.format_exception(error.__cause__)).rstrip())
            messages.tell_error(str(error), exit_code)
        except Exception as error:
            if isinstance(error, OSError) and error.errno == errno.EPIPE:
                raise  # the reader of a pipe has left; click ends quietly
            exit_code = 1
            if messages.is_verbose():
                messages.note(traceback.format_exc().rstrip())
            messages.tell_error(
                f"{type(error).__name__}: {error}; this is a defect of crispline, please report "
                "it with what --verbose tells",
                exit_code,
            )
        raise click.exceptions.Exit(exit_code)


@click.group(
    cls=_Program,
    context_settings={"help_option_names": ["-h", "--help"]},
    params=messages.message_options(),
    epilog="Example: crispline reconstruct scan.ply -o part.step",
)
@dump_option
@click.version_option(__version__)
def program() -> None:
    """Noisy point clouds to CAD solids with sharp edges and corners.

    Exit codes: 0 done, 2 bad usage or bad input, 3 no valid model could be made, 130
    interrupted, 143 terminated.
    """
