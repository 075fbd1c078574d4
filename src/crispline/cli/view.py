"""Command on reports: view."""

from __future__ import annotations

from pathlib import Path

import click

from crispline.cli.program import program
from crispline.errors import InputError

_MARK = b'<meta name="generator" content="crispline'


@program.command(epilog="Example: crispline view part.html")
@click.argument("report", type=click.Path(path_type=Path))
def view(report: Path) -> None:
    """Open REPORT, a page written by --report, in the web browser."""
    import webbrowser

    try:
        with report.open("rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise InputError(
            f"cannot read '{report}': {error.strerror}; give a page that --report has written"
        ) from error
    if _MARK not in head:
        raise InputError(f"'{report}': expected a page that --report has written, got another file")
    address = report.resolve().as_uri()
    try:
        is_open = webbrowser.open(address)
    except webbrowser.Error:
        is_open = False
    if not is_open:
        raise InputError(f"no web browser was found here; open this address in one: {address}")
    click.echo(address)
