"""The summary of a run as text for people."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import Any

from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

_ZERO = 1e-4
"""Components of a vector below this share of the largest are shown as 0."""


def render_summary(summary: Mapping[str, Any]) -> RenderableType:
    """Lay out ``Reconstruction.summary()`` for a terminal.

    Parameters
    ----------
    summary : with the keys ``valid``, ``closed``, ``spacing``, ``noise``, ``n_faces``,
        ``faces``, ``edges``, ``corners``, ``timings`` and ``warnings``; lengths
        in the unit of the cloud, angles in degrees, times in seconds.

    Returns
    -------
    Text and tables that a rich console prints.
    """
    spacing, noise = summary["spacing"], summary["noise"]
    blocks: list[RenderableType] = [
        Text(_verdict(summary), style="bold green" if summary["valid"] else "bold red"),
        Text(f"spacing {spacing:.4g}, noise {noise:.4g} ({noise / spacing:.2f} spacings)"),
    ]
    if summary.get("residuals") is not None:
        blocks.append(Text(summary["verdict"]))
    if summary["faces"]:
        blocks.append(_face_table(summary["faces"]))
    blocks.append(Text(_edge_line(summary["edges"], len(summary["corners"]))))
    blocks.append(Text(_timing_line(summary["timings"])))
    blocks += [Text(f"warning: {warning}", style="yellow") for warning in summary["warnings"]]
    return Group(*blocks)


def _verdict(summary: Mapping[str, Any]) -> str:
    if not summary["valid"]:
        return "no valid model"
    kind = "closed solid" if summary["closed"] else "open shell"
    n_faces = summary["n_faces"]
    n_trimmed = sum(face["kind"] != "patch" for face in summary["faces"])
    n_patches = n_faces - n_trimmed
    patches = f"{n_patches} bicubic patch{'' if n_patches == 1 else 'es'}"
    if n_trimmed == 0:
        return f"valid {kind}, {patches}"
    return f"valid {kind}, {_counted(n_trimmed, 'face')}" + (f" and {patches}" if n_patches else "")


def _face_table(faces: Iterable[Mapping[str, Any]]) -> Table:
    table = Table("face", "kind", "parameters", box=None, pad_edge=False, header_style="bold")
    for name in ("area", "points", "rms", "p95", "max", "mean", "3 sigma"):
        table.add_column(name, justify="right")
    for index, face in enumerate(faces):
        if face["kind"] == "patch":
            continue  # often hundreds, and none says more than its region's warning
        table.add_row(
            str(index),
            face["kind"],
            Text(", ".join(_parameters(face["parameters"]))),
            number(face["area"], 4),
            str(face["n_points"]),
            *(number(face[name]) for name in ("rms", "p95", "max", "mean")),
            "-" if face.get("explained") is None else f"{100.0 * face['explained']:.0f} %",
        )
    return table


def number(value: float | None, digits: int = 2) -> str:
    """A number for a table; a dash for None."""
    return "-" if value is None else f"{value:.{digits}g}"


def _parameters(parameters: Mapping[str, Any]) -> Iterable[str]:
    """Scalars and vectors as text; control points and knots stay in the JSON summary."""
    for name, value in parameters.items():
        label = name.removesuffix("_deg").replace("_", " ")
        if isinstance(value, int | float):
            yield f"{label} {value:.5g}{'°' if name.endswith('_deg') else ''}"
        elif len(value) == 3 and all(isinstance(x, int | float) for x in value):
            largest = max(map(abs, value))
            shown = (f"{x:.4g}" if abs(x) > _ZERO * largest else "0" for x in value)
            yield f"{label} ({' '.join(shown)})"


def _edge_line(edges: Iterable[Mapping[str, Any]], n_corners: int) -> str:
    sharp = [edge for edge in edges if edge["is_sharp"]]
    kinds = Counter(edge["kind"] for edge in sharp)
    by_kind = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    detail = f" ({by_kind}; length {sum(edge['length'] for edge in sharp):.4g})" if sharp else ""
    return f"{_counted(len(sharp), 'sharp edge')}{detail}, {_counted(n_corners, 'corner')}"


def _timing_line(timings: Mapping[str, float]) -> str:
    stages = ", ".join(f"{stage} {seconds:.1f}" for stage, seconds in timings.items())
    return f"{sum(timings.values()):.1f} s ({stages})"


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun}{'' if n == 1 else 's'}"
