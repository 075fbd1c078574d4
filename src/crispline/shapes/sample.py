"""Simulated scans: points on a shape, then noise and outliers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from crispline.errors import InputError
from crispline.files import atomic_path, check_output
from crispline.shapes.shape import Shape, ShapeFace
from crispline.surface.base import Array, unit

Sampling = Literal["grid", "half-cell", "random"]
SAMPLINGS: tuple[Sampling, ...] = get_args(Sampling)

_OUTLIER_BOX = 1.1
_SAME_POINT = 1e-9


@dataclass(frozen=True, eq=False)
class Sample:
    """A simulated scan with its truth.

    Attributes
    ----------
    points : the scan, shape ``(n + m, 3)``; the last ``m`` points are outliers.
    clean : the points before noise, exactly on the shape, shape ``(n, 3)``.
    normals : outward unit normals there, shape ``(n, 3)``.
    face_ids : the face of each, an index into ``shape.faces``, shape ``(n,)``.
    spacing : ``sqrt(area / n)``.
    shape : what was sampled.
    """

    points: Array
    clean: Array
    normals: Array
    face_ids: NDArray[np.int64]
    spacing: float
    shape: Shape


def sample(
    shape: Shape,
    n_points: int,
    *,
    sampling: Sampling = "random",
    noise: float = 0.0,
    outliers: float = 0.0,
    seed: int = 0,
) -> Sample:
    """Simulate a scan.

    Parameters
    ----------
    shape : what to scan.
    n_points : points on the shape; the two grids come close to this number.
    sampling : ``random`` is uniform by area. ``grid`` lays square cells on every
        face, the outermost rows of points on the borders of its parameter
        rectangle. ``half-cell`` puts a point in the middle of every cell, so
        edges run midway between rows. Trimmed faces keep the grid points inside.
    noise : the paper's level. Every point moves in a random direction by
        ``noise * shape.length / 8`` exactly.
    outliers : further points, as a fraction of the points on the shape, uniform
        in the bounding box grown by 10 %.
    seed : the same seed gives the same scan; noise and outliers have streams of
        their own, so changing one leaves the rest alone.

    Raises
    ------
    InputError
        Fewer than one point, a negative or non-finite noise or outlier fraction.
    """
    if n_points < 1:
        raise InputError(f"number of points: expected 1 or more, got {n_points}")
    for name, value in (("noise", noise), ("outliers", outliers)):
        if not (np.isfinite(value) and value >= 0.0):
            raise InputError(f"{name}: expected a finite fraction of 0 or more, got {value}")

    position_stream, noise_stream, outlier_stream = np.random.default_rng(seed).spawn(3)
    if sampling == "random":
        parts = _random_parts(shape, n_points, position_stream)
    else:
        cell = float(np.sqrt(shape.area / n_points))
        parts = [_grid(face, cell, on_border=sampling == "grid") for face in shape.faces]
    evaluated = [face.evaluate(u, v) for face, (u, v) in zip(shape.faces, parts, strict=True)]
    clean = np.concatenate([points for points, _ in evaluated])
    normals = np.concatenate([normals for _, normals in evaluated])
    face_ids = np.repeat(np.arange(len(parts)), [len(u) for u, _ in parts])
    if sampling == "grid":  # faces share the points on their common edges
        first = _first_of_each(clean, _SAME_POINT * shape.length)
        clean, normals, face_ids = clean[first], normals[first], face_ids[first]

    directions = unit(noise_stream.normal(size=clean.shape))
    noisy = clean + noise * shape.length / 8.0 * directions
    n_outliers = round(outliers * len(clean))
    low, high = clean.min(axis=0), clean.max(axis=0)
    stray = (low + high) / 2.0 + _OUTLIER_BOX * (high - low) * (
        outlier_stream.random((n_outliers, 3)) - 0.5
    )
    return Sample(
        points=np.concatenate([noisy, stray]),
        clean=clean,
        normals=normals,
        face_ids=face_ids,
        spacing=float(np.sqrt(shape.area / len(clean))),
        shape=shape,
    )


def write_truth(path: Path, scan: Sample) -> None:
    """Save what is exactly known of a scan as NPZ.

    Fields: ``points`` (clean), ``normals``, ``face_ids``, ``face_kinds``,
    ``edges`` ``(e, 100, 3)``, ``edge_kinds``, ``corners``, ``spacing``, ``length``.

    Raises
    ------
    InputError
        Another suffix than ``.npz``, or the file cannot be written.
    """
    check_output(path, (".npz",))
    shape = scan.shape
    with atomic_path(path) as draft:
        np.savez_compressed(
            draft,
            points=scan.clean,
            normals=scan.normals,
            face_ids=scan.face_ids,
            face_kinds=np.array([face.kind for face in shape.faces]),
            edges=np.array([edge.points for edge in shape.edges]),
            edge_kinds=np.array([edge.kind for edge in shape.edges]),
            corners=shape.corners,
            spacing=scan.spacing,
            length=shape.length,
        )


def _random_parts(
    shape: Shape, n_points: int, stream: np.random.Generator
) -> list[tuple[Array, Array]]:
    areas = np.array([face.area_and_stretch[0] for face in shape.faces])
    counts = stream.multinomial(n_points, areas / areas.sum())
    return [
        _random(face, int(count), stream) for face, count in zip(shape.faces, counts, strict=True)
    ]


def _random(face: ShapeFace, n_points: int, stream: np.random.Generator) -> tuple[Array, Array]:
    """Parameters uniform by area: draws in the rectangle, rejected by trim and area element."""
    _, largest = face.area_and_stretch
    accepted = np.empty((0, 2))
    while len(accepted) < n_points:
        u, v, level = stream.random((3, max(n_points, 64)))
        u = face.u[0] + u * (face.u[1] - face.u[0])
        v = face.v[0] + v * (face.v[1] - face.v[0])
        keep = face.contains(u, v) & (level * largest <= face.stretch(u, v))
        accepted = np.concatenate([accepted, np.column_stack([u, v])[keep]])
    return accepted[:n_points, 0], accepted[:n_points, 1]


def _grid(face: ShapeFace, cell: float, *, on_border: bool) -> tuple[Array, Array]:
    """Parameters of a regular grid of about square cells, clipped to the trimmed face."""
    n_u, n_v = (max(1, round((end - start) / cell)) for start, end in (face.u, face.v))
    if on_border:
        grid_u, grid_v = np.meshgrid(
            np.linspace(*face.u, n_u + 1)[: n_u if face.is_closed_u else None],
            np.linspace(*face.v, n_v + 1),
            indexing="ij",
        )
        u, v = grid_u.ravel(), grid_v.ravel()
    else:
        u, v = face.midpoints(n_u, n_v)
    keep = face.contains(u, v)
    return u[keep], v[keep]


def _first_of_each(points: Array, tolerance: float) -> NDArray[np.intp]:
    """Indices of the distinct points, in order."""
    cells = np.round(points / tolerance).astype(np.int64)
    return np.sort(np.unique(cells, axis=0, return_index=True)[1])
