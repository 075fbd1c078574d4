"""Stretches of border between two larger faces that meet at an angle.

Both faces are swept along the border, straight or about an axis, so what is across it is a
problem in the plane; crumbs of a narrow face may stand between them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from crispline.fit.swept import Sweep, Translation
from crispline.net.graph import components
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.claim import MISFIT_CAP, misfit
from crispline.region.evidence import Evidence
from crispline.region.narrow.bent import Outline, is_bent, next_to, outline_of
from crispline.region.narrow.motion import MIN_ANGLE, common_sweep
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Cone, Cylinder, Plane, Torus
from crispline.surface.base import Array

Mask = NDArray[np.bool_]
Fits = Mapping[int, RegionFit]

AROUND = 4
"""Rings of patches about the border that belong to a stretch."""

_BESIDE = 0.5  # share of a crumb's border that is with the two faces
_MAX_STRIP = 6.0  # patches; a plane or cone that is narrower, however long, may be of a round
_LARGER = 2  # times the smallest crumb is large enough for a face beside it
_FARTHER = 3.0  # times as far from the edge as the stretch goes, a crumb may be a piece of a round
_MAX_ANGLE = np.radians(155.0)  # between the faces' normals
_NEWTON_STEPS = 4


@dataclass(frozen=True)
class Stretch:
    """Two faces that meet at an angle, and the raw points along a stretch of their border.

    Attributes
    ----------
    faces, crumbs, rounds : labels of the two, of what small regions stand between them, and of
        the rounds of other edges that end here.
    field : patches among which the round is, shape ``(m,)``.
    sweep : along which both faces are swept.
    cosine : of the angle between the outward normals.
    points, noise, owner : of the points, and their regions, shape ``(n, 3)``, ``(n,)``, ``(n,)``.
    heights : above either face, outside positive, shape ``(2, n)``.
    width : of the widest crumb, spacings; 0 without one.
    known : misfit of the points with the faces and rounds, shape ``(n,)``.
    outline : of the two faces where one that is swept straight is round, else None.
    """

    faces: tuple[int, int]
    crumbs: tuple[int, ...]
    rounds: tuple[int, ...]
    field: Mask
    sweep: Sweep
    cosine: float
    points: Array
    noise: Array
    owner: Labels
    heights: Array
    known: Array
    width: float
    outline: Outline | None = None

    @property
    def reach(self) -> float:
        """How far from the edge the ball may touch the faces, spacings.

        That is as far as the stretch goes, or farther if there are crumbs, which may be pieces of
        a larger round: planes take the patches of it where it leaves them slowly.
        """
        is_straight = isinstance(self.sweep, Translation)
        return _FARTHER * AROUND if self.crumbs and is_straight else AROUND + self.width

    def without(self, crumbs: list[int], label: Labels) -> Stretch:
        """The same without some crumbs and the points on them."""
        return replace(
            self.only(np.flatnonzero(~np.isin(self.owner, crumbs))),
            crumbs=tuple(crumb for crumb in self.crumbs if crumb not in crumbs),
            field=self.field & ~np.isin(label, crumbs),
        )

    def only(self, rows: Labels) -> Stretch:
        """The same with some of its points."""
        return replace(
            self,
            points=self.points[rows],
            noise=self.noise[rows],
            owner=self.owner[rows],
            heights=self.heights[:, rows],
            known=self.known[rows],
        )

    def place(self, faces: Sequence[RegionFit], heights: Array) -> Array:
        """The point at heights ``(2,)`` above the two faces, nearest to the edge."""
        found = self.points[np.argmin(np.abs(self.heights).sum(axis=0))]
        for _ in range(_NEWTON_STEPS):
            feet = [face.surface.project(found[None]) for face in faces]
            rows = np.stack(
                [normal[0] * f.orientation for (_, normal), f in zip(feet, faces, strict=True)]
            )
            now = np.einsum("ij,ij->i", rows, found - np.stack([foot[0] for foot, _ in feet]))
            found = found + np.linalg.lstsq(rows, heights - now, rcond=None)[0]
        return np.asarray(found)

    def centre(self, faces: Sequence[RegionFit], height: float) -> Array | None:
        """The place so high above both faces, seen along the sweep, shape ``(2,)``."""
        if self.outline is not None:
            return self.outline.centre(height)
        return np.asarray(self.sweep.flattened(self.place(faces, np.full(2, height))[None])[0])

    def misfit_with_round(self, radius: float, side: float, *, only: bool = False) -> Array:
        """The misfit of the points with a ball that touches both faces, or with what is known.

        The ball is inside (``side`` -1) or outside. Between the lines where it touches the
        faces it is the ball ``only``, or else what is nearer.

        Heights above two faces are affine coordinates across their edge. Beyond the
        lines where the ball touches, the faces themselves go on.
        """
        seen = self._from_ball(radius, side)
        if seen is None:
            return np.full(len(self.points), MISFIT_CAP)
        distance, on_arc = seen
        of_ball = misfit(distance, self.noise)
        least = of_ball if only else np.minimum(of_ball, self.known)
        return np.where(on_arc, least, self.known)

    def _from_ball(self, radius: float, side: float) -> tuple[Array, Mask] | None:
        """Distances of the points from a ball, and which of them are on its arc."""
        if self.outline is not None:
            return self.outline.from_ball(self.sweep.flattened(self.points), side * radius)
        first, second = self.heights - side * radius
        sine2 = 1.0 - self.cosine**2
        squared = (first**2 + second**2 - 2.0 * self.cosine * first * second) / sine2
        along = -side * np.stack([first - self.cosine * second, second - self.cosine * first])
        on_arc = along.min(axis=0) > 0.0
        return np.sqrt(np.maximum(squared, 0.0)) - radius, on_arc


def stretches(
    label: Labels,
    fits: Fits,
    rounds: Fits,
    evidence: Evidence,
    options: RegionOptions,
    *,
    bent: bool = False,
) -> Iterator[Stretch]:
    """Every stretch of border of two larger faces that meet at an angle.

    With ``bent`` also those of two faces along one direction of which one is round.
    """
    graph = evidence.graph
    before, known = label.copy(), Borders.of(label, graph)
    borders, lengths = known.regions, known.lengths
    size = np.bincount(before)
    is_crumb = size <= options.max_pruned_patches
    sides_of = np.bincount(borders.ravel(), np.repeat(lengths, 2), len(size))
    width = 2.0 * size / np.maximum(sides_of, 1.0)
    for region in np.flatnonzero((width < _MAX_STRIP) & (size > 0)).tolist():
        is_crumb[region] |= isinstance(fits[region].surface, Plane | Cone)
    is_crumb &= ~np.isin(np.arange(len(size)), list(rounds))
    between: dict[tuple[int, int], list[int]] = {
        (a, b): []
        for (a, b), n in zip(borders.tolist(), lengths.tolist(), strict=True)
        if n >= options.step_sides
    }
    for region in np.unique(before)[is_crumb[np.unique(before)]].tolist():
        own = (borders == region).any(axis=1)
        beside, sides = borders[own].sum(axis=1) - region, lengths[own]
        for i, j in combinations(range(len(beside)), 2):
            if sides[i] + sides[j] > _BESIDE * sides.sum() and min(sides[i], sides[j]) > 1:
                pair = sorted((int(beside[i]), int(beside[j])))
                between.setdefault((pair[0], pair[1]), []).append(region)
    for (a, b), crumbs in sorted(between.items()):
        # What is much larger than the crumbs beside it need not be large.
        least = min(options.crumb_patches, _LARGER * int(size[crumbs].min(initial=len(label))))
        if min(size[a], size[b]) < least or {a, b} & set(rounds):
            continue
        sweep = common_sweep(fits[a], fits[b], bent=bent)
        if sweep is None:
            continue
        along = np.isin(before, crumbs)
        along[graph.pairs[known.sides(a, b)].ravel()] = True
        piece = components(graph.adjacency, graph.rings(along, 1))
        for part in np.unique(piece[along]).tolist():
            own = along & (piece == part)
            near = graph.rings(own, AROUND)
            here = np.unique(label[near])
            field = near & np.isin(label, (a, b)) | np.isin(label, np.intersect1d(here, crumbs))
            if is_bent(sweep, (fits[a], fits[b])):
                field &= next_to(graph.points, own, sweep)
            kept = tuple(np.intersect1d(here, crumbs).tolist())
            others = np.setdiff1d(here, (a, b, *kept)).tolist()
            ending = tuple(name for name in others if name in rounds or _is_round(fits[name]))
            stretch = _stretch((a, b), kept, ending, field, sweep, label, fits, evidence, options)
            if stretch is not None:
                widest = graph.edge_length * float(width[list(kept)].max(initial=0.0))
                yield replace(stretch, width=widest)


def _is_round(fit: RegionFit) -> bool:
    """Whether a region may be what a small ball has left on its way."""
    match fit.surface:
        case Cylinder(radius=radius) | Torus(minor_radius=radius):
            return fit.is_accepted and radius < AROUND
    return False


def _stretch(
    faces: tuple[int, int],
    crumbs: tuple[int, ...],
    rounds: tuple[int, ...],
    field: Mask,
    sweep: Sweep,
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> Stretch | None:
    """The points along a stretch; None if the faces hardly meet at an angle there."""
    rows = np.flatnonzero(field[evidence.patch])
    if len(rows) == 0:
        return None
    points = evidence.points[rows]
    sides = [fits[face] for face in faces]
    normals = [side.surface.project(points)[1] * side.orientation for side in sides]
    cosine = float(np.median(np.einsum("ij,ij->i", *normals)))
    outline = None
    if is_bent(sweep, sides):
        outline = outline_of(sweep, sides, points)
        if outline is None:
            return None
        cosine = outline.cosine
    if not np.cos(_MAX_ANGLE) < cosine < np.cos(MIN_ANGLE):
        return None
    heights = np.stack([s.surface.signed_distance(points) * s.orientation for s in sides])
    noise = np.maximum(evidence.noise[rows], options.swallowed_floor)
    owner = label[evidence.patch[rows]]
    distance = np.stack([*heights, *(fits[r].surface.signed_distance(points) for r in rounds)])
    known = misfit(np.abs(distance).min(axis=0), noise)
    return Stretch(
        faces=faces,
        crumbs=crumbs,
        rounds=rounds,
        field=field,
        sweep=sweep,
        cosine=cosine,
        points=points,
        noise=noise,
        owner=owner,
        heights=heights,
        known=known,
        width=0.0,
        outline=outline,
    )
