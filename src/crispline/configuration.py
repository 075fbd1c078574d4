"""Settings in a TOML file: what each means, how they are written and read.

The one source is `crispline.options`: its classes are the tables, their fields the keys, the
text under a field its meaning.

>>> read_text("net.fill_holes = 15").options.net.fill_holes
15.0
>>> read_text(to_toml()) == Configuration()
True
"""

from __future__ import annotations

import ast
import inspect
import math
import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from difflib import get_close_matches
from pathlib import Path
from types import NoneType
from typing import Any, Literal, get_args, get_origin, get_type_hints

from crispline import options as source
from crispline.errors import InputError
from crispline.options import Options, SharpenOptions

_WIDTH = 96
_HEAD = """\
Settings of crispline, with their defaults. Every line may be left out.
Lengths are in point spacings, noise in standard deviations (sigmas), angles in degrees:
nothing here depends on the unit or the size of a model."""


@dataclass(frozen=True)
class Configuration:
    """What a TOML file holds.

    Attributes
    ----------
    options : of `reconstruct` and `detect`, the keys and tables at the top.
    sharpen : of `sharpen`, the table ``[sharpen]``.
    """

    options: Options = field(default_factory=Options)
    sharpen: SharpenOptions = field(default_factory=SharpenOptions)


@dataclass(frozen=True)
class Setting:
    """One setting.

    Attributes
    ----------
    name : its tables and key, with dots between them.
    kind : its type.
    value : its value; None where it follows from the cloud.
    meaning : what it does, with its unit.
    """

    name: str
    kind: Any
    value: Any
    meaning: str

    @property
    def table(self) -> str:
        """The table it stands in, empty at the top."""
        return self.name.rpartition(".")[0]

    @property
    def key(self) -> str:
        """Its name without the table."""
        return self.name.rpartition(".")[2]

    @property
    def unit(self) -> str:
        """Its unit where the key has one; else the meaning tells it."""
        return "degrees" if self.key.endswith("_deg") else ""


def settings(configuration: Configuration | None = None) -> list[Setting]:
    """Every setting, those of a table one after the other."""
    given = configuration or Configuration()
    meanings = _meanings()
    return [*_walk(given.options, "", meanings), *_walk(given.sharpen, "sharpen.", meanings)]


def changed(configuration: Configuration) -> list[Setting]:
    """The settings that differ from their defaults."""
    pairs = zip(settings(configuration), settings(), strict=True)
    return [one for one, default in pairs if one.value != default.value]


def to_toml(configuration: Configuration | None = None) -> str:
    """Every setting with its meaning, as TOML; one without a value is a comment."""
    lines = [f"# {line}" for line in _HEAD.splitlines()]
    table = ""
    for setting in settings(configuration):
        lines.append("")
        if setting.table != table:
            table = setting.table
            lines += [f"[{table}]", f"# {_table_meaning(table)}", ""]
        meaning = setting.meaning.replace("``", "").replace("None:", "left out:")
        lines += [f"# {line}" for line in textwrap.wrap(meaning, _WIDTH)]
        value = "" if setting.value is None else toml_value(setting.value)
        line = f"{'' if value else '# '}{setting.key} = {value}"
        lines.append(f"{line}  # {setting.unit}" if setting.unit else line)
    return "\n".join(lines) + "\n"


def toml_value(value: Any) -> str:
    """A value as it stands in a TOML file.

    >>> toml_value((1.0, 2.5)), toml_value(True), toml_value("auto")
    ('[1.0, 2.5]', 'true', '"auto"')
    """
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"'
        case tuple():
            return f"[{', '.join(map(toml_value, value))}]"
        case _:
            return repr(value)


