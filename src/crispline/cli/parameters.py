"""Options and arguments that several commands share, and how their values are read."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from crispline.errors import InputError
from crispline.files import check_output

cloud_argument = click.argument("cloud", type=click.Path(path_type=Path))
seed_option = click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Random seed."
)
threads_option = click.option(
    "--threads",
    type=click.IntRange(min=0),
    default=0,
    show_default="all cores",
    help="Threads to use; the result is the same.",
)


def output_option(
    *names: str, suffixes: tuple[str, ...], text: str, required: bool = False
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Option for a file to write, refused before the work if it could not be written."""

    def check(context: click.Context, parameter: click.Parameter, path: Path | None) -> Path | None:
        if path is not None:
            try:
                check_output(path, suffixes)
            except InputError as error:
                raise click.BadParameter(str(error), context, parameter) from error
        return path

    file = click.Path(path_type=Path)
    return click.option(*names, type=file, callback=check, required=required, help=text)


def read_fraction(context: click.Context, parameter: click.Parameter, text: str) -> float:
    """Read a fraction of 0 or more, given as a number (0.02) or in per cent (2%)."""
    try:
        fraction = as_fraction(text)
    except ValueError:
        fraction = math.nan
    if not 0.0 <= fraction < math.inf:
        raise click.BadParameter(
            f"expected a number of 0 or more such as 0.02 or 2%, got '{text}'", context, parameter
        )
    return fraction


def as_fraction(text: str) -> float:
    """A number (0.02) or a number in per cent (2%) as a fraction.

    Raises
    ------
    ValueError
        If the text is neither.
    """
    return float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)


def listed(
    read: Callable[[str], Any], expected: str
) -> Callable[[click.Context, click.Parameter, str], tuple[Any, ...]]:
    """Read an option with values separated by commas."""

    def check(context: click.Context, parameter: click.Parameter, text: str) -> tuple[Any, ...]:
        try:
            return tuple(read(part.strip()) for part in text.split(","))
        except ValueError as error:
            raise click.BadParameter(
                f"expected {expected}, got '{text}'", context, parameter
            ) from error

    return check
