"""Which true faces a model recovers, and how large they are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from crispline.surface.base import Array
from parts.truth import Truth

INRADII = (3.0, 5.0)
"""Bounds between small, middling and large faces, in spacings."""
_NEIGHBOURS = 8
_OPPOSED_DEG = 120.0
"""Points that look away from each other lie on two sides of a wall, not beside each other."""
_SMOOTH_DEG = 3.0
"""Two faces may be one surface if their normals agree within this across their border, beyond
what the surfaces turn on the way from one point to the next."""
_SAME_SURFACE = 1e-4
"""Largest distance from the common quadric of two faces that are one surface, in spacings."""
_FEW = 12
"""Faces with fewer points are not tried: a quadric has 9 degrees of freedom."""
_MATCH = 0.8
"""Share of a true face's points on a model face, and of that one's on it, that is a match."""


@dataclass(frozen=True)
class TrueFaces:
    """The faces that can be told apart: neighbours on one surface, tangent to each other, count
    as one, since nobody can see how the CAD system has cut them.

    Attributes
    ----------
    label : face of every clean point, shape ``(n,)``.
    given : the same as the CAD system has cut them.
    inradius : per face, the largest distance of its points from its border, in spacings;
        infinite for a face without a border. A face without points has none at all.
    """

    label: NDArray[np.int64]
    given: NDArray[np.int64]
    inradius: Array


def true_faces(truth: Truth) -> TrueFaces:
    """Merge, count and measure the faces of a truth."""
    n_near = min(_NEIGHBOURS + 1, len(truth.clean))
    near = np.asarray(cKDTree(truth.clean).query(truth.clean, k=range(2, n_near + 1))[1])
    facing = np.einsum("nd,nkd->nk", truth.normals, truth.normals[near])
    is_beside = ~(facing < np.cos(np.radians(_OPPOSED_DEG)))
    given = np.unique(truth.face_ids, return_inverse=True)[1].astype(np.int64)
    label = _merged(truth, given, near, is_beside, facing)
    is_border = ((label[near] != label[:, None]) & is_beside).any(axis=1)
    borders = [line for line, kind in _polylines(truth) if kind == "boundary"]
    inradius = np.full(label.max() + 1, np.inf)
    for face in range(len(inradius)):
        own = label == face
        # A border point lies about half a spacing inside the border.
        rim = np.concatenate([truth.clean[own & is_border], *borders])
        if len(rim):
            distance = np.asarray(cKDTree(rim).query(truth.clean[own])[0])
            inradius[face] = distance.max() / truth.spacing + 0.5
    return TrueFaces(label, given, inradius)


def recovered(faces: TrueFaces, model_face: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which true faces have a model face of their own, shape ``(n_true,)``.

    Parameters
    ----------
    model_face : the model's face nearest to every clean point, shape ``(n,)``.

    Notes
    -----
    One to one: 80 % of the points of the true face lie on one model face, and 80 % of the
    points of that one lie on the true face. Or so for all the pieces it is cut into.
    """
    is_missed = np.zeros(len(faces.inradius), dtype=bool)
    is_missed[faces.label[~_is_matched(faces.given, model_face)[faces.given]]] = True
    return np.asarray(_is_matched(faces.label, model_face) | ~is_missed)


def by_inradius(faces: TrueFaces, is_recovered: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Recovered faces and all faces, for small, middling and large ones."""
    size = np.digitize(faces.inradius, INRADII)
    return [
        (int(is_recovered[size == group].sum()), int((size == group).sum()))
        for group in range(len(INRADII) + 1)
    ]


def _is_matched(label: NDArray[np.int64], model_face: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which of the labelled faces have a model face of their own, shape ``(n_labels,)``."""
    shape = (int(label.max()) + 1, int(model_face.max()) + 1)
    shared = coo_array((np.ones(len(label)), (label, model_face)), shape=shape).toarray()
    best = shared.argmax(axis=1)
    overlap = shared[np.arange(shape[0]), best]
    return np.asarray(
        (overlap >= _MATCH * shared.sum(axis=1)) & (overlap >= _MATCH * shared.sum(axis=0)[best])
    )


def _polylines(truth: Truth) -> list[tuple[Array, str]]:
    return list(zip(truth.features.polylines, truth.features.kinds, strict=True))


def _merged(
    truth: Truth,
    label: NDArray[np.int64],
    near: NDArray[np.int64],
    is_beside: NDArray[np.bool_],
    facing: Array,
) -> NDArray[np.int64]:
    """Faces numbered anew, those on one smooth surface together, shape ``(n,)``."""
    other = label[near]
    across = (other != label[:, None]) & is_beside
    pairs = np.column_stack([np.broadcast_to(label[:, None], other.shape)[across], other[across]])
    turn = np.degrees(np.arccos(np.clip(facing[across], -1.0, 1.0)))
    pairs.sort(axis=1)
    joined: list[tuple[int, int]] = []
    for a, b in np.unique(pairs, axis=0).tolist():
        here = (pairs == (a, b)).all(axis=1)
        inside = [np.flatnonzero(label == face) for face in (a, b)]
        if min(map(len, inside)) < _FEW:
            continue
        own_turn = max(_own_turn(truth, label, near, points) for points in inside)
        if np.median(turn[here]) < _SMOOTH_DEG + own_turn and _is_one_quadric(truth, *inside):
            joined.append((a, b))
    rows, columns = np.array(joined, dtype=np.int64).reshape(-1, 2).T
    n_faces = int(label.max()) + 1
    links = coo_array((np.ones(len(rows)), (rows, columns)), shape=(n_faces, n_faces))
    group = connected_components(links, directed=False)[1]
    return np.asarray(group[label], dtype=np.int64)


def _own_turn(
    truth: Truth, label: NDArray[np.int64], near: NDArray[np.int64], points: NDArray[np.int64]
) -> float:
    """Median angle in degrees between neighbouring normals within a face."""
    neighbours = near[points]
    cosine = np.einsum("nd,nkd->nk", truth.normals[points], truth.normals[neighbours])
    own = cosine[label[neighbours] == label[points][:, None]]
    return float(np.degrees(np.median(np.arccos(np.clip(own, -1.0, 1.0))))) if len(own) else 0.0


def _is_one_quadric(truth: Truth, *inside: NDArray[np.int64]) -> bool:
    """Whether one quadric (plane, cylinder, cone, sphere...) passes through two faces.

    Taubin's fit would be fairer; here the points are exact, so any fit will do.
    """
    points = np.concatenate([truth.clean[rows] for rows in inside])
    middle = points.mean(axis=0)
    size = float(np.abs(points - middle).max())
    x, y, z = ((points - middle) / size).T
    columns = [x * x, y * y, z * z, x * y, y * z, z * x, x, y, z, np.ones_like(x)]
    _, _, rows = np.linalg.svd(np.column_stack(columns), full_matrices=False)
    a, b, c, d, e, f, g, h, i, _ = rows[-1]
    value = np.column_stack(columns) @ rows[-1]
    gradient = np.column_stack(
        [
            2 * a * x + d * y + f * z + g,
            2 * b * y + d * x + e * z + h,
            2 * c * z + e * y + f * x + i,
        ]
    )
    slope = np.maximum(np.linalg.norm(gradient, axis=1), 1e-6)
    return bool(np.quantile(np.abs(value) / slope, 0.99) * size < _SAME_SURFACE * truth.spacing)
