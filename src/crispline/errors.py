"""The catalogue of errors. Each message says what was expected, what came, where, what to try."""

from __future__ import annotations


class CrisplineError(Exception):
    """Base class; ``exit_code`` is what the command line returns."""

    exit_code = 1


class InputError(CrisplineError):
    """The file, the cloud or an option cannot be used. Exit code 2."""

    exit_code = 2


class ReconstructionError(CrisplineError):
    """No valid model could be made from usable input. Exit code 3.

    ``partial`` holds what was good when the run stopped (for example a
    :class:`crispline.result.Reconstruction` without a solid), or None.
    """

    exit_code = 3

    def __init__(self, message: str, partial: object | None = None) -> None:
        super().__init__(message)
        self.partial = partial
