"""Tables of coordinates in text files: any separator, comments, column names, extra columns."""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from crispline.errors import InputError
from crispline.surface.base import Array

_COMMENTS = ("#", "//", "%", ";", "!")
_DECIMAL_COMMA = re.compile(r"[-+]?\d+,\d+([eE][-+]?\d+)?")
_XYZ = ("x", "y", "z")
_NORMAL = ("nx", "ny", "nz")
_UNIT_SLACK = 2e-3  # of the length of normals that are written with three digits


@dataclass(frozen=True)
class _Layout:
    """Where the numbers stand in a row.

    Attributes
    ----------
    separator : one character, or None for any run of blanks.
    has_decimal_comma : whether ``1,5`` means one and a half.
    columns : positions of x, y, z and, if the header names them, nx, ny, nz.
    """

    separator: str | None
    has_decimal_comma: bool
    columns: tuple[int, ...]

    def fields(self, row: str) -> list[str]:
        text = row.replace(",", ".") if self.has_decimal_comma else row
        return [field.strip() for field in text.split(self.separator)]


def parse_table(text: str, source: str, *, keyword: str = "") -> tuple[Array, Array | None]:
    r"""Read points from text, one a row.

    Blank lines and lines that start with ``#``, ``//``, ``%``, ``;`` or ``!``
    are skipped, so is one header line of column names or a lone point count.
    Values are separated by blanks, commas, semicolons or tabs; with another
    separator between the columns, commas inside numbers are decimal commas.
    If a header names columns ``x``, ``y``, ``z`` (and ``nx``, ``ny``, ``nz``)
    those are taken, else the first three, and the next three as normals if they
    are a unit vector in every row, which no other columns are.

    Parameters
    ----------
    text : content of the file.
    source : what error messages call the file.
    keyword : if given, only rows that start with this word are points, and it
        is not a column (``v`` in an OBJ file).

    Returns
    -------
    points : shape ``(n, 3)``; values may be NaN or infinite if the text says so.
    normals : shape ``(n, 3)``, or None if there are none.

    Raises
    ------
    InputError
        A row without three numbers (the message tells the line), or no row.

    Examples
    --------
    >>> parse_table("x;y;z\n0,5;1;2\n3,0;4;5", "scan.csv")[0].tolist()
    [[0.5, 1.0, 2.0], [3.0, 4.0, 5.0]]
    """
    lines = [line.strip() for line in text.splitlines()]
    if keyword:
        is_row = [line.split(None, 1)[:1] == [keyword] for line in lines]
        lines = [line[len(keyword) :].strip() for line in lines]
    else:
        is_row = [bool(line) and not line.startswith(_COMMENTS) for line in lines]
    numbers = [number for number, keep in enumerate(is_row) if keep]
    if numbers and _is_preamble(lines[numbers[0]]):
        del numbers[0]
    if not numbers:
        wanted = f"rows of '{keyword} x y z'" if keyword else "rows of x y z"
        raise InputError(f"{source}: expected {wanted}, found none; check the format")

    rows = [lines[number] for number in numbers]
    layout = _layout(rows[0], [] if keyword else lines[: numbers[0]])
    if layout.has_decimal_comma:
        rows = [row.replace(",", ".") for row in rows]
    if len(layout.columns) == 3 and _ends_in_unit_vector(layout.fields(rows[0])):
        with suppress(ValueError):
            table = _load(rows, layout.separator, range(6))
            if _are_units(table[:, 3:]):
                return table[:, :3], table[:, 3:]
    try:
        table = _load(rows, layout.separator, layout.columns)
    except ValueError as error:
        raise InputError(_first_fault(lines, numbers, layout, source)) from error
    return table[:, :3], table[:, 3:] if len(layout.columns) == 6 else None


def _load(rows: list[str], separator: str | None, columns: Sequence[int]) -> Array:
    return np.loadtxt(rows, delimiter=separator, usecols=columns, comments=None, ndmin=2)


def _ends_in_unit_vector(fields: list[str]) -> bool:
    """Whether the fourth to the sixth field look like a normal: cheap, on one row."""
    numbers = [float(field) for field in fields[3:6] if _is_number(field)]
    return len(numbers) == 3 and _are_units(np.array([numbers]))


def _are_units(vectors: Array) -> bool:
    return bool((abs(np.linalg.norm(vectors, axis=1) - 1.0) < _UNIT_SLACK).all())


def _layout(row: str, preamble: list[str]) -> _Layout:
    """Tell separator, decimal mark and columns from the first row and the lines above it."""
    separator = next((mark for mark in (";", "\t") if mark in row), None)
    fields = row.split(separator)
    with_comma = [field.strip() for field in fields if "," in field]
    has_decimal_comma = (
        bool(with_comma) and len(fields) >= 3 and all(map(_DECIMAL_COMMA.fullmatch, with_comma))
    )
    if with_comma and not has_decimal_comma:
        separator = ","
    n_fields = len(row.split(separator))
    for line in preamble:
        header = line.lstrip("#/%;! ")
        names = [name.strip(" \"'").lower() for name in header.split(separator)]
        # More names than fields means that the header is split in another way than the rows.
        if set(_XYZ) <= set(names) and len(names) <= n_fields:
            wanted = _XYZ + _NORMAL if set(_NORMAL) <= set(names) else _XYZ
            return _Layout(separator, has_decimal_comma, tuple(map(names.index, wanted)))
    return _Layout(separator, has_decimal_comma, (0, 1, 2))


def _is_preamble(line: str) -> bool:
    """Whether the line names the columns or, as PTS files do, counts the points."""
    return line.isdigit() or not any(map(_is_number, re.split(r"[,;\s]+", line)))


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _first_fault(lines: list[str], numbers: list[int], layout: _Layout, source: str) -> str:
    """Find the row that the fast parser refused and say what is wrong with it."""
    for number in numbers:
        fields = layout.fields(lines[number])
        where = f"{source}, line {number + 1}"
        if len(fields) <= max(layout.columns):
            return (
                f"{where}: expected at least {max(layout.columns) + 1} columns, "
                f"found {len(fields)}; every row needs x y z"
            )
        for column in layout.columns:
            if not _is_number(fields[column]):
                return (
                    f"{where}: expected a number, found '{fields[column][:40]}'; "
                    "remove the line or start it with #"
                )
    return f"{source}: expected rows of x y z, found a table that cannot be read"
