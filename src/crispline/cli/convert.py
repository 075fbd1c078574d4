"""The command that converts files: clouds to clouds, CAD models to CAD models and triangles."""

from __future__ import annotations

from pathlib import Path

import click

from crispline.cli.clouds import MODELS_OUT
from crispline.cli.experiments import CLOUDS_OUT
from crispline.cli.parameters import check_path, tolerance_option
from crispline.cli.program import program

# The suffixes of crispline.exchange.models, repeated so that --help is instant.
MODELS_IN = (".brep", ".brp", ".iges", ".igs", ".step", ".stp")


@program.command(
    epilog="Example: crispline convert scan.e57 scan.ply, crispline convert part.step part.stl"
)
@click.argument("source", metavar="IN", type=click.Path(path_type=Path))
@click.argument("target", metavar="OUT", type=click.Path(path_type=Path))
@tolerance_option
@click.pass_context
def convert(context: click.Context, source: Path, target: Path, tolerance: float | None) -> None:
    """Convert the file IN to OUT; the suffixes tell the formats.

    Clouds (PLY, PCD, LAS, LAZ, E57, XYZ, TXT, CSV, ASC, PTS, NPY, NPZ, and the
    vertices of OBJ, STL, OFF) become PLY, PCD, LAS, LAZ, XYZ, TXT, CSV, NPY or NPZ.
    CAD models (STEP, IGES, BREP) become each other, 3DM, or GLB, STL, OBJ, PLY
    triangles; they keep their unit.
    """
    is_model = source.suffix.lower() in MODELS_IN
    parameter = next(one for one in context.command.params if one.name == "target")
    check_path(context, parameter, target, MODELS_OUT if is_model else CLOUDS_OUT)
    if is_model:
        from crispline.exchange.models import convert_model

        unit = convert_model(source, target, tolerance)
        click.echo(f"{target}: in {unit}")
        return
    if tolerance is not None:
        raise click.UsageError("--tolerance: expected a CAD model as IN, a cloud has none", context)

    from crispline.cloud.read import read_points
    from crispline.cloud.write import write_points

    cloud = read_points(source)
    write_points(target, cloud)
    dropped = f", {cloud.n_dropped} invalid left out" if cloud.n_dropped else ""
    click.echo(f"{target}: {len(cloud)} points{dropped}")
