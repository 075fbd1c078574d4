"""STEP and IGES files that are cut off or altered: found before OCCT translates them.

OCCT trusts what it has loaded, and ends the whole process on some damaged files;
of an IGES file that is cut off it makes a surface of arbitrary numbers.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

_MARK = 72
"""Column of the section letter in a line of an IGES file; its line's number follows."""

_LAST_LINE = re.compile(r"S([ \d]{7})G([ \d]{7})D([ \d]{7})P([ \d]{7})")


def step_damage(reader: Any) -> str | None:
    """What is wrong with a file that a ``STEPControl_Reader`` has loaded, or None.

    Only syntax, references and the records of geometry and topology count; an
    odd record about products does no harm.
    """
    checks = reader.WS().ModelCheckList(True)
    checks.Start()
    while checks.More():
        check, number = checks.Value(), checks.Number()
        # Number 0 stands for the file as a whole.
        name = type(reader.Model().Value(number)).__name__ if number else "StepShape_File"
        if check.HasFailed() and name.startswith(("StepGeom_", "StepShape_")):
            return f"{name.partition('_')[2]} {number}: {check.Fail(1).ToCString()}"
        checks.Next()
    return None


def iges_damage(content: bytes) -> str | None:
    """What is wrong with the lines of an IGES file (fixed format, 80 columns), or None.

    References
    ----------
    IGES 5.3, section 2.2: every line has its section and number in columns 73 to
    80; the last line counts the lines of the sections.
    """
    lines = content.decode("latin-1").splitlines()
    while lines and not lines[-1].strip():
        lines.pop()
    count: Counter[str] = Counter()
    for place, line in enumerate(lines, start=1):
        section = line[_MARK : _MARK + 1]
        count[section] += 1
        if section not in tuple("SGDPT") or _number(line[_MARK + 1 : 80]) != count[section]:
            return f"line {place} does not end in its section and number"
        record = _number(line[64:_MARK]) if section == "P" else 1
        if record % 2 != 1 or not 0 < record <= max(count["D"], 1):
            return f"line {place} belongs to no record"
    found = _LAST_LINE.match(lines[-1]) if lines else None
    if found is None or count["T"] != 1:
        return "the last line, with the counts of the others, is missing"
    for section, stated in zip("SGDP", found.groups(), strict=True):
        if _number(stated) != count[section]:
            return f"{_number(stated)} lines of section {section} announced, {count[section]} there"
    return None


def _number(text: str) -> int:
    """The number in a column of a line, or -1."""
    return int(text) if text.strip().isdecimal() else -1
