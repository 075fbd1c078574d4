"""A comparison of a model with a cloud as JSON, as tables on a terminal, and as a page."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from crispline.gauge.certificate import Residuals
from crispline.gauge.comparison import Comparison
from crispline.report.summary import number
from crispline.surface.base import Array

_BINS_A_BAR = 3
_BAR = 40


def comparison_summary(comparison: Comparison, unit: str) -> dict[str, Any]:
    """Everything but the single points in JSON-ready form; unknown numbers are None."""
    faces = [
        {
            "kind": face.kind,
            "parameters": dict(face.parameters),
            "area": face.area,
            **_residuals(face.residuals),
        }
        for face in comparison.faces
    ]
    return {
        "unit": unit,
        "verdict": comparison.verdict,
        "tolerance": comparison.tolerance,
        "is_within_tolerance": comparison.is_within,
        "spacing": _known(comparison.spacing),
        "noise": _known(comparison.noise),
        "limit": _known(comparison.limit),
        "overall": _residuals(comparison.whole),
        "worst_face": comparison.worst_face,
        "faces": faces,
        "histogram": {
            "edges": comparison.bin_edges.tolist(),
            "counts": comparison.counts.tolist(),
        },
        "warnings": list(comparison.warnings),
    }


def render_comparison(comparison: Comparison, unit: str) -> RenderableType:
    """Lay out a comparison for a terminal."""
    style = "bold" if comparison.is_within is None else "bold green"
    whole = comparison.whole
    blocks: list[RenderableType] = [
        Text(comparison.verdict, style="bold red" if comparison.is_within is False else style),
        Text(
            f"{whole.n_points} points in {unit}: rms {number(whole.rms, 4)}, p95 "
            f"{number(whole.p95, 4)}, max {number(whole.max, 4)}, mean {whole.mean:+.4g}; spacing "
            f"{number(_known(comparison.spacing), 4)}, noise {number(_known(comparison.noise))}"
        ),
        _face_table(comparison),
        _histogram(comparison),
    ]
    blocks += [Text(f"warning: {warning}", style="yellow") for warning in comparison.warnings]
    return Group(*blocks)


def write_comparison_page(
    path: str | PathLike[str],
    comparison: Comparison,
    shape: Any,
    points: Array,
    *,
    title: str,
    unit: str,
) -> None:
    """Write a comparison as one interactive page; see :mod:`crispline.report.html`."""
    from crispline.findings import FaceReport
    from crispline.report.html import write_comparison_report

    rows = [
        FaceReport(face.kind, face.parameters, face.area, **vars(face.residuals))
        for face in comparison.faces
    ]
    whole = comparison.whole
    facts: Mapping[str, str] = {
        "points": str(whole.n_points),
        "faces": str(len(rows)),
        "rms": f"{whole.rms:.4g}",
        "p95": f"{whole.p95:.4g}",
        "largest": f"{whole.max:.4g}",
        "signed mean": f"{whole.mean:+.4g}",
    }
    write_comparison_report(
        Path(path),
        shape,
        points,
        comparison.found,
        rows,
        spacing=comparison.step,
        verdict=comparison.verdict,
        is_good=comparison.is_within is not False,
        facts=facts,
        noise=comparison.noise,
        title=title,
        unit=unit,
        warnings=comparison.warnings,
    )


def _residuals(found: Residuals) -> dict[str, float | int | None]:
    values = {name: getattr(found, name) for name in ("rms", "p95", "max", "mean", "explained")}
    return {"n_points": found.n_points, **{name: _known(v) for name, v in values.items()}}


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def _face_table(comparison: Comparison) -> Table:
    table = Table("face", "kind", box=None, pad_edge=False, header_style="bold")
    for name in ("area", "points", "rms", "p95", "max", "mean", "within"):
        table.add_column(name, justify="right")
    for index, face in enumerate(comparison.faces):
        found = _residuals(face.residuals)
        explained = found["explained"]
        table.add_row(
            str(index),
            face.kind,
            number(face.area, 4),
            str(found["n_points"]),
            *(number(found[name], 3) for name in ("rms", "p95", "max", "mean")),
            "-" if explained is None else f"{100.0 * explained:.1f} %",
            style="bold" if index == comparison.worst_face else None,
        )
    return table


def _histogram(comparison: Comparison) -> Text:
    """Bars of the signed deviations, a few bins a bar."""
    edges = comparison.bin_edges[::_BINS_A_BAR]
    sums = comparison.counts.reshape(-1, _BINS_A_BAR).sum(axis=1)
    lines = []
    for low, high, count in zip(edges[:-1], edges[1:], sums.tolist(), strict=True):
        bar = "#" * round(_BAR * count / int(sums.max()))
        lines.append(f"{low:+9.3g} to {high:+9.3g} {bar} {100.0 * count / sums.sum():.1f} %")
    return Text("\n".join(lines))
