"""The command that tells what a cloud is like."""

from __future__ import annotations

import json
from pathlib import Path

from crispline.cli import messages
from crispline.cli.parameters import cloud_argument, output_option, threads_option
from crispline.cli.program import program


@program.command(epilog="Example: crispline inspect scan.ply --json scan.json")
@cloud_argument
@output_option("--json", "json_path", suffixes=(".json",), text="Also write the numbers as JSON.")
@threads_option
def inspect(cloud: Path, json_path: Path | None, threads: int) -> None:
    """Tell what the point cloud CLOUD is like before anything is made of it.

    Counts, extent, a guess at the unit, spacing, noise, density, outliers, rims,
    thin walls, which features are too small for this spacing, and what
    `reconstruct` will take. Lengths are in the unit of the cloud.
    """
    from crispline.cloud.read import read_points

    points = read_points(cloud)  # a bad file is told before the slow imports

    from crispline.cloud.inspection import inspect as inspected
    from crispline.files import write_text
    from crispline.report.inspect import inspection_summary, render_inspection

    found = inspected(points, threads=threads or -1)
    if json_path is not None:
        content = json.dumps(inspection_summary(found), indent=1, allow_nan=False)
        write_text(json_path, content + "\n")
    messages.tell(render_inspection(found))
