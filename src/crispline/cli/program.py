"""The program that the commands belong to."""

from __future__ import annotations

from typing import Any

import click

from crispline.errors import CrisplineError


class _Program(click.Group):
    """Turns the errors of the catalogue into one sentence and their exit code."""

    def invoke(self, context: click.Context) -> Any:
        try:
            return super().invoke(context)
        except CrisplineError as error:
            click.echo(f"Error: {error}", err=True)
            context.exit(error.exit_code)


@click.group(cls=_Program, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="crispline")
def program() -> None:
    """Noisy point clouds to CAD solids with sharp edges and corners.

    Exit codes: 0 done, 2 bad usage or bad input, 3 no valid model could be made.
    """
