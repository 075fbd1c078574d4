"""The parts of a report's page that need no script: facts, tables, histogram."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from html import escape

import numpy as np

from crispline.findings import FaceReport
from crispline.report.page import Page
from crispline.report.palette import KIND_COLOURS, kind_index, ramp_colour
from crispline.surface.base import Array

_PLACE = re.compile(r"near \((-?[\d.e+-]+), (-?[\d.e+-]+), (-?[\d.e+-]+)\)")
_N_BINS = 61
_COLUMNS = (
    ("#", "face"), ("type", "text"), ("size", "text"), ("axis", "text"), ("area", ""),
    ("points", ""), ("rms", ""), ("p95", ""), ("max", ""), ("mean", ""),
    ("3\N{GREEK SMALL LETTER SIGMA} %", ""),
)  # fmt: skip


def number(value: float, digits: int = 4, flag: str = "") -> str:
    """A number with a few digits; a dash for one that is not known; ``#`` keeps final zeros.

    >>> number(1234.5678), number(18393.2), number(12345678.0), number(float("nan"))
    ('1235', '18390', '1.235e+07', '\N{EN DASH}')
    """
    if not math.isfinite(value):
        return "\N{EN DASH}"
    text = f"{value:{flag}.{digits}g}".rstrip(".")
    if "e+" in text and abs(value) < 1e7:
        text = f"{float(text):.0f}"
    return text.replace("-", "\N{MINUS SIGN}", 1 if value < 0 else 0)


def facts(pairs: Iterable[tuple[str, str]]) -> str:
    """The most important numbers."""
    return "".join(
        f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in pairs
    )


def sections(page: Page, limit: float) -> str:
    """Everything below the facts; ``limit`` is the range of the colour bar."""
    parts = []
    if page.faces:
        parts.append(_section("Faces", f'<div class="scroll">{face_table(page.faces)}</div>'))
    known = page.scene.cloud.deviations[np.isfinite(page.scene.cloud.deviations)]
    if len(known):
        parts.append(_section(_titled("Deviation", page.unit), _histogram(known, limit, page)))
    if page.warnings:
        items = "".join(_warning(warning) for warning in page.warnings)
        parts.append(_section("Warnings", f'<ul class="warnings">{items}</ul>'))
    run = _timings(page.timings) + _options(page.options)
    if run:
        parts.append(_section("Run", run))
    return "\n".join(parts)


def place_of(warning: str) -> tuple[float, ...] | None:
    """The place that a warning names.

    >>> place_of("no common curve near (1, -2.5, 3e-05): taken from the net")
    (1.0, -2.5, 3e-05)
    """
    found = _PLACE.search(warning)
    return tuple(map(float, found.groups())) if found else None


def _section(title: str, body: str) -> str:
    return f"<section><h2>{escape(title)}</h2>\n{body}</section>"


def _titled(title: str, unit: str) -> str:
    return f"{title} in {unit}" if unit else title


def face_table(faces: Iterable[FaceReport]) -> str:
    """The table of faces; the page's script sorts it."""
    heads = "".join(
        f'<th scope="col" class="{kind}"><button type="button">{name}</button></th>'
        for name, kind in _COLUMNS
    )
    rows = "\n".join(_face_row(index, face) for index, face in enumerate(faces))
    return (
        f'<table id="faces" aria-label="Faces"><thead><tr>{heads}</tr></thead>'
        f"<tbody>\n{rows}</tbody></table>"
    )


def _face_row(index: int, face: FaceReport) -> str:
    colour = KIND_COLOURS[kind_index(face.kind)]
    size, sort_size = _size(face.parameters)
    cells = [
        _cell(str(index), index),
        f'<td class="text" data-value="{escape(face.kind)}">'
        f'<i style="background:{colour}"></i>{escape(face.kind)}</td>',
        _cell(size, sort_size, "text"),
        _cell(_axis(face.parameters), 0.0, "text"),
        _cell(number(face.area), face.area),
        _cell(f"{face.n_points}", face.n_points),
    ]
    cells += [_cell(number(x, 3, "#"), x) for x in (face.rms, face.p95, face.max)]
    cells.append(_cell(_as_fine_as(face.rms, face.mean), face.mean))
    share = f"{100.0 * face.explained:.1f}" if math.isfinite(face.explained) else number(math.nan)
    cells.append(_cell(share, face.explained))
    return f'<tr data-face="{index}" tabindex="0" aria-selected="false">{"".join(cells)}</tr>'


def _as_fine_as(rms: float, mean: float) -> str:
    """The mean with the decimals of an rms of three digits: more would be noise."""
    if not (rms > 0.0 and math.isfinite(mean)):
        return number(mean, 3)
    decimals = max(0, 2 - math.floor(math.log10(rms)))
    if decimals > 6:
        return number(mean, 2)
    return f"{round(mean, decimals) + 0.0:.{decimals}f}".replace("-", "\N{MINUS SIGN}")


def _cell(text: str, value: float, style: str = "") -> str:
    key = f"{value:.9g}" if math.isfinite(value) else ""
    return f'<td class="{style}" data-value="{key}">{escape(text)}</td>'


