"""The report as one page that needs no network: text, tables and an interactive view."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from os import PathLike
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

import crispline
from crispline.files import check_output, write_text
from crispline.findings import FaceReport
from crispline.gauge.distance import Deviations
from crispline.options import Options
from crispline.report.buffers import encoded
from crispline.report.content import result_page
from crispline.report.page import Page
from crispline.report.palette import KIND_COLOURS, KINDS, PATCH_COLOURS, RAMP, kind_index
from crispline.report.scene import scene_of_shape
from crispline.report.sections import facts as fact_list
from crispline.report.sections import sections
from crispline.report.threejs import three_js
from crispline.result import Reconstruction
from crispline.surface.base import Array

REPORT_SUFFIXES = (".html", ".htm")
_SCRIPTS = ("data", "camera", "shaders", "layers", "view", "overlay", "table", "main")
_NICE = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0)


def write_report(
    path: str | PathLike[str],
    result: Reconstruction,
    points: Array,
    *,
    title: str = "Reconstruction",
    unit: str = "",
    options: Options | None = None,
    failure: str | None = None,
) -> None:
    """Write what is known of a reconstruction as one page, whole or not at all.

    The page opens from disk and asks no network for anything. It holds at most
    :data:`crispline.report.buffers.MAX_POINTS` of the points; all of them count in
    its numbers. The same input gives the same bytes.

    Parameters
    ----------
    path : file to write, ``.html``.
    result : complete or partial.
    points : the cloud as given, shape ``(n, 3)``.
    title : heading, for example the name of the cloud.
    unit : of lengths, for labels, for example ``mm``.
    options : those used, to be listed.
    failure : why there is no valid model; None if there is one.

    Raises
    ------
    InputError
        Another suffix, or the file cannot be written.
    """
    page = result_page(result, points, title=title, unit=unit, options=options, failure=failure)
    write_page(path, page)


def write_comparison_report(
    path: str | PathLike[str],
    shape: Any,
    points: Array,
    found: Deviations,
    faces: Sequence[FaceReport],
    *,
    spacing: float,
    verdict: str,
    is_good: bool = True,
    facts: Mapping[str, str] | None = None,
    noise: float = math.nan,
    title: str = "Comparison",
    unit: str = "",
    warnings: Sequence[str] = (),
) -> None:
    """Write how a cloud deviates from any shape as one page, as :func:`write_report` does.

    Parameters
    ----------
    path : file to write, ``.html``.
    shape : any ``TopoDS_Shape`` with faces.
    points : the cloud in the unit of the shape, shape ``(n, 3)``.
    found : deviations of the points from the shape.
    faces : a row per face of the shape, in exploration order.
    spacing : mean distance between neighbouring points.
    verdict, is_good : one sentence, and whether it is a good one.
    facts : name and value of what is shown below the verdict.
    noise : standard deviation of the points along the normal, if known.
    title, unit : heading and the unit of lengths, for labels.
    warnings : sentences.

    Raises
    ------
    InputError
        Another suffix, or the file cannot be written.
    """
    page = Page(
        title=title,
        verdict=verdict,
        is_good=is_good,
        facts=tuple((facts or {}).items()),
        faces=tuple(faces),
        scene=scene_of_shape(shape, points, found, spacing),
        spacing=spacing,
        noise=noise,
        unit=unit,
        warnings=tuple(warnings),
        edges="Edges",
    )
    write_page(path, page)


def write_page(path: str | PathLike[str], page: Page) -> None:
    """Write a report, whole or not at all. Raises `InputError` if it cannot be written."""
    path = Path(path)
    check_output(path, REPORT_SUFFIXES)
    write_text(path, render_page(page))


def render_page(page: Page) -> str:
    """The text of the page."""
    limit = colour_range(page)
    values = {
        "version": crispline.__version__,
        "title": escape(page.title),
        "verdict": escape(page.verdict),
        "mood": "good" if page.is_good else "bad",
        "edges": escape(page.edges),
        "facts": fact_list(page.facts),
        "sections": sections(page, limit),
        "style": _asset("page.css"),
        "library": three_js(),
        "data": _json(_data(page, limit)),
        "script": "(() => {\n'use strict';\n"
        + "\n".join(_asset(f"{name}.js") for name in _SCRIPTS)
        + "})();\n",
    }
    return Template(_asset("page.html")).substitute(values)


def colour_range(page: Page) -> float:
    """Largest deviation of the colour bar: three sigma of the noise or more, a round number.

    Without a known noise it is where 99 % of the deviations lie.
    """
    known = np.abs(page.scene.cloud.deviations)
    known = known[np.isfinite(known)]
    wanted = 3.0 * page.noise if math.isfinite(page.noise) else 0.0
    if wanted <= 0.0 and len(known):
        wanted = float(np.quantile(known, 0.99))
    return _rounded_up(max(wanted, 1e-3 * page.spacing))


def _rounded_up(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(step for step in _NICE if step * power >= value * (1.0 - 1e-9)) * power


def _data(page: Page, limit: float) -> dict[str, Any]:
    """What the script needs."""
    return {
        **encoded(page.scene),
        "spacing": page.spacing,
        "limit": limit,
        "unit": page.unit,
        "kinds": KINDS,
        "kind_colours": KIND_COLOURS,
        "patch_colours": PATCH_COLOURS,
        "ramp": RAMP,
        "face_kinds": [kind_index(face.kind) for face in page.faces],
    }


def _json(data: Mapping[str, Any]) -> str:
    # "</script>" or "<!--" in a text would upset the element around it.
    return json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")


def _asset(name: str) -> str:
    return files("crispline.report").joinpath("assets", name).read_text(encoding="utf-8")
