"""An inspection of a cloud as JSON and as lines on a terminal."""

from __future__ import annotations

from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from crispline.cloud.inspection import Inspection

_AT_RANDOM = 1.7
"""Ratio of the 99 % to the 1 % quantile of the spacing where points fall evenly at random."""


def inspection_summary(found: Inspection) -> dict[str, Any]:
    """Everything in JSON-ready form; unknown numbers are None."""
    return {
        "n_points": found.n_points,
        "n_dropped": found.n_dropped,
        "n_duplicates": found.n_duplicates,
        "outlier_share": found.outlier_share,
        "low": found.low.tolist(),
        "high": found.high.tolist(),
        "unit_guess": found.unit,
        "unit_reason": found.unit_reason,
        "spacing": found.spacing,
        "noise": found.noise,
        "spacing_p1": found.density[0],
        "spacing_p99": found.density[1],
        "is_in_scan_order": found.is_in_scan_order,
        "has_normals": found.has_normals,
        "has_viewpoints": found.has_viewpoints,
        "rim_share": found.rim_share,
        "wall_share": found.wall_share,
        "wall_gap": found.wall_gap if found.wall_share else None,
        "faces_lost_below": found.lost_below,
        "faces_uncertain_below": found.uncertain_below,
        "walls_merge_below": found.wall_below,
        "expected_seconds": found.seconds,
        "expected_gigabytes": found.gigabytes,
        "warnings": list(found.warnings),
    }


def render_inspection(found: Inspection) -> RenderableType:
    """Lay out an inspection for a terminal."""
    table = Table(box=None, pad_edge=False, show_header=False)
    table.add_column(style="bold", no_wrap=True)
    table.add_column()
    for name, value in _lines(found):
        table.add_row(name, Text(value))
    warnings = [Text(f"warning: {warning}", style="yellow") for warning in found.warnings]
    return Group(table, *warnings)


def _lines(found: Inspection) -> list[tuple[str, str]]:
    spacing, (p1, p99) = found.spacing, found.density
    sides = " x ".join(f"{side:.5g}" for side in found.high - found.low)
    middle = ", ".join(f"{value:.5g}" for value in 0.5 * (found.low + found.high))
    order = "in rows, as scanned" if found.is_in_scan_order else "in no order"
    brings = [
        name
        for name, has in (
            ("normals", found.has_normals),
            ("scanner positions", found.has_viewpoints),
        )
        if has
    ]
    walls = "none seen within 3 spacings"
    if found.wall_share > 0.0:
        walls = (
            f"{100.0 * found.wall_share:.1f} % of the points face another sheet, "
            f"{found.wall_gap:.3g} away ({found.wall_gap / spacing:.1f} spacings)"
        )
    return [
        ("points", f"{found.n_points}, {order}, with {' and '.join(brings) or 'no normals'}"),
        (
            "left out",
            f"{found.n_dropped} not finite, {found.n_duplicates} duplicates, about "
            f"{100.0 * found.outlier_share:.1f} % outliers",
        ),
        ("extent", f"{sides} about ({middle})"),
        ("unit", f"{found.unit}? {found.unit_reason}"),
        ("spacing", f"{spacing:.4g}"),
        ("noise", f"{found.noise:.3g} ({found.noise / spacing:.2f} spacings)"),
        (
            "density",
            f"spacing {p1:.3g} to {p99:.3g} (1 to 99 %), {p99 / p1:.1f} to 1; even sampling "
            f"at random has {_AT_RANDOM:g}",
        ),
        ("rims", f"{100.0 * found.rim_share:.1f} % of the points lie at rims or holes"),
        ("walls", walls),
        (
            "too small",
            f"faces narrower than {found.lost_below:.3g} "
            f"({found.lost_below / spacing:.2g} spacings) are lost, up to "
            f"{found.uncertain_below:.3g} ({found.uncertain_below / spacing:.2g}) uncertain; "
            "walls thinner than "
            f"{found.wall_below:.3g} ({found.wall_below / spacing:.2g}) merge",
        ),
        (
            "reconstruct",
            f"takes about {_time(found.seconds)} and {found.gigabytes:.1f} GB on 2 cores; "
            "the shape matters as much as the count",
        ),
    ]


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 100.0 else f"{seconds / 60.0:.0f} min"
