"""Cuts that a cutter leaves along edges, two or three patches wide.

Across a known edge a chamfer is a straight line that has two unknowns, how far from the edge it
begins on either face, and the cutter that has gone round a face has left the same two along all
its edges.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from crispline.fit.swept import Line
from crispline.options import RegionOptions
from crispline.region.claim import misfit
from crispline.region.narrow.stretch import AROUND, Fits, Mask, Stretch
from crispline.surface import Surface
from crispline.surface.base import Array

_OFF = 3.0  # sigmas; points farther from both faces than this are lost
_MIN_LOST = 10
_MIN_SETBACK = 0.8  # spacings
_EXPLAINED = 0.6  # share of the misfit of the lost points that a chamfer must explain
_SAME_CUT = 6.0  # rise of the misfit for which the cut of other edges is the better guess
_SAME_SHARE = 0.1  # and of what the cut explains: of other edges that end here, points are too
_LEVELS = 10
_REFINEMENTS = 3
_MAX_POINTS = 2000
_N_RADII = 24


@dataclass(frozen=True)
class Cut:
    """What a cutter leaves along an edge, inside (``side`` -1) or outside of the part.

    Attributes
    ----------
    edge : where it goes.
    side : -1 where it takes material away.
    setbacks : from the edge to the chamfer on either face, spacings.
    lead : by how much less misfit it leaves than a round in its place.
    is_sure : whether the points along the edge ask for a chamfer, even if there were no other.
    """

    edge: Stretch
    side: float
    setbacks: tuple[float, float]
    lead: float = 0.0
    is_sure: bool = False

    def misfit(self, setbacks: tuple[float, float], *, only: bool = True) -> Array:
        """The misfit of the points along the edge if the chamfer began elsewhere, shape ``(n,)``.

        Between the lines where it begins it is that with the chamfer ``only``, or else with what
        is nearer; beyond them the faces go on.
        """
        distance, is_on = self._place(setbacks)
        of_cut = misfit(distance, self.edge.noise)
        least = of_cut if only else np.minimum(of_cut, self.edge.known)
        return np.where(is_on, least, self.edge.known)

    def _place(self, setbacks: tuple[float, float]) -> tuple[Array, Mask]:
        """Distances of the points from the chamfer, and which are between its lines."""
        edge = self.edge
        sine = np.sqrt(1.0 - edge.cosine**2)
        first, second = setbacks
        # Distances from the edge along either face are affine coordinates across it.
        u, v = self.side * edge.heights / sine
        slope = np.array([1.0 / second, 1.0 / first])
        squared = float(slope @ slope + 2.0 * edge.cosine * slope[0] * slope[1]) / sine**2
        above = u * slope[0] + v * slope[1] - 1.0
        back = above / squared / sine**2
        u = u - back * (slope[0] + edge.cosine * slope[1])
        v = v - back * (slope[1] + edge.cosine * slope[0])
        return above / np.sqrt(squared), np.minimum(u, v) > 0.0

    def share(self, crumb: int, n_points: int) -> float:
        """Share of the points of a crumb that are where the chamfer would be."""
        is_on = self._place(self.setbacks)[1]
        return float(np.count_nonzero(is_on & (self.edge.owner == crumb)) / max(n_points, 1))

    def total(self, setbacks: tuple[float, float]) -> float:
        """Of all points along the edge."""
        return float(self.misfit(setbacks).sum())

    def loss(self, setbacks: tuple[float, float]) -> float:
        """By how much too little other setbacks explain for them to be those of this cut."""
        known, own = float(self.edge.known.sum()), self.total(self.setbacks)
        return self.total(setbacks) - own - _SAME_CUT - _SAME_SHARE * (known - own)

    def surface(self, fits: Fits) -> Surface | None:
        """The plane or the cone that the chamfer is."""
        edge, faces = self.edge, [fits[face] for face in self.edge.faces]
        sine = self.side * np.sqrt(1.0 - edge.cosine**2)
        first, second = self.setbacks
        begins = np.stack(
            [
                edge.place(faces, np.array([0.0, sine * first])),
                edge.place(faces, np.array([sine * second, 0.0])),
            ]
        )
        start, end = edge.sweep.flattened(begins)
        along = (end - start) / np.linalg.norm(end - start)
        normal = np.array([-along[1], along[0]])
        line = Line(float(np.arctan2(normal[1], normal[0])), float(normal @ start))
        return edge.sweep.surface(line)


def asked_cut(edge: Stretch, options: RegionOptions) -> Cut | None:
    """The chamfer of least misfit along an edge; None if the points speak against one.

    It is not sure where a round explains them as well, nor where little of what the faces do not
    explain is on it.
    """
    cut = best_cut(edge)
    if cut is None:
        return None
    known, left = cut.edge.known, cut.misfit(cut.setbacks)
    lost = known > 0.5 * _OFF**2
    explained = float((known - left)[lost].sum())
    if (known - left).sum() < options.face_cost:
        return None
    tangent = np.tan(0.5 * np.arccos(edge.cosine))
    radii = np.linspace(0.5, 2.0, _N_RADII) * np.mean(cut.setbacks) / tangent
    of_ball = min(float(cut.edge.misfit_with_round(r, cut.side, only=True).sum()) for r in radii)
    lead = of_ball - float(left.sum())
    if lead < -_SAME_CUT:
        return None
    is_sure = lead > 0.0 and explained >= _EXPLAINED * float(known[lost].sum())
    return replace(cut, lead=lead, is_sure=is_sure)


def best_cut(edge: Stretch) -> Cut | None:
    """The chamfer of least misfit along an edge; None if too few points are off both faces."""
    reach = AROUND + edge.width
    lost = edge.known > 0.5 * _OFF**2
    first, second = np.sign(edge.heights[:, lost])
    side = float(np.sign(first[first == second].sum()))
    # A cut is on one side of both faces; crumbs that stand between others too go on beyond.
    heights = side * edge.heights
    is_within = (heights > -_OFF * edge.noise) & (heights < reach * np.sqrt(1.0 - edge.cosine**2))
    edge = edge.only(np.flatnonzero(is_within.all(axis=0)))
    lost = edge.known > 0.5 * _OFF**2
    if side == 0.0 or np.count_nonzero(lost) < _MIN_LOST:
        return None
    step = -(-len(edge.points) // _MAX_POINTS)
    thin = edge.only(np.arange(0, len(edge.points), step))
    return Cut(edge, side, _least([Cut(thin, side, (0.0, 0.0))], _grid(reach)))


def cuts_round_one_face(cuts: Sequence[Cut]) -> Iterator[list[Cut]]:
    """The cuts that one cutter leaves on its way round a face, then the others.

    Those that are not sure are only made with others that are.
    """
    left = dict(enumerate(cuts))
    while any(cut.is_sure for cut in left.values()):
        sure = [cut for cut in left.values() if cut.is_sure]
        faces = [(face, cut.side) for cut in sure for face in cut.edge.faces]
        face, side = max(sorted(set(faces)), key=faces.count)
        group = {
            k: _facing(c, face) for k, c in left.items() if face in c.edge.faces and c.side == side
        }
        while True:
            setbacks = _common(list(group.values()))
            worse = {k: c.loss(setbacks) for k, c in group.items()}
            worst = max(worse, key=lambda k: worse[k])
            if len(group) == 1 or worse[worst] <= 0.0:
                break
            del group[worst]
        for k in group:
            del left[k]
        if not any(cut.is_sure for cut in group.values()):
            continue
        yield [replace(cut, setbacks=setbacks) for cut in group.values()]


def _facing(cut: Cut, face: int) -> Cut:
    """The cut with a face as the first of the two."""
    edge = cut.edge
    if edge.faces[0] == face:
        return cut
    turned = replace(edge, faces=edge.faces[::-1], heights=edge.heights[::-1])
    return replace(cut, edge=turned, setbacks=cut.setbacks[::-1])


def _common(cuts: Sequence[Cut]) -> tuple[float, float]:
    """Setbacks of several cuts: equal ones if the points bear it."""
    start = np.median([cut.setbacks for cut in cuts], axis=0)
    ratio = np.geomspace(0.7, 1.4, 7)
    free = _least(cuts, (start[0] * ratio, start[1] * ratio))
    legs = np.sqrt(start[0] * start[1]) * np.geomspace(0.7, 1.4, 41)
    totals = [sum(cut.total((leg, leg)) for cut in cuts) for leg in legs]
    equal = float(legs[int(np.argmin(totals))])
    is_borne = min(totals) <= sum(cut.total(free) for cut in cuts) + _SAME_CUT
    return (equal, equal) if is_borne else free


def _least(cuts: Sequence[Cut], grid: tuple[Array, Array]) -> tuple[float, float]:
    """The setbacks of least misfit along some edges together."""
    best, found = np.inf, (0.0, 0.0)
    for _ in range(_REFINEMENTS):
        for first in grid[0]:
            for second in grid[1]:
                total = sum(cut.total((first, second)) for cut in cuts)
                if total < best:
                    best, found = total, (float(first), float(second))
        ratio = (grid[0][1] / grid[0][0]) ** np.linspace(-0.8, 0.8, 5)
        grid = found[0] * ratio, found[1] * ratio
    return found


def _grid(most: float) -> tuple[Array, Array]:
    levels = np.geomspace(_MIN_SETBACK, most, _LEVELS)
    return levels, levels
