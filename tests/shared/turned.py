"""Patches and raw points of turned parts whose faces are known exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from witnessed import witnessed

from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit

SIGMA = 0.15


@dataclass(frozen=True)
class Turned:
    """A profile, corners in ``(radius, height)``, turned about the z axis or swept along it.

    Attributes
    ----------
    evidence : patches a unit apart along the profile and ``n_around`` about it.
    face : which segment of the profile each patch is on, shape ``(m,)``.
    """

    evidence: Evidence
    face: np.ndarray

    def fits(self, surfaces, label):
        """The surfaces by their label, with the raw points of their patches."""
        return {
            name: held_fit(surface, np.flatnonzero(label == name), self.evidence)
            for name, surface in surfaces.items()
        }


def turned(corners, n_around, is_straight=False, sigma=SIGMA):
    """The part of a profile; a straight one has unit patches along y instead of round z."""
    corners = np.asarray(corners, dtype=float)
    steps = np.diff(corners, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    counts = np.maximum(np.round(lengths).astype(int), 1)
    rows = [
        (corners[i] + (k + 0.5) / n * steps[i], steps[i] / lengths[i], i)
        for i, n in enumerate(counts)
        for k in range(n)
    ]
    place = np.array([row[0] for row in rows]).repeat(n_around, axis=0)
    along = np.array([row[1] for row in rows]).repeat(n_around, axis=0)
    face = np.array([row[2] for row in rows]).repeat(n_around)
    number = np.arange(len(face)).reshape(len(rows), n_around)
    turn = np.tile(np.arange(n_around), len(rows))
    outward = np.column_stack([-along[:, 1], along[:, 0]])  # the part is right of the profile
    if is_straight:
        points = np.column_stack([place[:, 0], turn.astype(float), place[:, 1]])
        normals = np.column_stack([outward[:, 0], np.zeros(len(turn)), outward[:, 1]])
        across = [number[:, :-1], number[:, 1:]]
    else:
        angle = 2.0 * np.pi * turn / n_around
        spoke = np.column_stack([np.cos(angle), np.sin(angle)])
        points = np.column_stack([place[:, :1] * spoke, place[:, 1]])
        normals = np.column_stack([outward[:, :1] * spoke, outward[:, 1]])
        across = [number, np.roll(number, -1, axis=1)]
    pairs = np.concatenate(
        [
            np.column_stack([number[:-1].ravel(), number[1:].ravel()]),
            np.column_stack([part.ravel() for part in across]),
        ]
    )
    return Turned(witnessed(points, normals, pairs, sigma), face)
