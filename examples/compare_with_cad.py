"""Metrology: a second scan of a part against the CAD model made from the first.

python examples/compare_with_cad.py [FOLDER]

Any STEP, IGES or BREP file does in place of the model.
"""

from __future__ import annotations

import sys
from pathlib import Path

import crispline
from crispline.cadfile.shape_files import read_shape
from crispline.gauge.comparison import Comparison, compare
from crispline.report.compare import write_comparison_page
from crispline.shapes import SHAPES, sample


def main(folder: Path, n_points: int = 6000) -> Comparison:
    """Make a model, read it back, and measure another scan against it."""
    first, second = (
        sample(SHAPES["box-cylinder"](), n_points, noise=0.01, seed=seed) for seed in (1, 2)
    )
    crispline.reconstruct(first.points).write(folder / "part.step", unit="mm")

    model = read_shape(folder / "part.step")
    found = compare(model.shape, second.points, tolerance=0.5)
    for index, face in enumerate(found.faces):
        known = face.residuals
        print(
            f"{index:2} {face.kind:9} {known.n_points:5} points, p95 {known.p95:.3f} {model.unit}"
        )
    print(found.verdict)
    write_comparison_page(
        folder / "compare.html", found, model.shape, second.points, title="part", unit=model.unit
    )
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
