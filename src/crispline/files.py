"""Input files that can be read, output files that appear whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from crispline.errors import InputError


@contextmanager
def readable(path: Path, suffixes: Collection[str], expected: str) -> Iterator[None]:
    """Refuse an input file that cannot be read, before and while the block reads it.

    Parameters
    ----------
    path : file to be read.
    suffixes : allowed suffixes, lower case and with the dot.
    expected : what the file should hold, for the message about an empty one.

    Raises
    ------
    InputError
        Missing or empty file, a folder, unknown suffix, or the system refused to read.
    """
    if path.is_dir():
        raise InputError(f"'{path}': expected a file, found a folder; name a file inside it")
    if not path.exists():
        raise InputError(f"'{path}': no such file; check the name and the folder")
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"'{path}': expected a name that ends in one of {', '.join(suffixes)}, "
            f"found '{path.suffix or path.name}'; convert the file to one of them"
        )
    try:
        if path.stat().st_size == 0:
            raise InputError(f"'{path}': expected {expected}, found an empty file; export it again")
        yield
    except OSError as error:
        raise InputError(f"'{path}': cannot be read: {error.strerror or error}") from error


@contextmanager
def decoded(path: Path, expected: str) -> Iterator[None]:
    """Turn whatever a format library raises on a damaged file into an `InputError`.

    Parameters
    ----------
    path : the file that the block decodes.
    expected : what it should be, for example ``a PLY file``.
    """
    try:
        yield
    except (InputError, OSError):
        raise
    except Exception as error:
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(
            f"'{path}': expected {expected}, found content that cannot be read as one ({reason}); "
            "check that it is complete and its suffix right"
        ) from error


def check_output(path: Path, suffixes: Collection[str]) -> None:
    """Refuse an output path that cannot be written, before any work is done.

    Parameters
    ----------
    path : file to be written; it may exist already and is then replaced.
    suffixes : allowed suffixes, lower case and with the dot.

    Raises
    ------
    InputError
        Unknown suffix, missing or read-only folder, or the path is a folder.
    """
    if path.suffix.lower() not in suffixes:
        raise InputError(
            f"cannot write '{path}': expected a name that ends in {' or '.join(suffixes)}, "
            f"got '{path.suffix or path.name}'"
        )
    if path.is_dir():
        raise InputError(f"cannot write '{path}': it is a folder; give a file name inside it")
    if not path.parent.is_dir():
        raise InputError(
            f"cannot write '{path}': the folder '{path.parent}' does not exist; make it first"
        )
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise InputError(
            f"cannot write '{path}': the folder '{path.parent}' is read-only; choose another"
        )


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a path of the same name to write to; it replaces ``path`` if the block succeeds.

    The file is written in a temporary folder beside ``path``, so the final
    rename stays on one file system. If the block raises (Ctrl-C included),
    ``path`` keeps its old content, or its absence.

    Raises
    ------
    InputError
        The system refused to write, for example because the disk is full.
    """
    path = path.resolve()  # a link is followed, not replaced
    try:
        with tempfile.TemporaryDirectory(dir=path.parent, prefix=".crispline-") as folder:
            draft = Path(folder) / path.name
            yield draft
            draft.replace(path)
    except OSError as error:
        raise InputError(
            f"cannot write '{path}': {error.strerror or error}; free space or choose another place"
        ) from error


def write_text(path: Path, text: str) -> None:
    """Write a text file (UTF-8) whole or not at all. Raises `InputError` if it cannot."""
    with atomic_path(path) as draft:
        draft.write_text(text, encoding="utf-8")
