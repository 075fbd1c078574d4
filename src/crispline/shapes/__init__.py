"""Shapes known exactly, and simulated scans of them."""

from collections.abc import Callable, Mapping

from crispline.shapes.box_cylinder import box_cylinder, distance_to_box_cylinder
from crispline.shapes.bracket import bracket
from crispline.shapes.sample import SAMPLINGS, Sample, Sampling, sample, write_truth
from crispline.shapes.shape import Shape, ShapeEdge, ShapeFace

SHAPES: Mapping[str, Callable[[], Shape]] = {"box-cylinder": box_cylinder, "bracket": bracket}

__all__ = [
    "SAMPLINGS",
    "SHAPES",
    "Sample",
    "Sampling",
    "Shape",
    "ShapeEdge",
    "ShapeFace",
    "box_cylinder",
    "bracket",
    "distance_to_box_cylinder",
    "sample",
    "write_truth",
]
