"""Rows of the experiment's table: means and spreads over the seeds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal, get_args

import numpy as np

from crispline.paper.measure import Deviation, Hits
from crispline.paper.published import TABLE_I
from crispline.paper.windows import Feature

Rule = Literal["paper", "robust"]
RULES: tuple[Rule, ...] = get_args(Rule)
"""The rules of sharpening a grid."""
Method = Literal["published", "paper", "robust", "pipeline"]
METHODS: tuple[Method, ...] = get_args(Method)
"""The paper's own numbers, its rule, the robust rule, and the reconstruction of whole clouds."""

NOT_STATED = "not stated"
"""Sampling of the published numbers."""


@dataclass(frozen=True)
class Trial:
    """One method on one kind of feature under one noise draw; means over the windows.

    Attributes
    ----------
    sampling : ``grid`` with the position of the feature in cells, or ``random``.
    noise : length of the noise step over an eighth of the model's length.
    before : the plain B-spline surface.
    after : what the method made of it; None if it made nothing.
    found : counts of sharp patches, or None if the method does not tell.
    n_windows, n_failed : windows, and those that the method refused. A refused window
        keeps its plain surface in ``after``.
    """

    method: Method
    sampling: str
    noise: float
    feature: Feature
    seed: int
    before: Deviation
    after: Deviation | None
    found: Hits | None
    n_windows: int
    n_failed: int


@dataclass(frozen=True)
class Row:
    """One line of the table; lengths in spacings, None where nothing is known.

    Attributes
    ----------
    method, sampling, noise, feature : see `Trial`.
    snr_db : signal-to-noise ratio ``20 log10(1 / noise)`` as in the paper, decibels.
    initial, final, reduction : mean error of the plain and of the sharpened surface
        over the seeds, and ``1 - final / initial``; ``_spread`` is the standard
        deviation over the seeds.
    reverse_mean, reverse_p99 : distance of the final surface to the truth, mean and 99 %
        quantile by area; ``initial_reverse_`` is the same of the plain surface.
    precision, recall : of sharp patches, over all windows and seeds together.
    seeds, windows, failures : runs, windows in all of them, and those that failed.
    """

    method: Method
    sampling: str
    noise: float
    snr_db: float | None
    feature: Feature
    initial: float | None
    initial_spread: float | None
    final: float | None
    final_spread: float | None
    reduction: float | None
    reduction_spread: float | None
    initial_reverse_mean: float | None
    initial_reverse_p99: float | None
    reverse_mean: float | None
    reverse_p99: float | None
    precision: float | None
    recall: float | None
    seeds: int
    windows: int
    failures: int

    def as_json(self) -> dict[str, Any]:
        """The row as a JSON object."""
        return asdict(self)


def snr_db(noise: float) -> float | None:
    """Signal-to-noise ratio of a noise level in decibels; None without noise.

    >>> round(snr_db(0.005)), round(snr_db(0.01)), round(snr_db(0.02))
    (46, 40, 34)
    """
    return -20.0 * math.log10(noise) if noise > 0.0 else None


def published_rows(levels: Iterable[float]) -> list[Row]:
    """Table I of the paper at those of the noise levels that it has."""
    rows = []
    for level in levels:
        for feature, (initial, final) in TABLE_I.get(level, {}).items():
            rows.append(
                Row(
                    method="published",
                    sampling=NOT_STATED,
                    noise=level,
                    snr_db=snr_db(level),
                    feature=feature,
                    initial=initial,
                    initial_spread=None,
                    final=final,
                    final_spread=None,
                    reduction=1.0 - final / initial,
                    reduction_spread=None,
                    initial_reverse_mean=None,
                    initial_reverse_p99=None,
                    reverse_mean=None,
                    reverse_p99=None,
                    precision=1.0,
                    recall=1.0,
                    seeds=0,
                    windows=0,
                    failures=0,
                )
            )
    return rows


def rows_of(trials: Sequence[Trial]) -> list[Row]:
    """One row per method, sampling, noise and feature, in the order they first come."""
    groups: dict[tuple[Method, str, float, Feature], list[Trial]] = {}
    for trial in trials:
        key = (trial.method, trial.sampling, trial.noise, trial.feature)
        groups.setdefault(key, []).append(trial)
    return [_row(group) for group in groups.values()]


def _row(trials: Sequence[Trial]) -> Row:
    first = trials[0]
    done = [(trial.before, trial.after) for trial in trials if trial.after is not None]
    initial, initial_spread = _statistics([trial.before.error for trial in trials])
    final, final_spread = _statistics([after.error for _, after in done])
    _, reduction_spread = _statistics([1.0 - after.error / before.error for before, after in done])
    found = [trial.found for trial in trials if trial.found is not None]
    return Row(
        method=first.method,
        sampling=first.sampling,
        noise=first.noise,
        snr_db=snr_db(first.noise),
        feature=first.feature,
        initial=initial,
        initial_spread=initial_spread,
        final=final,
        final_spread=final_spread,
        reduction=1.0 - final / initial if final is not None and initial else None,
        reduction_spread=reduction_spread,
        initial_reverse_mean=_statistics([trial.before.reverse_mean for trial in trials])[0],
        initial_reverse_p99=_statistics([trial.before.reverse_p99 for trial in trials])[0],
        reverse_mean=_statistics([after.reverse_mean for _, after in done])[0],
        reverse_p99=_statistics([after.reverse_p99 for _, after in done])[0],
        precision=_ratio(sum(hit.n_true for hit in found), sum(hit.n_sharp for hit in found)),
        recall=_ratio(sum(hit.n_found for hit in found), sum(hit.n_pieces for hit in found)),
        seeds=len(trials),
        windows=sum(trial.n_windows for trial in trials),
        failures=sum(trial.n_failed for trial in trials),
    )


def _statistics(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Mean, and sample standard deviation if there are two values or more."""
    if not values:
        return None, None
    spread = float(np.std(values, ddof=1)) if len(values) > 1 else None
    return float(np.mean(values)), spread


def _ratio(part: int, whole: int) -> float | None:
    return part / whole if whole else None
