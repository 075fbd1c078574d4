"""The experiment's table as JSON and as Markdown."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import crispline
from crispline.paper.rows import NOT_STATED, Method, Row, snr_db
from crispline.paper.windows import FEATURES

_TITLES: dict[Method, str] = {
    "published": "published",
    "paper": "`--rule paper`",
    "robust": "`--rule robust`",
    "pipeline": "pipeline",
}
_NOTHING = "-"


@dataclass(frozen=True)
class _Quantity:
    """What a table shows.

    Attributes
    ----------
    title, note : heading, and a sentence on what the cells hold.
    worst : a cell for rows that differ in their sampling only.
    each : a cell for a single row.
    plain : a cell for the plain surface of a row; None for a table without it.
    methods : methods that have the quantity at all.
    """

    title: str
    note: str
    worst: Callable[[Sequence[Row]], str]
    each: Callable[[Row], str]
    plain: Callable[[Row], str] | None
    methods: tuple[Method, ...]


def to_json(rows: Sequence[Row]) -> str:
    """Every row as an object in a list."""
    return json.dumps([row.as_json() for row in rows], indent=1, allow_nan=False) + "\n"


def to_markdown(rows: Sequence[Row]) -> str:
    """Tables of errors, reverse distances and detection, a column for every method.

    First each method at its worst sampling, a line for every noise level and feature;
    then every sampling. The published numbers, whose sampling is not stated, stand in
    every line of their noise level and feature.
    """
    lines = ["# The paper's experiment", "", *_settings(rows)]
    lines += ["", "## The worst sampling of every method"]
    for quantity in _QUANTITIES:
        lines += ["", f"### {quantity.title}", "", quantity.note, "", *_worst(rows, quantity)]
    lines += ["", "## Every sampling"]
    for quantity in _QUANTITIES:
        lines += ["", f"### {quantity.title}", "", quantity.note, "", *_every(rows, quantity)]
    lines += ["", "## Refusals", "", *_refusals(rows)]
    return "\n".join(lines) + "\n"


def _settings(rows: Sequence[Row]) -> Iterator[str]:
    yield f"Written by `crispline paper`, version {crispline.__version__}."
    for method in dict.fromkeys(row.method for row in rows if row.seeds):
        seeds = max(row.seeds for row in rows if row.method == method)
        yield f"{_TITLES[method]}: {seeds} {'seed' if seeds == 1 else 'seeds'}."
    yield "One seed where nothing is random."


def _worst(rows: Sequence[Row], quantity: _Quantity) -> Iterator[str]:
    methods = _methods(rows, quantity)
    yield from _header(["noise", "SNR", "feature", *(_TITLES[method] for method in methods)])
    for noise, feature in _cells(rows):
        yield _line(
            [
                _percent(noise),
                _snr(noise),
                feature,
                *(
                    quantity.worst([row for row in rows if _key(row) == (method, noise, feature)])
                    for method in methods
                ),
            ]
        )


def _every(rows: Sequence[Row], quantity: _Quantity) -> Iterator[str]:
    methods = _methods(rows, quantity)
    plain = ["plain"] if quantity.plain else []
    titles = [_TITLES[method] for method in methods]
    yield from _header(["noise", "feature", "sampling", *plain, *titles])
    for noise, feature in _cells(rows):
        here = [row for row in rows if row.method in methods and _key(row)[1:] == (noise, feature)]
        samplings = sorted({row.sampling for row in here} - {NOT_STATED}) or [NOT_STATED]
        for sampling in samplings:
            at = {row.method: row for row in here if row.sampling in (sampling, NOT_STATED)}
            cells = [_percent(noise), feature, sampling]
            if quantity.plain:
                own = [row for row in at.values() if row.sampling == sampling]
                cells.append(quantity.plain(own[0]) if own else _NOTHING)
            cells += [quantity.each(at[m]) if m in at else _NOTHING for m in methods]
            yield _line(cells)


def _refusals(rows: Sequence[Row]) -> Iterator[str]:
    failed = [row for row in rows if row.failures]
    if not failed:
        yield "None."
        return
    yield from _header(["method", "noise", "feature", "sampling", "refused", "of"])
    for row in failed:
        counts = [str(row.failures), str(row.windows)]
        yield _line([_TITLES[row.method], _percent(row.noise), row.feature, row.sampling, *counts])


def _methods(rows: Sequence[Row], quantity: _Quantity) -> list[Method]:
    return [m for m in dict.fromkeys(row.method for row in rows) if m in quantity.methods]


def _cells(rows: Sequence[Row]) -> list[tuple[float, str]]:
    """Noise levels and features that occur, in that order."""
    found = {(row.noise, FEATURES.index(row.feature)) for row in rows}
    return [(noise, FEATURES[index]) for noise, index in sorted(found)]


def _key(row: Row) -> tuple[Method, float, str]:
    return row.method, row.noise, row.feature


# --- cells --------------------------------------------------------------------------------


def _worst_error(rows: Sequence[Row]) -> str:
    known = [row for row in rows if row.final is not None]
    return _error(max(known, key=lambda row: row.final or 0.0)) if known else _NOTHING


def _error(row: Row) -> str:
    if row.final is None:
        return _NOTHING
    spread = "" if row.final_spread is None else f" ± {_number(row.final_spread)}"
    share = "" if row.reduction is None else f" ({100.0 * row.reduction:.2f} %)"
    return f"{_number(row.final)}{spread}{share}"


def _initial(row: Row) -> str:
    return _NOTHING if row.initial is None else _number(row.initial)


def _worst_reverse(rows: Sequence[Row]) -> str:
    means = [row.reverse_mean for row in rows if row.reverse_mean is not None]
    tails = [row.reverse_p99 for row in rows if row.reverse_p99 is not None]
    return _pair(max(means, default=None), max(tails, default=None))


def _reverse(row: Row) -> str:
    return _pair(row.reverse_mean, row.reverse_p99)


def _initial_reverse(row: Row) -> str:
    return _pair(row.initial_reverse_mean, row.initial_reverse_p99)


def _pair(mean: float | None, p99: float | None) -> str:
    return _NOTHING if mean is None or p99 is None else f"{_number(mean)} / {_number(p99)}"


def _worst_detection(rows: Sequence[Row]) -> str:
    precision = min((r.precision for r in rows if r.precision is not None), default=None)
    recall = min((r.recall for r in rows if r.recall is not None), default=None)
    return _shares(precision, recall)


def _detection(row: Row) -> str:
    return _shares(row.precision, row.recall)


def _shares(*shares: float | None) -> str:
    return " / ".join(_NOTHING if share is None else _share(share) for share in shares)


def _share(share: float) -> str:
    """Per cent rounded down, so that 100 % means all of it."""
    return f"{math.floor(share * 1e4) / 100.0:.2f} %" if share < 1.0 else "100 %"


def _number(value: float) -> str:
    """Four decimals as in the paper; what these would show as 0 by its power of ten."""
    return f"{value:.4f}" if value == 0.0 or value >= 5e-5 else f"{value:.0e}"


def _percent(noise: float) -> str:
    return f"{100.0 * noise:g} %"


def _snr(noise: float) -> str:
    ratio = snr_db(noise)
    return _NOTHING if ratio is None else f"{ratio:.0f} dB"


def _header(titles: Sequence[str]) -> Iterator[str]:
    yield _line(titles)
    yield "|" + "---|" * len(titles)


def _line(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"


_QUANTITIES = (
    _Quantity(
        "Feature error",
        "Mean distance of the true features to the surface ± its standard deviation over the "
        "seeds, in spacings; in brackets the reduction against the plain surface.",
        _worst_error,
        _error,
        _initial,
        ("published", "paper", "robust", "pipeline"),
    ),
    _Quantity(
        "Reverse distance",
        "Distance of the surface to the truth, mean / 99 % quantile by area, in spacings.",
        _worst_reverse,
        _reverse,
        _initial_reverse,
        ("paper", "robust", "pipeline"),
    ),
    _Quantity(
        "Detection of sharp patches",
        "Precision / recall over all windows and seeds.",
        _worst_detection,
        _detection,
        None,
        ("published", "paper", "robust"),
    ),
)
