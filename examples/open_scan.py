"""A scan without its underside: a shell with a free border, not a solid.

python examples/open_scan.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import crispline
from crispline.options import NetOptions
from crispline.shapes import SHAPES, sample


def main(folder: Path, n_points: int = 6000) -> crispline.Reconstruction:
    """Reconstruct the box with cylinder as seen from above; returns the shell."""
    scan = sample(SHAPES["box-cylinder"](), n_points, noise=0.01, seed=1)
    lowest = scan.points[:, 2].min()
    seen = scan.points[scan.points[:, 2] > lowest + scan.spacing]

    # By default the gaps decide; here it is known that the scan is open.
    options = crispline.Options(net=NetOptions(surface="open"))
    shell = crispline.reconstruct(seen, options)
    shell.write(folder / "shell.step")
    print(f"valid: {shell.valid}, closed: {shell.closed}, faces: {len(shell.faces)}")
    for warning in shell.warnings:
        print("warning:", warning)
    return shell


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
