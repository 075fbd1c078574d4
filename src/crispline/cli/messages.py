"""What a command tells while it runs: --quiet, --verbose, --log-json, and how it ends."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import RenderableType

    from crispline.configuration import Configuration

_PIPE_WIDTH = 160
_QUIET, _VERBOSE, _JSON = "crispline.quiet", "crispline.verbose", "crispline.log_json"
_SUMMARY, _START = "crispline.summary", "crispline.start"


def message_options() -> list[click.Parameter]:
    """The options that every command has, and the program itself."""
    return [
        _flag("-q", "--quiet", key=_QUIET, text="Tell errors only."),
        _flag("-v", "--verbose", key=_VERBOSE, text="Also tell versions, settings and seconds."),
        _flag(
            "--log-json", key=_JSON, text="Tell stages and outcome on stderr, a JSON object a line."
        ),
    ]


def _flag(*names: str, key: str, text: str) -> click.Option:
    def note(context: click.Context, parameter: click.Parameter, value: bool) -> None:
        if value:
            context.meta[key] = True
        if context.meta.get(_QUIET) and context.meta.get(_VERBOSE):
            raise click.UsageError("--quiet and --verbose: expected one of them, got both", context)

    # Eager, so that errors in other options are told in the form that is asked for.
    return click.Option(
        names, is_flag=True, expose_value=False, is_eager=True, callback=note, help=text
    )


def is_quiet() -> bool:
    """Whether only errors are to be told."""
    return _is_set(_QUIET)


def is_verbose() -> bool:
    """Whether details are to be told."""
    return _is_set(_VERBOSE)


def is_json() -> bool:
    """Whether stderr is to hold JSON only."""
    return _is_set(_JSON)


def tell(content: RenderableType) -> None:
    """Print text or tables on stdout; wide in a pipe or a file, where nothing wraps lines."""
    from rich.console import Console

    console = Console()
    if not console.is_terminal:
        console.width = _PIPE_WIDTH
    console.print(content)


def _is_set(key: str) -> bool:
    return bool(click.get_current_context().meta.get(key))


def progress() -> AbstractContextManager[Callable[[str, float], None]]:
    """A callback for stages that tells them on stderr in the form that is asked for."""
    from rich.console import Console

    from crispline.report.progress import events, show_progress, timed_lines

    if is_json():
        return nullcontext(events(write_event, click.get_current_context().meta[_START]))
    if is_quiet():
        return nullcontext(lambda stage, fraction: None)
    console = Console(stderr=True)
    return nullcontext(timed_lines(console)) if is_verbose() else show_progress(console)


def note(text: str) -> None:
    """Tell something on stderr that is no error."""
    if is_json():
        write_event({"event": "note", "message": text})
    elif not is_quiet():
        click.echo(text, err=True)


def note_run(configuration: Configuration) -> None:
    """With --verbose, tell what runs, and with which settings other than the defaults."""
    if not is_verbose():
        return
    import platform
    from importlib.metadata import version

    from crispline import __version__
    from crispline.configuration import changed, toml_value

    names = ("numpy", "scipy", "cadquery-ocp-novtk")
    versions = ", ".join(f"{name} {version(name)}" for name in names)
    system = f"Python {platform.python_version()}, {platform.platform()}"
    note(f"crispline {__version__}, {versions}, {system}")
    others = [
        f"{one.name} = {'none' if one.value is None else toml_value(one.value)}"
        for one in changed(configuration)
    ]
    note(f"settings other than the defaults: {', '.join(others) or 'none'}")


def conclude(summary: Mapping[str, Any]) -> None:
    """Set what the last line of --log-json holds beside the exit code."""
    click.get_current_context().meta[_SUMMARY] = dict(summary)


def write_event(event: Mapping[str, Any]) -> None:
    """Write one line of --log-json."""
    click.echo(json.dumps(event, allow_nan=False), err=True)


@contextmanager
def timed() -> Iterator[None]:
    """Run a command, and end it with the line of its outcome if it succeeds."""
    context = click.get_current_context()
    context.meta[_START] = time.perf_counter()
    yield
    if is_json():
        write_event({"event": "result", "exit_code": 0, **_outcome(context)})


def tell_error(message: str, exit_code: int, prefix: str = "Error: ") -> None:
    """Tell why a command failed, whatever else is to be told."""
    context = click.get_current_context()
    if is_json():
        head = {"event": "error", "exit_code": exit_code, "message": message}
        write_event({**head, **_outcome(context)})
    else:
        click.echo(f"{prefix}{message}", err=True)


def _outcome(context: click.Context) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if _START in context.meta:
        found["seconds"] = round(time.perf_counter() - context.meta[_START], 3)
    if _SUMMARY in context.meta:
        found["summary"] = context.meta[_SUMMARY]
    return found