def read(path: Path) -> Configuration:
    """Read a TOML file; what it leaves out keeps its default.

    Raises
    ------
    InputError
        It cannot be read, is no TOML, or holds an unknown key or a value of the wrong type.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reason = (error.strerror if isinstance(error, OSError) else None) or error
        raise InputError(
            f"'{path}': expected a file of settings in TOML, it cannot be read: {reason}; "
            "`crispline --dump-options` writes one"
        ) from error
    return read_text(text, f"'{path}'")


def read_text(text: str, where: str = "settings") -> Configuration:
    """Read settings from TOML text.

    Parameters
    ----------
    text : for example what `to_toml` returns, or a part of it.
    where : what to call the text in a message.

    Raises
    ------
    InputError
        No TOML, an unknown key, or a value of the wrong type.
    """
    try:
        content = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(
            f"{where}: expected settings in TOML, lines such as `fill_holes = 6.0` under "
            f"`[net]`, found something else: {error}"
        ) from error
    known = {setting.name: setting for setting in settings()}
    values: dict[str, Any] = {}
    for name, value in _leaves(content, "", known):
        setting = known.get(name)
        if setting is None:
            raise InputError(f"{where}: {_unknown(name, value, known)}")
        try:
            values[name] = _value(setting.kind, value)
        except (TypeError, ValueError, OverflowError) as error:
            raise InputError(
                f"{where}: '{name}': expected {_expected(setting.kind)}, found {_found(value)}"
            ) from error
    return Configuration(_made(Options, "", values), _made(SharpenOptions, "sharpen.", values))


def _meanings() -> dict[tuple[str, str], str]:
    """The text under every field of `crispline.options`, by class and field."""
    found = {}
    for node in ast.parse(inspect.getsource(source)).body:
        if isinstance(node, ast.ClassDef):
            for one, after in zip(node.body, node.body[1:], strict=False):
                if isinstance(one, ast.AnnAssign) and isinstance(one.target, ast.Name):
                    text = ast.literal_eval(after.value) if isinstance(after, ast.Expr) else ""
                    found[node.name, one.target.id] = " ".join(text.split())
    return found


def _walk(given: Any, prefix: str, meanings: Mapping[tuple[str, str], str]) -> Iterator[Setting]:
    kinds = get_type_hints(type(given))
    for one in fields(given):
        value = getattr(given, one.name)
        if is_dataclass(value):
            yield from _walk(value, f"{prefix}{one.name}.", meanings)
        else:
            meaning = meanings[type(given).__name__, one.name]
            yield Setting(f"{prefix}{one.name}", kinds[one.name], value, meaning)


def _table_meaning(table: str) -> str:
    owner = SharpenOptions if table == "sharpen" else get_type_hints(Options)[table]
    return str(inspect.getdoc(owner)).split(", see ")[0].rstrip(".") + "."


def _leaves(
    content: Mapping[str, Any], prefix: str, known: Mapping[str, Setting]
) -> Iterator[tuple[str, Any]]:
    """Dotted names and values; a table is a value only where none belongs, or if it is empty."""
    for key, value in content.items():
        name = f"{prefix}{key}"
        is_table = any(one.startswith(f"{name}.") for one in known)
        if isinstance(value, dict) and name not in known and (value or is_table):
            yield from _leaves(value, f"{name}.", known)
        else:
            yield name, value


def _unknown(name: str, value: Any, known: Mapping[str, Setting]) -> str:
    """What is wrong with a name that is not known, and which was meant."""
    if any(one.startswith(f"{name}.") for one in known):
        return f"'{name}': expected a table `[{name}]`, found {_found(value)}"
    key = name.rpartition(".")[2]
    meant = [one for one in known if known[one].key == key] or get_close_matches(name, known, 1)
    hint = f"did you mean '{meant[0]}'?" if meant else "`crispline --dump-options` lists them"
    return f"unknown key '{name}'; {hint}"


def _made(kind: Any, prefix: str, values: Mapping[str, Any]) -> Any:
    """An options class from the values whose names begin with the prefix."""
    kinds = get_type_hints(kind)
    given = {}
    for one in fields(kind):
        name = f"{prefix}{one.name}"
        if is_dataclass(kinds[one.name]):
            given[one.name] = _made(kinds[one.name], f"{name}.", values)
        elif name in values:
            given[one.name] = values[name]
    return kind(**given)


def _value(kind: Any, value: Any) -> Any:
    """A value of TOML as one of the type of a setting; ValueError or TypeError if it is none."""
    arguments = get_args(kind)
    if get_origin(kind) is Literal:
        return arguments[arguments.index(value)]
    if get_origin(kind) is tuple:
        n_items = len(value) if arguments[-1] is ... else len(arguments)
        if not isinstance(value, list) or not value or len(value) != n_items:
            raise ValueError
        return tuple(_value(arguments[0], item) for item in value)
    if NoneType in arguments:
        return _value(arguments[0], value)
    if kind is bool or isinstance(value, bool):
        if not (kind is bool and isinstance(value, bool)):
            raise TypeError
        return value
    if not isinstance(value, int if kind is int else (int, float)) or not 0 <= value < math.inf:
        raise ValueError
    return kind(value)


def _expected(kind: Any) -> str:
    """What a value of a type looks like, in words."""
    arguments = get_args(kind)
    if get_origin(kind) is Literal:
        return " or ".join(f'"{one}"' for one in arguments)
    if get_origin(kind) is tuple:
        number = "" if arguments[-1] is ... else f"{len(arguments)} "
        return f"a list of {number}{'whole ' if arguments[0] is int else ''}numbers of 0 or more"
    if NoneType in arguments:
        return _expected(arguments[0])
    if kind is bool:
        return "true or false"
    return f"a {'whole ' if kind is int else ''}number of 0 or more"


def _found(value: Any) -> str:
    """A value of TOML in words."""
    if isinstance(value, dict):
        return "a table"
    return str(value) if not isinstance(value, bool | str | list) else _quoted(value)


def _quoted(value: Any) -> str:
    return toml_value(tuple(value) if isinstance(value, list) else value)
