"""Commands on point clouds: reconstruct, detect."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from crispline.cli.parameters import cloud_argument, output_option, seed_option, threads_option
from crispline.cli.program import program
from crispline.errors import ReconstructionError

if TYPE_CHECKING:
    from crispline.result import Reconstruction

_STEP = (".step", ".stp")
# The name of crispline.report.edges, repeated so that --help is instant.
EDGES_OUT = (".json", ".obj")
# What the summary of a failed run holds where nothing is known.
_NOTHING: dict[str, Any] = {
    "valid": False,
    "closed": False,
    "n_faces": 0,
    "faces": [],
    "edges": [],
    "corners": [],
    "noise": None,
    "spacing": None,
    "timings": {},
    "warnings": [],
}


@program.command()
@cloud_argument
@output_option("-o", "--output", suffixes=_STEP, required=True, text="STEP file to write.")
@output_option(
    "--summary", "summary_path", suffixes=(".json",), text="Also write the summary as JSON."
)
@seed_option
@threads_option
def reconstruct(
    cloud: Path, output: Path, summary_path: Path | None, seed: int, threads: int
) -> None:
    """Turn the point cloud CLOUD into a checked STEP model.

    Without a valid model nothing is written to the STEP file; the summary is
    written all the same.
    """
    from crispline.cloud.read import read_points

    points = read_points(cloud)  # a bad file is told before the slow imports

    from rich.console import Console

    from crispline import pipeline
    from crispline.options import Options
    from crispline.report.progress import show_progress

    result: Reconstruction | None = None
    try:
        with show_progress(Console(stderr=True)) as progress:
            result = pipeline.reconstruct(points, Options(seed=seed, threads=threads), progress)
        result.write(output)
    except ReconstructionError as error:
        _report(result or _partial(error), summary_path, failure=str(error))
        raise
    _report(result, summary_path)


@program.command()
@cloud_argument
@output_option(
    "-o",
    "--output",
    suffixes=EDGES_OUT,
    required=True,
    text="JSON, or OBJ with one polyline an edge.",
)
@seed_option
@threads_option
def detect(cloud: Path, output: Path, seed: int, threads: int) -> None:
    """Find the sharp edges and corners of the point cloud CLOUD, without a solid."""
    from crispline.cloud.read import read_points

    points = read_points(cloud)  # a bad file is told before the slow imports

    from rich.console import Console

    from crispline import pipeline
    from crispline.options import Options
    from crispline.report.progress import show_progress

    try:
        with show_progress(Console(stderr=True)) as progress:
            result = pipeline.detect(points, Options(seed=seed, threads=threads), progress)
    except ReconstructionError as error:
        partial = _partial(error)
        if partial is not None:
            _write_edges(partial, output)
        raise
    _write_edges(result, output)


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
    from rich.console import Console

    from crispline.files import write_text
    from crispline.report.summary import render_summary

    summary = dict(result.summary() if result is not None else _NOTHING)
    if failure is not None:
        summary |= {"valid": False, "error": failure}
    if summary_path is not None:
        write_text(summary_path, json.dumps(summary, indent=1, allow_nan=False) + "\n")
    if result is not None:
        Console().print(render_summary(summary))


def _write_edges(result: Reconstruction, path: Path) -> None:
    from crispline.report.edges import write_edges

    sharp = [edge for edge in result.edges if edge.is_sharp]
    write_edges(path, sharp, result.corners, spacing=result.spacing, noise=result.noise)
    click.echo(f"{path}: sharp edges: {len(sharp)}, corners: {len(result.corners)}")
