"""Commands on surfaces: sharpen."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from crispline.cli import messages
from crispline.cli.options import sharpen_options
from crispline.cli.parameters import output_option
from crispline.cli.program import program

if TYPE_CHECKING:
    from crispline.options import SharpenOptions

# The suffixes of crispline.exchange.write, repeated so that --help is instant.
SURFACES_OUT = (".step", ".stp", ".iges", ".igs", ".json", ".npz", ".ply", ".obj")


@program.command(epilog="Example: crispline sharpen scan.npy -o sharp.step --rule paper")
@click.argument("surface", type=click.Path(path_type=Path))
@output_option(
    "-o",
    "--output",
    suffixes=SURFACES_OUT,
    required=True,
    text="STEP, IGES, JSON of geomdl or NPZ; PLY or OBJ for triangles.",
)
@output_option(
    "--summary", "summary_path", suffixes=(".json",), text="Also write what was found as JSON."
)
@sharpen_options
def sharpen(
    surface: Path, output: Path, summary_path: Path | None, options: SharpenOptions
) -> None:
    """Make the edges and corners of the B-spline surfaces or the grid SURFACE sharp.

    SURFACE is STEP or IGES with B-spline faces, JSON of geomdl, NPZ, or points in
    rows and columns: NPY of shape (m, n, 3) or PCD with a height.
    """
    from crispline.exchange.read import read_surface_file
    from crispline.files import write_text
    from crispline.grid import sharpen as sharpened
    from crispline.grid.write import write_sharpened

    given = read_surface_file(surface)
    results = [sharpened(one, options) for one in given.surfaces]
    write_sharpened(results, output, given.unit or "mm")
    summaries = [result.summary() for result in results]
    messages.conclude({"surfaces": summaries})
    if summary_path is not None:
        text = json.dumps({"surfaces": summaries}, indent=1, allow_nan=False)
        write_text(summary_path, text + "\n")
    for result in summaries:
        patches = result["patches"]
        click.echo(
            f"{output}: {result['kind']}, edges: {result['n_edges']}, corners: "
            f"{result['n_corners']}; patches: {patches['flat']} flat, {patches['curved']} curved, "
            f"{patches['sharp']} sharp"
        )
    if given.left_out or given.n_trimmed:
        kinds = ", ".join(f"{count} {kind}" for kind, count in given.left_out.items())
        messages.note(
            f"{surface}: left out: {kinds or 'nothing'}; trims ignored: {given.n_trimmed}"
        )
