"""Clouds in the files of NumPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crispline.cloud.raw import RawCloud
from crispline.errors import InputError

_POINTS = ("points", "xyz", "vertices", "positions")
_NORMALS = ("normals", "point_normals")
_VIEWPOINTS = ("viewpoints",)


def read_npy(path: Path) -> RawCloud:
    """An array of shape ``(n, 3)`` or wider, of which the first three columns count."""
    return RawCloud(_columns(np.load(path, allow_pickle=False)))


def read_npz(path: Path) -> RawCloud:
    """Named arrays: ``points`` (or ``xyz``, ``vertices``, ``positions``) or the only one.

    ``normals`` (or ``point_normals``) and ``viewpoints`` go with them, where the
    file has as many rows of them as points.

    Raises
    ------
    InputError
        Several arrays, none of them of such a name.
    """
    with np.load(path, allow_pickle=False) as content:
        names = list(content.files)
        name = _first(names, _POINTS) or (names[0] if len(names) == 1 else None)
        if name is None:
            raise InputError(
                f"'{path}': expected an array named 'points', found "
                f"{', '.join(repr(name) for name in names) or 'no array'}; rename one"
            )
        points = _columns(content[name])
        normals, viewpoints = (
            content[found] if (found := _first(names, wanted)) else None
            for wanted in (_NORMALS, _VIEWPOINTS)
        )
    return RawCloud(points, _alike(normals, points), _alike(viewpoints, points))


def _first(names: list[str], wanted: tuple[str, ...]) -> str | None:
    return next((name for name in wanted if name in names), None)


def _columns(array: NDArray[np.generic]) -> NDArray[np.generic]:
    # Three rows are more likely a transposed cloud, which is refused later.
    return array[:, :3] if array.ndim == 2 and array.shape[0] != 3 else array


def _alike(
    values: NDArray[np.generic] | None, points: NDArray[np.generic]
) -> NDArray[np.generic] | None:
    return values if values is not None and values.shape == points.shape else None