def _size(parameters: Mapping[str, float | list[float]]) -> tuple[str, float]:
    """Radius or angle as text, and what to sort by."""
    signs = {
        "radius": ("R {}", 5), "major_radius": ("R {}", 5), "minor_radius": ("r {}", 5),
        "half_angle_deg": ("{}\N{DEGREE SIGN}", 4),
    }  # fmt: skip
    found = [
        (signs[name][0].format(number(value, signs[name][1])), value)
        for name, value in parameters.items()
        if name in signs and isinstance(value, int | float)
    ]
    return ", ".join(text for text, _ in found), found[0][1] if found else math.nan


def _axis(parameters: Mapping[str, float | list[float]]) -> str:
    direction = parameters.get("axis", parameters.get("normal"))
    if not isinstance(direction, list):
        return ""
    return " ".join(number(round(x, 3) + 0.0, 4) for x in direction)


def _histogram(deviations: Array, limit: float, page: Page) -> str:
    """Counts within the range of the colour bar, and the noise as a normal distribution."""
    counts, edges = np.histogram(deviations, _N_BINS, (-limit, limit))
    x, y, words = np.zeros(0), np.zeros(0), _statistics(deviations, limit)
    if math.isfinite(page.noise) and page.noise > 0.0:
        x = np.linspace(-limit, limit, 121)
        density = np.exp(-0.5 * (x / page.noise) ** 2) / (page.noise * math.sqrt(2 * math.pi))
        y = density * len(deviations) * (edges[1] - edges[0])
        words += f"; line: normal distribution of the noise, sigma {number(page.noise, 3)}"
    # One unit of the picture is a 600th of its width; the axis lies at height 132 of 150.
    high = 125.0 / max(int(counts.max()), float(y.max(initial=0.0)), 1)
    step = 600.0 / _N_BINS
    bars = "".join(
        f'<rect x="{i * step + 0.5:.2f}" y="{132 - high * count:.2f}" '
        f'width="{step - 1:.2f}" height="{high * count:.2f}" fill="{ramp_colour(share)}"/>'
        for i, (count, share) in enumerate(zip(counts, np.linspace(-1, 1, _N_BINS), strict=True))
    )
    curve = " ".join(
        f"{300 + 300 * a / limit:.1f},{132 - high * b:.1f}" for a, b in zip(x, y, strict=True)
    )
    anchors = ("start", "middle", "middle", "middle", "end")
    ticks = "".join(
        f'<text x="{300 + 297 * share:.0f}" y="146" text-anchor="{anchor}">'
        f"{number(limit * share, 3)}</text>"
        for share, anchor in zip((-1.0, -0.5, 0.0, 0.5, 1.0), anchors, strict=True)
    )
    return (
        '<svg class="histogram" viewBox="0 0 600 150" role="img" '
        f'aria-label="Histogram of the deviations">{bars}'
        f'<line class="axis" x1="0" x2="600" y1="132" y2="132"/>'
        f'<polyline class="normal" points="{curve}"/>{ticks}</svg>'
        f'<p class="note">{escape(words)}</p>'
    )


def _statistics(deviations: Array, limit: float) -> str:
    """In words; outliers are counted, not mixed into the rms."""
    size = np.abs(deviations)
    inside, n_beyond = deviations[size <= limit], int(np.count_nonzero(size > limit))
    words = ""
    if len(inside):
        words = (
            f"Within the range: rms {number(float(np.sqrt(np.mean(inside**2))), 3)}, "
            f"mean {number(float(inside.mean()), 2)}, "
            f"p95 {number(float(np.quantile(np.abs(inside), 0.95)), 3)}; "
        )
    beyond = f", by up to {number(float(size.max()), 3)}" if n_beyond else ""
    return f"{words}{n_beyond} of {len(size)} points lie beyond it{beyond}"


def _warning(warning: str) -> str:
    place = place_of(warning)
    button = ""
    if place is not None:
        spot = ",".join(f"{x!r}" for x in place)
        button = f'<button type="button" data-place="{spot}" aria-label="Show the place"></button>'
    return f"<li>{button}<p>{escape(warning)}</p></li>"


def _timings(timings: Mapping[str, float]) -> str:
    if not timings:
        return ""
    total, longest = sum(timings.values()), max(timings.values())
    rows = "".join(
        f'<tr><td class="text">{escape(name)}</td><td>{seconds:.1f} s</td>'
        f'<td class="share"><i style="--part:{100 * seconds / max(longest, 1e-9):.0f}%"></i></td>'
        "</tr>"
        for name, seconds in timings.items()
    )
    return (
        f'<div class="run"><table><tbody>{rows}<tr><td class="text">total</td>'
        f"<td>{total:.1f} s</td><td></td></tr></tbody></table></div>"
    )


def _options(options: Mapping[str, str]) -> str:
    if not options:
        return ""
    rows = "".join(
        f'<tr><td class="text">{escape(name)}</td><td>{escape(value)}</td></tr>'
        for name, value in options.items()
    )
    return (
        '<details class="run"><summary>Options used</summary>'
        f"<table><tbody>{rows}</tbody></table></details>"
    )
