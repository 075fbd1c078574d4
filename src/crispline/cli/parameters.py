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

# The names of crispline.cadfile.units, repeated so that --help is instant.
UNITS = ("mm", "um", "cm", "m", "km", "in", "mil", "ft")
units_option = click.option(
    "--units",
    "unit",
    type=click.Choice(UNITS),
    default="mm",
    show_default=True,
    help="What the numbers of the cloud are; STEP, IGES, DXF and JSON name it.",
)
_MESH_TOLERANCE: dict[str, Any] = {
    "type": click.FloatRange(min=0.0, min_open=True),
    "help": "Distance of triangles from the faces, for GLB, STL, OBJ and PLY.  [default: a tenth "
    "of the spacing; 1/2000 of the size if that is unknown]",
}
tolerance_option = click.option("--tolerance", **_MESH_TOLERANCE)
mesh_tolerance_option = click.option("--mesh-tolerance", **_MESH_TOLERANCE)
required_tolerance_option = click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Largest deviation allowed: exit 3 unless 95 % of the points of every face lie within "
    "it (faces of at least 20 points). The files are written all the same.",
)


def output_option(
    *names: str,
    suffixes: tuple[str, ...],
    text: str,
    required: bool = False,
    multiple: bool = False,
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Option for a file to write, refused before the work if it could not be written."""

    def check(context: click.Context, parameter: click.Parameter, value: Any) -> Any:
        for path in value if multiple else [value]:
            if path is not None:
                check_path(context, parameter, path, suffixes)
        return value

    return click.option(
        *names,
        type=click.Path(path_type=Path),
        callback=check,
        required=required,
        multiple=multiple,
        help=text,
    )


def check_path(
    context: click.Context, parameter: click.Parameter, path: Path, suffixes: tuple[str, ...]
) -> None:
    """Refuse a file to write as bad usage if it could not be written."""
    try:
        check_output(path, suffixes)
    except InputError as error:
        raise click.BadParameter(str(error), context, parameter) from error


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
