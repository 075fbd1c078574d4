"""Narrow chamfers along the edges of larger faces.

A chamfer two or three patches wide hardly tells how it leans: seeds find a plane here and a cone
there, each of which leans another way. But across a known edge it is a straight line that has
two unknowns, how far from the edge it begins on either face, and the cutter that has gone round
a face has left the same two along all its edges.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from crispline.fit.swept import Line
from crispline.options import RegionOptions
from crispline.region.claim import Claim, cheapest_together, misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.narrow.stretch import AROUND, Fits, Mask, Stretch, stretches
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Surface
from crispline.surface.base import Array

_OFF = 3.0  # sigmas; points farther from both faces than this are lost
_MIN_LOST = 10
_MIN_SETBACK = 0.8  # spacings
_EXPLAINED = 0.6  # share of the misfit of the lost points that a chamfer must explain
_SAME_CUT = 6.0  # rise of the misfit for which the cut of other edges is the better guess
_SAME_SHARE = 0.1  # and of what the cut explains: of other edges that end here, points are too
_TOGETHER = 0.5  # times the cost of a face that a chamfer must gain, with the crumbs it replaces
_SAME_PLACE = 0.1  # spacings; a chamfer that has been found so near stays as it is
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
        is_on = np.minimum(u, v) > 0.0
        of_cut = misfit(above / np.sqrt(squared), edge.noise)
        least = of_cut if only else np.minimum(of_cut, edge.known)
        return np.where(is_on, least, edge.known)

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


def with_bevels(
    label: Labels,
    fits: Fits,
    rounds: Fits,
    evidence: Evidence,
    options: RegionOptions,
    *,
    only_clear: bool = False,
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the chamfers that the points along borders ask for, and their surfaces.

    Chamfers between planes are planes, those between faces about one axis are cones. Crumbs that
    stand between the two faces give way if the chamfers explain the points no worse, a face less
    counted.

    Parameters
    ----------
    label, fits : regions and surface of each.
    rounds : those that are rounds, or chamfers already, which no chamfer replaces.
    only_clear : make only those along several edges of a face, and clearly likelier than rounds.
    """
    label = label.copy()
    found: dict[int, RegionFit] = {}
    cuts = [
        cut
        for edge in stretches(label, fits, rounds, evidence, options)
        if (cut := _asked(edge, options)) is not None
    ]
    taken: set[int] = set()
    for group in _round_one_face(cuts):
        lead = sum(cut.lead for cut in group)
        if only_clear and (len(group) < 2 or lead < _TOGETHER * options.face_cost):
            continue
        crumbs = {crumb for cut in group for crumb in cut.edge.crumbs} - taken
        surfaces = [surface for cut in group if (surface := cut.surface(fits)) is not None]
        if len(surfaces) < len(group) or all(map(partial(_is_there, fits), group, surfaces)):
            continue
        yielding = _yielding(group, surfaces, sorted(crumbs), label, fits, evidence, options)
        if yielding is None:
            continue
        taken |= crumbs
        field = np.isin(label, yielding)
        for cut in group:
            field |= cut.edge.field & np.isin(label, cut.edge.faces)
        name = int(label.max()) + 1
        new: dict[int, RegionFit] = {}
        for k, (cut, surface) in enumerate(zip(group, surfaces, strict=True)):
            new[name + k] = held_fit(surface, np.flatnonzero(cut.edge.field & field), evidence)
        _assign(label, field, group, new, fits, evidence, options)
        for k in new:
            own = np.flatnonzero(label == k)
            if len(own):
                found[k] = held_fit(new[k].surface, own, evidence)
    return label, found


def _asked(edge: Stretch, options: RegionOptions) -> Cut | None:
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


def _grid(most: float) -> tuple[Array, Array]:
    levels = np.geomspace(_MIN_SETBACK, most, _LEVELS)
    return levels, levels


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


def _round_one_face(cuts: Sequence[Cut]) -> Iterator[list[Cut]]:
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


def _is_there(fits: Fits, cut: Cut, surface: Surface) -> bool:
    """Whether the one crumb between the two faces is the chamfer already."""
    if len(cut.edge.crumbs) != 1:
        return False
    fit = fits[cut.edge.crumbs[0]]
    feet = fit.surface.project(fit.points)[0]
    return fit.is_accepted and bool(np.abs(surface.signed_distance(feet)).max() < _SAME_PLACE)


def _yielding(
    cuts: Sequence[Cut],
    surfaces: Sequence[Surface],
    crumbs: Sequence[int],
    label: Labels,
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> list[int] | None:
    """The crumbs that give way to chamfers; None if these do not gain enough."""
    owner = label[evidence.patch]
    faces = sorted({face for cut in cuts for face in cut.edge.faces})
    every = [*surfaces, *(fits[face].surface for face in faces)]
    gain, yielding = 0.0, []
    for crumb in crumbs:
        own = owner == crumb
        points = evidence.points[own]
        noise = np.maximum(evidence.noise[own], options.swallowed_floor)
        nearest = np.min([np.abs(surface.signed_distance(points)) for surface in every], axis=0)
        now = misfit(fits[crumb].surface.signed_distance(points), noise)
        rise = float((misfit(nearest, noise) - now).sum())
        if rise < options.face_cost:
            yielding.append(crumb)
            gain += options.face_cost - rise
    for cut in cuts:
        rest = ~np.isin(cut.edge.owner, crumbs)
        gain += float((cut.edge.known - cut.misfit(cut.setbacks))[rest].sum())
    return yielding if gain > _TOGETHER * options.face_cost * len(cuts) else None


def _assign(
    label: Labels,
    field: Mask,
    cuts: Sequence[Cut],
    new: Mapping[int, RegionFit],
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> None:
    """Give patches to the surfaces that neighbours together find cheapest."""
    members = np.flatnonzero(field)
    faces = sorted({face for cut in cuts for face in cut.edge.faces})
    reach = {face: np.zeros(len(label), dtype=bool) for face in faces}
    for cut in cuts:
        for face in cut.edge.faces:
            reach[face] |= cut.edge.field
    reach |= {name: cut.edge.field for name, cut in zip(new, cuts, strict=True)}
    costs = np.stack(
        [
            Claim({**fits, **new}[name], evidence, options).patch_costs(field & within)[members]
            for name, within in reach.items()
        ],
        axis=1,
    )
    label[members] = np.array(list(reach))[cheapest_together(costs, members, evidence.graph)]
