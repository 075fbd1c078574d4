"""Settings of a run: from a TOML file, and from the command line, which counts more."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from crispline.cli.messages import note_run

if TYPE_CHECKING:
    from crispline.configuration import Configuration

Command = Callable[..., None]


def _dump(context: click.Context, parameter: click.Parameter, value: bool) -> None:
    if not value or context.resilient_parsing:
        return
    from crispline.configuration import to_toml

    click.echo(to_toml(), nl=False)
    context.exit()


dump_option = click.option(
    "--dump-options",
    is_flag=True,
    is_eager=True,
    expose_value=False,
    callback=_dump,
    help="Print every setting with its default, meaning and unit as TOML, and exit.",
)
config_option = click.option(
    "--config",
    "config",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Settings in TOML as --dump-options prints them; options given here count more.",
)


def _flags(has_solid: bool) -> Sequence[Callable[[Command], Command]]:
    """What the command line can set; None means that the file or the default decides."""
    flags = [
        config_option,
        dump_option,
        click.option(
            "--open",
            "surface",
            flag_value="open",
            default=None,
            help="The scan is not closed: end the surface where the points end.",
        ),
        click.option(
            "--closed",
            "surface",
            flag_value="closed",
            default=None,
            help="The scan is closed: span every gap. By default the gaps decide.",
        ),
        click.option(
            "--fill-holes",
            type=click.FloatRange(min=0.0),
            help="Widest gap to close, in point spacings.  [default: 6.0]",
        ),
        click.option(
            "--normals",
            type=click.Choice(("auto", "file", "none")),
            help="Normals and scanner positions in the file tell the outside: if they agree with "
            "each other and the points, in any case, or never.  [default: auto]",
        ),
        click.option(
            "--regularize/--no-regularize",
            "regularize",
            default=None,
            help="Make surfaces parallel, perpendicular, coaxial, equal in radius where noise "
            "explains it.  [default: regularize]",
        ),
        click.option("--seed", type=click.IntRange(min=0), help="Random seed.  [default: 0]"),
        click.option(
            "--threads",
            type=click.IntRange(min=0),
            help="Threads to use, 0 for all cores; the result is the same.  [default: 0]",
        ),
    ]
    if has_solid:
        flags.insert(
            2,
            click.option(
                "--model",
                type=click.Choice(("auto", "trimmed", "patches")),
                help="Trimmed faces, bicubic patches, or the first of trimmed, mixed, patches "
                "that holds.  [default: auto]",
            ),
        )
    return flags


def run_options(has_solid: bool) -> Callable[[Command], Command]:
    """Give a command on clouds its settings, which it takes as ``options``.

    Parameters
    ----------
    has_solid : whether the command makes one, so that ``--model`` has a meaning.
    """

    def decorate(command: Command) -> Command:
        @wraps(command)
        def with_options(
            *,
            config: Path | None,
            surface: Any,
            fill_holes: float | None,
            normals: Any,
            regularize: bool | None,
            seed: int | None,
            threads: int | None,
            model: Any = None,
            **others: Any,
        ) -> None:
            given = configuration(config)
            options = _with(given.options, seed=seed, threads=threads, model=model)
            options = replace(
                options,
                net=_with(options.net, surface=surface, fill_holes=fill_holes, normals=normals),
                fit=_with(options.fit, regularize=regularize),
            )
            note_run(replace(given, options=options))
            command(options=options, **others)

        decorated: Command = with_options
        for flag in reversed(_flags(has_solid)):
            decorated = flag(decorated)
        return decorated

    return decorate


def sharpen_options(command: Command) -> Command:
    """Give a command on surfaces its settings, which it takes as ``options``."""

    @wraps(command)
    def with_options(
        *,
        config: Path | None,
        rule: Any,
        eps: float | None,
        repeat: int | None,
        **others: Any,
    ) -> None:
        given = configuration(config)
        options = _with(given.sharpen, rule=rule, eps=eps, repeat=repeat)
        note_run(replace(given, sharpen=options))
        command(options=options, **others)

    decorated: Command = with_options
    for flag in (
        click.option(
            "--repeat",
            type=click.IntRange(1, 3),
            help="How often located points enter; 3 makes edges sharp.  [default: 3]",
        ),
        click.option(
            "--rule",
            type=click.Choice(("robust", "paper")),
            help="The paper's rules to the letter, or those that find and locate every edge.  "
            "[default: robust]",
        ),
        click.option(
            "--eps",
            type=click.FloatRange(min=0.0, min_open=True),
            help="Patches of this mean curvature are curved, in 1/spacing.  [default: from the "
            "noise; 0.25 with the paper's rule]",
        ),
        dump_option,
        config_option,
    ):
        decorated = flag(decorated)
    return decorated


def configuration(path: Path | None) -> Configuration:
    """The settings of a file, or the defaults. Raises `InputError` if it cannot be used."""
    from crispline.configuration import Configuration, read

    return Configuration() if path is None else read(path)


def _with(options: Any, **given: Any) -> Any:
    """The options with those values in place that are not None."""
    return replace(options, **{name: value for name, value in given.items() if value is not None})
