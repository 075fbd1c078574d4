"""Runs of the benchmark: what is to be run, what came of it, kept one a line."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Case:
    """One scan.

    Attributes
    ----------
    name : of the part or of the truth's file.
    n_points, noise : of the scan, noise over the diagonal; None for a truth as it is.
    seed : of the scan.
    """

    name: str
    n_points: int | None = None
    noise: float | None = None
    seed: int = 0

    @property
    def key(self) -> str:
        """A name for files, one for each case."""
        if self.n_points is None or self.noise is None:
            return self.name
        return f"{self.name}_{self.n_points}_{self.noise:g}_{self.seed}"


@dataclass(frozen=True)
class Row:
    """What came of a case.

    Attributes
    ----------
    case : see `Case`. is_own : a part of the benchmark's own.
    n_points, noise : of the cloud; noise is the standard deviation of a coordinate in spacings.
    exit_code : of the program; None if it was stopped at the time limit.
    reason : why there is no model, or no score; empty if all went well.
    seconds, peak_mb : of the program, from the cloud's file to the STEP file.
    representation : ``trimmed`` or ``patches``; empty if unknown.
    warnings : of the program.
    score : `referee.Score` as a dictionary, or None.
    """

    case: Case
    is_own: bool
    n_points: int
    noise: float
    exit_code: int | None
    reason: str
    seconds: float
    peak_mb: float | None
    representation: str
    warnings: tuple[str, ...]
    score: dict[str, Any] | None


def own_cases(
    names: Iterable[str], sizes: Iterable[int], noises: Iterable[float], seed: int
) -> Iterator[Case]:
    """Every part at every size and noise level."""
    for n_points, noise, name in product(sizes, noises, names):
        yield Case(name, n_points, noise, seed)


def read_rows(path: Path) -> list[Row]:
    """Rows of a file, the last one of each case; no file is no rows."""
    if not path.exists():
        return []
    rows = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        fields = json.loads(line)
        case = Case(**fields.pop("case"))
        rows[case.key] = Row(case=case, **fields | {"warnings": tuple(fields["warnings"])})
    return list(rows.values())


def append_row(path: Path, row: Row) -> None:
    """Add a row to a file, at once."""
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(asdict(row)) + "\n")
