"""The command that measures a cloud against a CAD model."""

from __future__ import annotations

import json
from pathlib import Path

import click

from crispline.cli import messages
from crispline.cli.parameters import UNITS, cloud_argument, output_option
from crispline.cli.program import program


@program.command(epilog="Example: crispline compare part.step scan.ply --tolerance 0.1")
@click.argument("model", type=click.Path(path_type=Path))
@cloud_argument
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Largest deviation allowed, in the unit of MODEL: exit 3 unless 95 % of the points of "
    "every face lie within it (faces of at least 20 points).",
)
@click.option(
    "--units",
    "unit",
    type=click.Choice(UNITS),
    help="What the numbers of the cloud are.  [default: the unit of MODEL]",
)
@output_option("--json", "json_path", suffixes=(".json",), text="Also write the numbers as JSON.")
@output_option(
    "--report", "page_path", suffixes=(".html", ".htm"), text="Also write an interactive page."
)
def compare(
    model: Path,
    cloud: Path,
    tolerance: float | None,
    unit: str | None,
    json_path: Path | None,
    page_path: Path | None,
) -> None:
    """Measure every point of CLOUD against the CAD model MODEL.

    MODEL is any STEP, IGES or BREP file with faces; the cloud must lie in its
    frame. All points count, outliers too. Deviations are positive outside. The
    numbers are in the unit of the model.
    """
    from crispline.cloud.read import read_points

    points = read_points(cloud).points  # a bad file is told before the slow imports

    from crispline.cadfile.shape_files import read_shape
    from crispline.cadfile.units import MILLIMETRES
    from crispline.errors import ReconstructionError
    from crispline.files import write_text
    from crispline.gauge.comparison import compare as compared
    from crispline.report.compare import (
        comparison_summary,
        render_comparison,
        write_comparison_page,
    )

    given = read_shape(model)
    if unit is not None:
        points = points * (MILLIMETRES[unit] / MILLIMETRES[given.unit])
    found = compared(given.shape, points, tolerance)
    if json_path is not None:
        content = comparison_summary(found, given.unit)
        write_text(json_path, json.dumps(content, indent=1, allow_nan=False) + "\n")
    if page_path is not None:
        title = f"{model.name} and {cloud.name}"
        write_comparison_page(page_path, found, given.shape, points, title=title, unit=given.unit)
    messages.tell(render_comparison(found, given.unit))
    if found.is_within is False:
        raise ReconstructionError(
            f"'{cloud}' misses the tolerance of {tolerance:g} {given.unit} to '{model}': "
            f"{found.verdict}"
        )
