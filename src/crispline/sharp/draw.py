"""Borders and corners of a sculpture: drawn between their surfaces, where they are sharp.

Its model is of patches, which need creases to follow and nothing else. No curve on two
surfaces is solved for, and where a border is smooth the net is as good a place as any.
There are thousands of borders, and each asks for a few points only: so all of them are
drawn together, and each surface is asked once for all of its points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crispline.curve import Curve, interpolated, resampled
from crispline.options import LocateOptions
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain
from crispline.sharp.between import N_ROUNDS, curve_through, open_curve, points_along
from crispline.sharp.contact import Contact
from crispline.sharp.corner import Corner
from crispline.sharp.crease import Border, Crease, Ends
from crispline.sharp.feet import feet_on_each
from crispline.sharp.network import labels_beside, side_labels
from crispline.sharp.trace import Guide
from crispline.surface.base import Array
from crispline.surface.intersect import CUTOFF

_N_PLACES = 15  # along a guide, to tell its angle
_N_SMOOTH = 8  # of the curve of a smooth border
_N_SAMPLES = 25  # of a curve, to measure it
_NEWTON_STEPS = 2


@dataclass(frozen=True)
class Drawing:
    """Draws the borders and corners between fitted surfaces.

    Attributes
    ----------
    regions : the surface of every label.
    options : what is accepted.
    """

    regions: Mapping[int, RegionFit]
    options: LocateOptions

    def borders(self, chains: Sequence[Chain], guides: Sequence[Guide]) -> list[Border]:
        """Borders: contacts where the surfaces meet at less than ``smooth_angle_deg``."""
        places = [np.linspace(0, len(g.points) - 1, min(_N_PLACES, len(g.points))) for g in guides]
        points = [g.points[at.astype(np.int64)] for g, at in zip(guides, places, strict=True)]
        angles = self._measured(chains, points)[1]
        borders = []
        for chain, guide, angle in zip(chains, guides, angles, strict=True):
            sides = [self.regions[label] for label in side_labels(chain)]
            surfaces = tuple(side.surface for side in sides)
            orientations = tuple(side.orientation for side in sides)
            border = Border(guide, surfaces, orientations, surfaces)
            if len(sides) == 2 and np.degrees(angle) < self.options.smooth_angle_deg:
                contact = Contact(surfaces[0], surfaces[1], orientations[0] * orientations[1])
                border = replace(border, constraints=(*surfaces, contact))
            borders.append(border)
        return borders

    def corners(
        self,
        places: Array,
        around: Sequence[Sequence[int]],
        chains: Sequence[Chain],
        borders: Sequence[Border],
    ) -> list[Corner]:
        """Where sharp borders meet: after two of Newton's steps, if that is near.

        Parameters
        ----------
        places : where the net has the corners, shape ``(n, 3)``.
        around : the borders that end at each; a corner of smooth ones only stays.
        chains, borders : those that the indices refer to.
        """
        labels = [
            labels_beside(chains[index] for index in ending if not borders[index].is_contact)
            for ending in around
        ]
        owner = np.repeat(np.arange(len(places)), [len(beside) for beside in labels])
        label = np.array([name for beside in labels for name in beside], dtype=np.int64)
        located = np.array(places)
        for _ in range(_NEWTON_STEPS):
            feet, normals = self._feet(located[owner], label)
            located += _least_steps(feet - located[owner], normals, owner, len(places))
        is_far = np.linalg.norm(located - places, axis=1) > self.options.corner_move
        located[is_far] = places[is_far]
        away = np.linalg.norm(self._feet(located[owner], label)[0] - located[owner], axis=1)
        gaps = np.zeros(len(places))
        np.maximum.at(gaps, owner, away)
        return [Corner(at, float(gap), False) for at, gap in zip(located, gaps, strict=True)]

    def creases(
        self, chains: Sequence[Chain], borders: Sequence[Border], ends: Sequence[Ends]
    ) -> list[Crease]:
        """The curves of borders, through their vertices."""
        sharp = [index for index, border in enumerate(borders) if not border.is_contact]
        starts = [points_along(borders[index].guide) for index in sharp]
        middles = self._moved([chains[index] for index in sharp], starts)
        drawn = dict(zip(sharp, zip(starts, middles, strict=True), strict=True))
        curves = [
            curve_through(border.guide, *drawn[index], tips)
            if index in drawn
            else _smooth_curve(border.guide, tips)
            for index, (border, tips) in enumerate(zip(borders, ends, strict=True))
        ]
        gaps, angles = self._measured(chains, [curve.samples(_N_SAMPLES) for curve in curves])
        return [
            Crease(curve, float(gap), float(angle), is_fallback=False)
            for curve, gap, angle in zip(curves, gaps, angles, strict=True)
        ]

    def _moved(self, chains: Sequence[Chain], starts: Sequence[Array]) -> list[Array]:
        """Points of borders after moving to the mean of their feet, several times."""
        if not starts:
            return []
        sizes = [len(points) for points in starts]
        points = np.concatenate(starts)
        labels = [np.repeat(side, sizes) for side in _sides(chains)]
        for _ in range(N_ROUNDS):
            points = np.mean([self._feet(points, label)[0] for label in labels], axis=0)
        return np.split(points, np.cumsum(sizes)[:-1])

    def _measured(self, chains: Sequence[Chain], points: Sequence[Array]) -> tuple[Array, Array]:
        """Largest distance of each border's points to its surfaces, and median angle there."""
        if not points:
            return np.zeros(0), np.zeros(0)
        sizes = [len(mine) for mine in points]
        every = np.concatenate(points)
        (left, first), (right, second) = (
            self._feet(every, np.repeat(side, sizes)) for side in _sides(chains)
        )
        away = np.linalg.norm([left - every, right - every], axis=2).max(axis=0)
        # atan2 keeps its digits near 0, where arccos loses half of them.
        sine = np.linalg.norm(np.cross(first, second), axis=1)
        angle = np.arctan2(sine, np.einsum("ij,ij->i", first, second))
        begin = np.cumsum([0, *sizes[:-1]])
        medians = [float(np.median(mine)) for mine in np.split(angle, begin[1:])]
        return np.maximum.reduceat(away, begin), np.array(medians)

    def _feet(self, points: Array, label: Labels) -> tuple[Array, Array]:
        return feet_on_each(points, label, self.regions)


