"""The documentation site: `make docs`. Nothing in it needs the network when it is read."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import Any

import click
from sphinx.application import Sphinx
from sphinx.util.inspect import TypeAliasForwardRef

sys.path.insert(0, str(Path(__file__).parents[1] / "src"))

from crispline import __version__
from crispline.cli import main
from crispline.configuration import settings, toml_value

project = "crispline"
author = "crispline developers"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]

default_role = "code"
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("Array", "ArrayLike", "Index")}
autodoc_default_options = {"members": True}
python_use_unqualified_type_names = True
napoleon_google_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"crispline {__version__}"
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False

_ITEM = re.compile(r"^(\w[\w, ]*) : (.*)$")
_LISTS = ("Parameters", "Attributes")


# An alias inside another type is shown by its name.
TypeAliasForwardRef.__repr__ = lambda alias: alias.name


def options_reference() -> str:
    """Every setting with its default, meaning and unit, a table for each group."""
    lines, table = [], None
    for one in settings():
        if one.table != table:
            table = one.table
            title = f"`[{table}]`" if table else "At the top"
            lines += ["", f"## {title}", "", "| key | default | meaning |", "|---|---|---|"]
        value = "not set" if one.value is None else f"`{toml_value(one.value)}`"
        unit = f" {one.unit}" if one.unit else ""
        meaning = one.meaning.replace("``", "`").replace("|", "\\|")
        lines.append(f"| `{one.key}` | {value}{unit} | {meaning} |")
    return "\n".join(lines)


def commands_reference() -> str:
    """What every command prints as its help."""
    lines = []
    for name, command in sorted(main.commands.items()):
        with click.Context(command, info_name=f"crispline {name}", max_content_width=92) as context:
            text = command.get_help(context)
        lines += ["", f"## {name}", "", "```text", text, "```"]
    return "\n".join(lines)


def fill(app: Sphinx, name: str, content: list[str]) -> None:
    """Put what is generated from the code in its place."""
    content[0] = content[0].replace("% options from the code", options_reference())
    content[0] = content[0].replace("% commands from the code", commands_reference())


def rewrite_docstring(
    app: Sphinx, what: str, name: str, found: Any, options: Any, lines: list[str]
) -> None:
    """Turn ``name : meaning`` into what napoleon takes for a meaning, not for a type."""
    written: list[str] = []
    section = ""
    for number, line in enumerate(lines):
        below = lines[number + 1] if number + 1 < len(lines) else ""
        if line and below and set(below) == {"-"}:
            section = line
        item = _ITEM.match(line) if section in _LISTS else None
        if item:
            written += [item[1], f"    {item[2]}"]
        elif section == "Returns" and line == section:
            written += ["", ":returns:"]  # two empty lines end a section
        elif section == "Returns":
            written += [f"    {line}"] if line and set(line) != {"-"} else []
        else:
            written.append(line)
        if section == "Returns" and not below:
            written.append("")
    lines[:] = written


def rewrite_signature(
    app: Sphinx, what: str, name: str, found: Any, options: Any, signature: str, returns: str
) -> tuple[str, str] | None:
    """Leave out where the types of a signature stand."""
    if signature is None:
        return None
    plain = (re.sub(r"~[\w.]*\.", "", text or "") for text in (signature, returns))
    return next(plain), next(plain)


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", fill)
    app.connect("autodoc-process-docstring", rewrite_docstring, priority=400)  # before napoleon
    app.connect("autodoc-process-signature", rewrite_signature)
