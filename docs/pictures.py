"""Draw the pictures of the documentation from the bundled scan.

python docs/pictures.py
"""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

import crispline
from crispline.report import figures
from crispline.surface.base import Array

HERE = Path(__file__).parent
DPI = 110
TRIPTYCH = ("cloud", "sharp-patches", "model")


def main() -> None:
    """Write `images/stage-*.png` and, of three of them, `images/bracket.png`."""
    points = crispline.read_points(HERE.parent / "examples" / "bracket.ply").points
    part = crispline.reconstruct(points)
    drawn = {name: image_of(figure) for name, figure in stages(part, points).items()}
    for name, image in drawn.items():
        write(image, f"stage-{name}.png")
    width, height = drawn["cloud"].size
    joined = Image.new("RGB", (len(TRIPTYCH) * width, height), "white")
    for number, name in enumerate(TRIPTYCH):
        joined.paste(drawn[name], (number * width, 0))
    write(joined, "bracket.png")


def stages(part: crispline.Reconstruction, points: Array) -> dict[str, Figure]:
    """A figure of every stage, by its name."""
    low, high = part.model.vertices.min(axis=0), part.model.vertices.max(axis=0)
    margin = 0.1 * (high - low)
    is_near = ((points > low - margin) & (points < high + margin)).all(axis=1)
    scan = np.asarray(points[is_near])
    return {
        "cloud": figures.cloud(replace(part, solid=None), scan),
        "curvature": figures.curvature(part),
        "patches": figures.patches(part, is_sharp=False),
        "regions": figures.regions(part),
        "sharp-patches": figures.patches(part),
        "model": figures.model(part),
        "deviation": figures.cloud(part, scan),
    }


def image_of(figure: Figure) -> Image.Image:
    """The figure in pixels."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=DPI)
    return Image.open(content).convert("RGB")


def write(image: Image.Image, name: str) -> None:
    """Write a picture with few colours, which is small."""
    image.quantize(256, dither=Image.Dither.NONE).save(HERE / "images" / name, optimize=True)


if __name__ == "__main__":
    main()