def _sides(chains: Sequence[Chain]) -> tuple[Labels, Labels]:
    """The region on the left and on the right of each; a rim has its own on both."""
    left = np.array([chain.left for chain in chains])
    right = np.array([chain.right for chain in chains])
    return left, np.where(right == -1, left, right)


def _least_steps(offset: Array, normals: Array, owner: Labels, n: int) -> Array:
    """The shortest steps that solve the linearised distances of ``n`` points, shape ``(n, 3)``.

    Parameters
    ----------
    offset, normals : from a point to its foot on a surface and the normal there, a row for
        each pair of a point and a surface.
    owner : the point of each row, ascending.
    """
    count = np.bincount(owner, minlength=n)
    place = np.arange(len(owner)) - (np.cumsum(count) - count)[owner]
    rows, values = np.zeros((n, count.max(initial=1), 3)), np.zeros((n, count.max(initial=1)))
    rows[owner, place] = normals
    values[owner, place] = np.einsum("ij,ij->i", offset, normals)
    return np.asarray(np.einsum("nij,nj->ni", np.linalg.pinv(rows, rcond=CUTOFF), values))


def _smooth_curve(guide: Guide, ends: Ends) -> Curve:
    """The curve along a guide, from end to end."""
    if ends is None:
        return interpolated(guide.points, is_closed=True)
    inner = resampled(guide.points, _N_SMOOTH)[1:-1]
    directions = Guide(guide.points, is_closed=False).directions()
    middle = np.linspace(0, len(directions) - 1, _N_SMOOTH).astype(np.int64)[1:-1]
    return open_curve(guide, inner, directions[middle], ends)
