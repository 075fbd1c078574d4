"""Packages that only some files or views need, imported when they are."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from crispline.errors import InputError


def required(package: str) -> Any:
    """The module ``package``, whose objects the user asked for.

    Raises
    ------
    InputError
        It cannot be imported; the sentence says what to do.
    """
    try:
        return import_module(package)
    except ImportError as error:
        raise InputError(
            f"expected the package '{package}', found none that can be imported ({error}); "
            f"install it with: pip install {package}, or go through a file"
        ) from error


def optional(package: str, extra: str, purpose: str) -> Any:
    """The module ``package``, which the extra ``extra`` of crispline installs.

    Parameters
    ----------
    package : name to import; its types are not known here.
    extra : as in ``pip install 'crispline[extra]'``.
    purpose : what it is needed for, for the message: ``LAS files``.

    Raises
    ------
    InputError
        It is not installed; the sentence says what to install.
    """
    try:
        return import_module(package)
    except ImportError as error:
        raise InputError(
            f"{purpose}: expected the package '{package.partition('.')[0]}', found none that can "
            f"be imported; install it with: pip install 'crispline[{extra}]'"
        ) from error
