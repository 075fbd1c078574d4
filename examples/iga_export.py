"""Untrimmed B-spline patches for isogeometric analysis, with the edges that they share.

python examples/iga_export.py [FOLDER]

Writes `patches.json` (surfaces as geomdl reads them) and `edges.json` (which side of which
patch meets which), and integrates over the patches as an analysis would.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np

import crispline
from crispline.exchange import write_surfaces
from crispline.shapes import SHAPES, sample
from crispline.spline.quilt import EdgeSide, quilt
from crispline.spline.tensor import TensorSpline


def main(folder: Path, n_points: int = 6000) -> tuple[float, float]:
    """Export the patches of a reconstruction; returns their area and volume."""
    scan = sample(SHAPES["box-cylinder"](), n_points, noise=0.01, seed=1)
    part = crispline.reconstruct(scan.points)

    # `patches` is a creased net of quads; `quilt` covers it with bicubic B-splines whose
    # borders are iso-parameter lines of both neighbours, over the same parameter.
    cover = quilt(part.patches)
    patches = [
        TensorSpline(3, 3, face.knots_u, face.knots_v, face.control_points) for face in cover.faces
    ]
    write_surfaces(folder / "patches.json", patches)
    edges = [
        {
            "is_sharp": edge.is_sharp,
            "sides": [_side(side) for side in (edge.left, edge.right) if side is not None],
        }
        for edge in cover.edges
    ]
    (folder / "edges.json").write_text(json.dumps(edges, indent=1) + "\n", encoding="utf-8")

    area, volume = np.sum([_integrals(patch) for patch in patches], axis=0)
    print(f"{len(patches)} patches, {len(edges)} edges, watertight: {cover.is_closed}")
    print(f"area {area:.1f}, volume {volume:.1f}")
    return float(area), float(volume)


def _side(side: EdgeSide) -> dict[str, object]:
    """The straight line that an edge is in the parameter plane of a patch."""
    return {"patch": side.face, "start": list(side.start), "end": list(side.end)}


def _integrals(patch: TensorSpline) -> tuple[float, float]:
    """Area, and volume between patch and origin, by Gauss's rule on every knot span."""
    u, weight_u = _gauss(patch.knots_u)
    v, weight_v = _gauss(patch.knots_v)
    place = np.repeat(u, len(v)), np.tile(v, len(u))
    weight = np.outer(weight_u, weight_v).ravel()
    points = patch.evaluate(*place)
    normal = np.cross(patch.evaluate(*place, du=1), patch.evaluate(*place, dv=1))
    area = weight @ np.linalg.norm(normal, axis=1)
    return float(area), float(weight @ np.einsum("ij,ij->i", points, normal) / 3.0)


def _gauss(knots: np.ndarray, n: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Places and weights of Gauss's rule on the spans between distinct knots."""
    ends = np.unique(knots)
    place, weight = np.polynomial.legendre.leggauss(n)
    middle, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * np.diff(ends)
    return (middle[:, None] + np.outer(half, place)).ravel(), np.outer(half, weight).ravel()


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
