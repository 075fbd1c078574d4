"""Surfaces as NumPy archives.

The fields are those of `TensorSpline`: ``degree_u``, ``degree_v``, ``knots_u``,
``knots_v``, ``control_points`` of shape ``(n_u, n_v, 3)`` and, only if rational,
``weights`` of shape ``(n_u, n_v)``. The fields of a second, third ... surface end
in ``_2``, ``_3`` ...
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.files import atomic_path
from crispline.spline.checked import checked_spline
from crispline.spline.tensor import TensorSpline

_FIELDS = ("degree_u", "degree_v", "knots_u", "knots_v", "control_points")


def read_npz(path: Path) -> tuple[TensorSpline, ...]:
    """The surfaces in an archive.

    Raises
    ------
    InputError
        Not an archive, fields missing, or numbers that make no sense.
    """
    try:
        with path.open("rb") as file:
            archive = np.load(file, allow_pickle=False)
            if not isinstance(archive, np.lib.npyio.NpzFile):
                raise ValueError("a single array, as in an NPY file")
            fields = {name: archive[name] for name in archive.files}
    except OSError:
        raise
    except Exception as error:  # zip, its checksums and NumPy raise anything on a damaged file
        raise InputError(
            f"'{path}': expected an NPZ archive, found content that cannot be read as one "
            f"({error}); check that it is complete"
        ) from error
    splines = [_spline(fields, "", f"'{path}'")]
    while f"control_points_{len(splines) + 1}" in fields:
        number = len(splines) + 1
        splines.append(_spline(fields, f"_{number}", f"'{path}', surface {number}"))
    return tuple(splines)


def _spline(fields: Mapping[str, NDArray[np.generic]], suffix: str, where: str) -> TensorSpline:
    missing = [name + suffix for name in _FIELDS if name + suffix not in fields]
    if missing:
        raise InputError(
            f"{where}: expected the fields {', '.join(name + suffix for name in _FIELDS)}, "
            f"found no {' and no '.join(missing)}; a grid of points belongs in an NPY file"
        )
    degree_u, degree_v, knots_u, knots_v, net = (fields[name + suffix] for name in _FIELDS)
    if (
        degree_u.shape
        or degree_v.shape
        or not all(d.dtype.kind in "iu" for d in (degree_u, degree_v))
    ):
        raise InputError(
            f"{where}: expected a whole number for each degree, found {degree_u} and {degree_v}; "
            "store them as integers"
        )
    weights = fields.get("weights" + suffix)
    return checked_spline(int(degree_u), int(degree_v), knots_u, knots_v, net, weights, where)


def write_npz(path: Path, splines: Sequence[TensorSpline]) -> None:
    """Write surfaces as an archive; the same bytes for the same surfaces, every digit kept."""
    fields: dict[str, NDArray[np.generic]] = {}
    for number, spline in enumerate(splines, start=1):
        suffix = "" if number == 1 else f"_{number}"
        fields |= {name + suffix: np.asarray(getattr(spline, name)) for name in _FIELDS}
        if spline.weights is not None:
            fields["weights" + suffix] = spline.weights
    with atomic_path(path) as draft:
        np.savez(draft, allow_pickle=False, **fields)
