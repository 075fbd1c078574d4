"""What a report says, as values; :mod:`crispline.report.html` makes the page of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from typing import Any

from crispline.findings import FaceReport
from crispline.report.scene import Scene


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes
    ----------
    title : what was measured, for example the name of the file.
    verdict : one sentence.
    is_good : whether the verdict is a good one.
    facts : name and value of what matters most, in the order shown.
    faces : the face table; ``Scene`` counts its rows.
    scene : the picture.
    spacing : mean distance between neighbouring points.
    noise : standard deviation of the points along the normal; NaN if unknown.
    unit : of lengths, for labels; empty if unknown.
    warnings : sentences; one that names a place with ``near (x, y, z)``
        gets a picture of it.
    timings : seconds per stage.
    options : name and value of every option used.
    edges : what the edges of the scene are called.
    """

    title: str
    verdict: str
    is_good: bool
    facts: tuple[tuple[str, str], ...]
    faces: tuple[FaceReport, ...]
    scene: Scene
    spacing: float
    noise: float
    unit: str = ""
    warnings: tuple[str, ...] = ()
    timings: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, str] = field(default_factory=dict)
    edges: str = "Sharp edges"


def option_rows(options: Any) -> dict[str, str]:
    """Every value in nested dataclasses by its dotted name.

    >>> from crispline.options import Options
    >>> option_rows(Options())["cloud.outlier_factor"]
    '2.0'
    """
    return dict(_walk("", options))


def _walk(prefix: str, options: Any) -> Iterator[tuple[str, str]]:
    for each in fields(options):
        value, name = getattr(options, each.name), f"{prefix}{each.name}"
        if is_dataclass(value):
            yield from _walk(f"{name}.", value)
        else:
            yield name, str(value)
