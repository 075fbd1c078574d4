"""Commands on shapes that are known exactly: sample, paper."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import click

from crispline.cli import messages
from crispline.cli.parameters import (
    as_fraction,
    listed,
    output_option,
    read_fraction,
    seed_option,
)
from crispline.cli.program import program

# The names of crispline.shapes and crispline.cloud.write, repeated so that --help is instant.
SHAPES = ("box-cylinder", "bracket")
SAMPLINGS = ("grid", "half-cell", "random")
CLOUDS_OUT = (".csv", ".las", ".laz", ".npy", ".npz", ".pcd", ".ply", ".txt", ".xyz")


@program.command(
    epilog="Example: crispline sample box-cylinder --points 34000 --noise 2% -o cloud.ply"
)
@click.argument("shape", type=click.Choice(SHAPES))
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
    callback=read_fraction,
    default="0",
    show_default=True,
    metavar="LEVEL",
    help="Every point moves by LEVEL times an eighth of the model's length (0.02 or 2%).",
)
@click.option(
    "--sampling",
    type=click.Choice(SAMPLINGS),
    default="random",
    show_default=True,
    help="Rows of points on the edges, edges midway between rows, or uniform by area.",
)
@click.option(
    "--outliers",
    callback=read_fraction,
    default="0",
    show_default=True,
    metavar="F",
    help="Further stray points, as a fraction of the points.",
)
@seed_option
@output_option("-o", "--output", suffixes=CLOUDS_OUT, required=True, text="Cloud to write.")
@output_option(
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
    # PLY as scanners write it.
    is_single = output.suffix.lower() == ".ply"
    write_points(output, scan.points.astype("f4") if is_single else scan.points)
    if truth is not None:
        write_truth(truth, scan)
    click.echo(f"{output}: {len(scan.points)} points, spacing {scan.spacing:.4g}")


@program.command(epilog="Example: crispline paper --methods paper,robust --seeds 2 --json out.json")
@output_option("--json", "json_path", suffixes=(".json",), text="Write the rows as JSON.")
@output_option("--markdown", "markdown_path", suffixes=(".md",), text="Write the tables.")
@click.option(
    "--methods",
    callback=listed(str, "names of methods separated by commas such as paper,robust"),
    default="published,paper,robust,pipeline",
    show_default=True,
    help="The published numbers, the two rules on grids, the reconstruction of whole clouds.",
)
@click.option(
    "--noise",
    callback=listed(as_fraction, "fractions separated by commas such as 0,0.5%,0.02"),
    default="0,0.5%,1%,2%,5%,10%",
    show_default=True,
    help="Steps of the points, over an eighth of the model's length.",
)
@click.option(
    "--phases",
    callback=listed(float, "numbers from 0 to 0.5 separated by commas such as 0,0.25,0.5"),
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
    from crispline.files import write_text
    from crispline.paper.experiment import Plan, run
    from crispline.paper.table import to_json, to_markdown

    plan = Plan(methods, phases, noise, seeds, min(seeds, pipeline_seeds))
    with messages.progress() as progress:
        rows = run(plan, n_jobs=jobs or os.cpu_count() or 1, progress=progress)
    if json_path is not None:
        write_text(json_path, to_json(rows))
    if markdown_path is not None:
        write_text(markdown_path, to_markdown(rows))
    if json_path is None and markdown_path is None:
        click.echo(to_markdown(rows), nl=False)
