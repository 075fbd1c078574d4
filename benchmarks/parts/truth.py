"""What is exactly known of a scan, and the file that it is kept in."""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from crispline.files import atomic_path
from crispline.surface.base import Array


@dataclass(frozen=True)
class Features:
    """Sharp edges as polylines, and their corners.

    Attributes
    ----------
    polylines : each of shape ``(k, 3)``; a closed one ends where it starts.
    kinds : per polyline ``sharp`` or ``boundary`` (border of an open surface).
    corners : shape ``(c, 3)``.
    corner_kinds : per corner ``corner`` (three or more sharp ends), ``kink`` (two that
        turn), ``end`` (a crease that dies out) or ``apex`` (tip of a cone).
    """

    polylines: tuple[Array, ...]
    kinds: tuple[str, ...]
    corners: Array
    corner_kinds: tuple[str, ...]

    def sharp(self, step: float) -> Array:
        """Points at most ``step`` apart along the sharp polylines, ends included."""
        pieces = [
            _resampled(line, step)
            for line, kind in zip(self.polylines, self.kinds, strict=True)
            if kind == "sharp"
        ]
        return np.concatenate([np.empty((0, 3)), *pieces])

    def scored_corners(self) -> Array:
        """Corners and kinks; where a crease dies out is a matter of opinion."""
        keep = [kind in ("corner", "kink") for kind in self.corner_kinds]
        return np.asarray(self.corners[np.array(keep, dtype=bool)])


@dataclass(frozen=True)
class Truth:
    """A scan with what it is a scan of; lengths in the unit of the part.

    Attributes
    ----------
    points : the noisy scan, shape ``(n, 3)``.
    clean : the same points on the surface, shape ``(n, 3)``.
    normals : outward unit normals there; NaN where nobody knows them.
    face_ids : the face of each point, shape ``(n,)``.
    features : sharp edges and corners.
    n_faces : faces of the part, or None: the facets of a mesh are no faces.
    spacing : mean distance between neighbouring points.
    diagonal : of the bounding box.
    noise : standard deviation of each coordinate over the diagonal.
    is_open : whether the surface has a border.
    """

    points: Array
    clean: Array
    normals: Array
    face_ids: NDArray[np.int64]
    features: Features
    n_faces: int | None
    spacing: float
    diagonal: float
    noise: float
    is_open: bool


def write_truth(path: Path, truth: Truth, area: float) -> None:
    """Save a truth as NPZ.

    Fields: ``points``, ``points_clean``, ``normals``, ``face_id``; ``poly_pts`` with
    polyline ``k`` in rows ``poly_off[k]`` to ``poly_off[k + 1]``; ``poly_kind``;
    ``corners``, ``corner_kind``; ``meta``, a JSON text with ``type`` (``step`` for a
    part, ``mesh``, ``wire``), ``n_faces``, ``area``, ``diag`` and ``options.noise``.
    """
    meta = {
        "type": "step",
        "n_faces": truth.n_faces,
        "area": area,
        "diag": truth.diagonal,
        "options": {"noise": truth.noise},
    }
    lines = truth.features.polylines
    with atomic_path(path) as draft:
        np.savez_compressed(
            draft,
            points=truth.points,
            points_clean=truth.clean,
            normals=truth.normals,
            face_id=truth.face_ids,
            poly_pts=np.concatenate([np.empty((0, 3)), *lines]),
            poly_off=np.cumsum([0, *map(len, lines)]),
            poly_kind=np.array(truth.features.kinds, dtype=str),
            corners=truth.features.corners,
            corner_kind=np.array(truth.features.corner_kinds, dtype=str),
            meta=json.dumps(meta),
        )


def read_truth(path: Path) -> Truth:
    """Inverse of :func:`write_truth`; files of other programs may hold more fields."""
    with np.load(path, allow_pickle=False) as stored:
        fields = {name: stored[name] for name in stored.files}
    meta = json.loads(str(fields["meta"]))
    clean, ends = fields["points_clean"], fields["poly_off"]
    kinds = tuple(map(str, fields["poly_kind"]))
    if "area" in meta:
        spacing = float(np.sqrt(meta["area"] / len(clean)))
    else:  # an annotated scan: nobody knows its area
        distances, _ = cKDTree(clean).query(clean, k=[2])
        spacing = float(np.median(distances))
    return Truth(
        points=fields["points"],
        clean=clean,
        normals=fields["normals"],
        face_ids=fields["face_id"].astype(np.int64),
        features=Features(
            tuple(fields["poly_pts"][a:b] for a, b in pairwise(ends)),
            kinds,
            fields["corners"].reshape(-1, 3),
            tuple(map(str, fields["corner_kind"])),
        ),
        n_faces=int(meta["n_faces"]) if meta.get("type") == "step" else None,
        spacing=spacing,
        diagonal=float(meta["diag"]),
        noise=float(meta.get("options", {}).get("noise", 0.0)),
        is_open="boundary" in kinds,
    )


def _resampled(line: Array, step: float) -> Array:
    lengths = np.linalg.norm(np.diff(line, axis=0), axis=1)
    at = np.concatenate([[0.0], np.cumsum(lengths)])
    if at[-1] == 0.0:
        return np.empty((0, 3))
    wanted = np.linspace(0.0, at[-1], max(2, int(np.ceil(at[-1] / step)) + 1))
    return np.column_stack([np.interp(wanted, at, line[:, axis]) for axis in range(3)])
