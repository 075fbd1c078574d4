"""Commands on point clouds: reconstruct, detect."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from crispline.cli import messages
from crispline.cli.options import run_options
from crispline.cli.parameters import (
    cloud_argument,
    mesh_tolerance_option,
    output_option,
    required_tolerance_option,
    units_option,
)
from crispline.cli.program import program
from crispline.errors import ReconstructionError

if TYPE_CHECKING:
    from crispline.cloud.pointcloud import PointCloud
    from crispline.options import Options
    from crispline.result import Reconstruction

# The names of crispline.exchange, repeated so that --help is instant.
MODELS_OUT = (
    *(".brep", ".brp", ".iges", ".igs", ".step", ".stp", ".3dm"),
    *(".glb", ".obj", ".ply", ".stl"),
)
EDGES_OUT = (".dxf", ".json", ".obj", ".step", ".stp")
# What the summary of a failed run holds where nothing is known.
_NOTHING: dict[str, Any] = {
    "valid": False,
    "closed": False,
    "representation": None,
    "n_faces": 0,
    "faces": [],
    "edges": [],
    "corners": [],
    "noise": None,
    "spacing": None,
    "verdict": None,
    "residuals": None,
    "timings": {},
    "warnings": [],
}


@program.command(
    epilog="Example: crispline reconstruct scan.ply -o part.step -o part.glb --units m"
)
@cloud_argument
@output_option(
    "-o",
    "--output",
    "outputs",
    suffixes=(*MODELS_OUT, ".dxf", ".json"),
    required=True,
    multiple=True,
    text="File to write; may be given several times. STEP, IGES, BREP, 3DM; GLB, STL, OBJ, PLY "
    "triangles; DXF, JSON sharp edges.",
)
@output_option(
    "--edges",
    "edges_path",
    suffixes=EDGES_OUT,
    text="Also write the sharp edges: DXF, JSON, OBJ lines, STEP curves.",
)
@output_option(
    "--summary", "summary_path", suffixes=(".json",), text="Also write the summary as JSON."
)
@output_option(
    "--report", "page_path", suffixes=(".html", ".htm"), text="Also write an interactive page."
)
@units_option
@mesh_tolerance_option
@required_tolerance_option
@run_options(has_solid=True)
def reconstruct(
    cloud: Path,
    outputs: tuple[Path, ...],
    edges_path: Path | None,
    summary_path: Path | None,
    page_path: Path | None,
    unit: str,
    mesh_tolerance: float | None,
    tolerance: float | None,
    options: Options,
) -> None:
    """Turn the point cloud CLOUD into a checked CAD model.

    Without a valid model none is written; the summary is written all the same.
    """
    from crispline.cloud.read import read_points

    points = read_points(cloud)  # a bad file is told before the slow imports

    from crispline import pipeline

    result: Reconstruction | None = None
    try:
        with messages.progress() as progress:
            result = pipeline.reconstruct(points, options, progress)
        for output in outputs:
            result.write(output, unit, mesh_tolerance)
        if edges_path is not None:
            result.write_edges(edges_path, unit)
    except ReconstructionError as error:
        known = result or _partial(error)
        _report(known, summary_path, failure=str(error))
        _write_page(page_path, known, points, cloud.name, unit, options, failure=str(error))
        raise
    _report(result, summary_path)
    _write_page(page_path, result, points, cloud.name, unit, options)
    if tolerance is not None:
        result.require(tolerance)


@program.command(epilog="Example: crispline detect scan.ply -o edges.dxf")
@cloud_argument
@output_option(
    "-o",
    "--output",
    suffixes=EDGES_OUT,
    required=True,
    text="DXF, JSON, OBJ with one polyline an edge, or STEP curves.",
)
@units_option
@run_options(has_solid=False)
def detect(
    cloud: Path,
    output: Path,
    unit: str,
    options: Options,
) -> None:
    """Find the sharp edges and corners of the point cloud CLOUD, without a solid."""
    from crispline.cloud.read import read_points

    points = read_points(cloud)  # a bad file is told before the slow imports

    from crispline import pipeline

    try:
        with messages.progress() as progress:
            result = pipeline.detect(points, options, progress)
    except ReconstructionError as error:
        partial = _partial(error)
        if partial is not None:
            _write_edges(partial, output, unit)
        raise
    _write_edges(result, output, unit)


def _partial(error: ReconstructionError) -> Reconstruction | None:
    return cast("Reconstruction | None", error.partial)


def _report(
    result: Reconstruction | None, summary_path: Path | None, failure: str | None = None
) -> None:
    """Show what is known of a run and, if asked, write it as JSON.

    Parameters
    ----------
    result : the run, or what was good when it failed; None if nothing was.
    summary_path : JSON file to write.
    failure : why there is no valid model; None if there is one.
    """
    from crispline.files import write_text
    from crispline.report.summary import render_summary

    summary = dict(result.summary() if result is not None else _NOTHING)
    if failure is not None:
        summary |= {"valid": False, "error": failure}
    messages.conclude(summary)
    if summary_path is not None:
        write_text(summary_path, json.dumps(summary, indent=1, allow_nan=False) + "\n")
    if result is not None:
        messages.tell(render_summary(summary))


def _write_page(
    path: Path | None,
    result: Reconstruction | None,
    points: PointCloud,
    title: str,
    unit: str,
    options: Options,
    failure: str | None = None,
) -> None:
    """Write the page if it is asked for and anything is known."""
    if path is None or result is None:
        return
    from crispline.report.html import write_report

    write_report(
        path, result, points.points, title=title, unit=unit, options=options, failure=failure
    )


def _write_edges(result: Reconstruction, path: Path, unit: str) -> None:
    result.write_edges(path, unit)
    messages.conclude(result.summary())
    n_sharp = sum(edge.is_sharp for edge in result.edges)
    click.echo(f"{path}: sharp edges: {n_sharp}, corners: {len(result.corners)}")
