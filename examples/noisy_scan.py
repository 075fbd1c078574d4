"""A scan with much noise and many strays: what is found, and how far it is from the truth.

python examples/noisy_scan.py [FOLDER]
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

import crispline
from crispline.curve import resampled
from crispline.shapes import SHAPES, sample


def main(folder: Path, n_points: int = 8000) -> float:
    """Reconstruct a simulated scan; returns how far the edges are off, in spacings."""
    scan = sample(SHAPES["bracket"](), n_points, noise=0.03, outliers=0.05, seed=2)
    part = crispline.reconstruct(scan.points)
    part.write(folder / "noisy.step")
    for warning in part.warnings:
        print("warning:", warning)
    print(part.verdict)

    found = np.concatenate([edge.points for edge in part.edges if edge.is_sharp])
    truth = cKDTree(np.concatenate([resampled(e.points, 5000) for e in scan.shape.edges]))
    off = float(np.median(truth.query(found)[0])) / part.spacing
    noise = part.noise / part.spacing
    print(f"noise: {noise:.2f} spacings; edges are off by {off:.3f} spacings (median)")
    return off


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
