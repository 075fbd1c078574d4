"""The command line. Whatever is slow to import is imported by the command that needs it."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import click

from crispline.errors import CrisplineError, InputError, ReconstructionError
from crispline.files import check_output

if TYPE_CHECKING:
    from crispline.result import Reconstruction

_STEP = (".step", ".stp")
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
# The names of crispline.shapes and crispline.report.edges, repeated so that --help is instant.
_SHAPES = ("box-cylinder", "bracket")
_SAMPLINGS = ("grid", "half-cell", "random")
_CLOUDS_OUT = (".ply", ".xyz", ".npy")
_EDGES_OUT = (".json", ".obj")
_SURFACES_OUT = (".step", ".stp", ".iges", ".igs", ".json", ".npz", ".ply", ".obj")


class _Program(click.Group):
    """Turns the errors of the catalogue into one sentence and their exit code."""

    def invoke(self, context: click.Context) -> Any:
        try:
            return super().invoke(context)
        except CrisplineError as error:
            click.echo(f"Error: {error}", err=True)
            context.exit(error.exit_code)


def _output_option(
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


def _fraction(context: click.Context, parameter: click.Parameter, text: str) -> float:
    """Read a fraction of 0 or more, given as a number (0.02) or in per cent (2%)."""
    try:
        fraction = _as_fraction(text)
    except ValueError:
        fraction = math.nan
    if not 0.0 <= fraction < math.inf:
        raise click.BadParameter(
            f"expected a number of 0 or more such as 0.02 or 2%, got '{text}'", context, parameter
        )
    return fraction


def _as_fraction(text: str) -> float:
    return float(text.removesuffix("%")) / (100.0 if text.endswith("%") else 1.0)


def _listed(
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


_cloud = click.argument("cloud", type=click.Path(path_type=Path))
_seed = click.option(
    "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Random seed."
)
_threads = click.option(
    "--threads",
    type=click.IntRange(min=0),
    default=0,
    show_default="all cores",
    help="Threads to use; the result is the same.",
)


@click.group(cls=_Program, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="crispline")
def main() -> None:
    """Noisy point clouds to CAD solids with sharp edges and corners.

    Exit codes: 0 done, 2 bad usage or bad input, 3 no valid model could be made.
    """


@main.command()
@_cloud
@_output_option("-o", "--output", suffixes=_STEP, required=True, text="STEP file to write.")
@_output_option(
    "--summary", "summary_path", suffixes=(".json",), text="Also write the summary as JSON."
)
@_seed
@_threads
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


@main.command()
@_cloud
@_output_option(
    "-o",
    "--output",
    suffixes=_EDGES_OUT,
    required=True,
    text="JSON, or OBJ with one polyline an edge.",
)
@_seed
@_threads
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


@main.command()
@click.argument("shape", type=click.Choice(_SHAPES))
@click.option(
    "--points",
    "n_points",
    type=click.IntRange(min=1),
    default=34000,
    show_default=True,
    help="Points on the shape; the grids come close to it.",
)
@click.option(
    "--noise",
    callback=_fraction,
    default="0",
    show_default=True,
    metavar="LEVEL",
    help="Every point moves by LEVEL times an eighth of the model's length (0.02 or 2%).",
)
@click.option(
    "--sampling",
    type=click.Choice(_SAMPLINGS),
    default="random",
    show_default=True,
    help="Rows of points on the edges, edges midway between rows, or uniform by area.",
)
@click.option(
    "--outliers",
    callback=_fraction,
    default="0",
    show_default=True,
    metavar="F",
    help="Further stray points, as a fraction of the points.",
)
@_seed
@_output_option("-o", "--output", suffixes=_CLOUDS_OUT, required=True, text="Cloud to write.")
@_output_option(
    "--truth", suffixes=(".npz",), text="Also write clean points, normals, faces, edges."
)
def sample(
    shape: str,
    n_points: int,
    noise: float,
    sampling: Any,
    outliers: float,
    seed: int,
    output: Path,
    truth: Path | None,
) -> None:
    """Simulate a scan of SHAPE, whose edges are known exactly."""
    from crispline.cloud.write import write_points
    from crispline.shapes import SHAPES, sample, write_truth

    scan = sample(
        SHAPES[shape](), n_points, sampling=sampling, noise=noise, outliers=outliers, seed=seed
    )
    write_points(output, scan.points)
    if truth is not None:
        write_truth(truth, scan)
    click.echo(f"{output}: {len(scan.points)} points, spacing {scan.spacing:.4g}")


@main.command()
@_output_option("--json", "json_path", suffixes=(".json",), text="Write the rows as JSON.")
@_output_option("--markdown", "markdown_path", suffixes=(".md",), text="Write the tables.")
@click.option(
    "--methods",
    callback=_listed(str, "names of methods separated by commas such as paper,robust"),
    default="published,paper,robust,pipeline",
    show_default=True,
    help="The published numbers, the two rules on grids, the reconstruction of whole clouds.",
)
@click.option(
    "--noise",
    callback=_listed(_as_fraction, "fractions separated by commas such as 0,0.5%,0.02"),
    default="0,0.5%,1%,2%,5%,10%",
    show_default=True,
    help="Steps of the points, over an eighth of the model's length.",
)
@click.option(
    "--phases",
    callback=_listed(float, "numbers from 0 to 0.5 separated by commas such as 0,0.25,0.5"),
    default="0,0.125,0.25,0.375,0.5",
    show_default=True,
    help="Positions of the edges between two rows of a grid.",
)
@click.option(
    "--seeds", type=click.IntRange(min=1), default=10, show_default=True, help="Seeds on grids."
)
@click.option(
    "--pipeline-seeds",
    type=click.IntRange(min=1),
    default=3,
    show_default=True,
    help="Seeds on whole clouds, at most as many as on grids; a run takes half a minute.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=0),
    default=0,
    show_default="all cores",
    help="Processes to use; the result is the same.",
)
def paper(
    json_path: Path | None,
    markdown_path: Path | None,
    methods: tuple[Any, ...],
    noise: tuple[float, ...],
    phases: tuple[float, ...],
    seeds: int,
    pipeline_seeds: int,
    jobs: int,
) -> None:
    """Run the paper's experiment: feature errors before and after, by method.

    Without a file to write, the tables go to the terminal.
    """
    from rich.console import Console

    from crispline.files import write_text
    from crispline.paper.experiment import Plan, run
    from crispline.paper.table import to_json, to_markdown
    from crispline.report.progress import show_progress

    plan = Plan(methods, phases, noise, seeds, min(seeds, pipeline_seeds))
    with show_progress(Console(stderr=True)) as progress:
        rows = run(plan, n_jobs=jobs or os.cpu_count() or 1, progress=progress)
    if json_path is not None:
        write_text(json_path, to_json(rows))
    if markdown_path is not None:
        write_text(markdown_path, to_markdown(rows))
    if json_path is None and markdown_path is None:
        click.echo(to_markdown(rows), nl=False)


@main.command()
@click.argument("surface", type=click.Path(path_type=Path))
@_output_option(
    "-o",
    "--output",
    suffixes=_SURFACES_OUT,
    required=True,
    text="STEP, IGES, JSON of geomdl or NPZ; PLY or OBJ for triangles.",
)
@click.option(
    "--eps",
    type=click.FloatRange(min=0.0, min_open=True),
    help="Patches of this mean curvature are curved, in 1/spacing.  [default: from the noise; "
    "0.25 with the paper's rule]",
)
@click.option(
    "--rule",
    type=click.Choice(("robust", "paper")),
    default="robust",
    show_default=True,
    help="The paper's rules to the letter, or those that find and locate every edge.",
)
@click.option(
    "--repeat",
    type=click.IntRange(1, 3),
    default=3,
    show_default=True,
    help="How often located points enter; 3 makes edges sharp.",
)
@_output_option(
    "--summary", "summary_path", suffixes=(".json",), text="Also write what was found as JSON."
)
def sharpen(
    surface: Path,
    output: Path,
    eps: float | None,
    rule: Any,
    repeat: int,
    summary_path: Path | None,
) -> None:
    """Make the edges and corners of the B-spline surfaces or the grid SURFACE sharp.

    SURFACE is STEP or IGES with B-spline faces, JSON of geomdl, NPZ, or points in
    rows and columns: NPY of shape (m, n, 3) or PCD with a height.
    """
    from crispline.exchange.read import read_surface_file
    from crispline.files import write_text
    from crispline.grid import sharpen as sharpened
    from crispline.grid.write import write_sharpened
    from crispline.options import SharpenOptions

    given = read_surface_file(surface)
    options = SharpenOptions(rule=rule, eps=eps, repeat=repeat)
    results = [sharpened(one, options) for one in given.surfaces]
    write_sharpened(results, output, given.unit or "mm")
    summaries = [result.summary() for result in results]
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
        click.echo(
            f"{surface}: left out: {kinds or 'nothing'}; trims ignored: {given.n_trimmed}", err=True
        )


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
