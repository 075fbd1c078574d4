"""Scan a part of the benchmark.

    python benchmarks/parts_scan.py PART TRUTH.npz [--points 50000] [--noise 0.001] [--seed 0]
        [--cloud CLOUD.npy] [--step PART.step]

TRUTH.npz holds the noisy points and what is known of them, CLOUD only the points.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from crispline.cadfile.step import write_step
from crispline.cloud.write import write_points
from parts.catalogue import PARTS
from parts.scan import scan
from parts.truth import write_truth


def main() -> None:
    """Scan one part."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--points", type=int, default=50_000)
    parser.add_argument("--noise", type=float, default=0.001, help="over the diagonal")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cloud", type=Path, help="also write the points alone")
    parser.add_argument("--step", type=Path, help="also write the part itself")
    arguments = parser.parse_args()
    shape = PARTS[arguments.part]()
    truth, area = scan(shape, arguments.points, arguments.noise, arguments.seed)
    write_truth(arguments.truth, truth, area)
    if arguments.cloud:
        write_points(arguments.cloud, truth.points)
    if arguments.step:
        write_step(shape, arguments.step)


if __name__ == "__main__":
    main()
