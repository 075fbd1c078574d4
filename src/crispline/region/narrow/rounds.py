"""Narrow rounds along the edges of larger faces.

A fillet two or three patches wide hardly tells its own axis: seeds find a piece of it here and
there, and the two faces close over the rest. But a ball that rolls along two known surfaces
has one unknown, its radius, which all points along the edge hold together: those that lie off
both faces must lie on the round.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.sparse.csgraph import connected_components

from crispline.fit.swept import Circle, fit_line
from crispline.options import RegionOptions
from crispline.region.claim import Claim, cheapest_together, misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.narrow.cut import best_cut
from crispline.region.narrow.stretch import Fits, Mask, Stretch, stretches
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Cylinder, Surface, Torus
from crispline.surface.base import Array

_MIN_WIDTH = 1.2  # of a round that patches can follow, spacings
_OFF = 3.0  # sigmas; points farther from both faces than this are lost
_EXPLAINED = 0.6  # share of the misfit of the lost points that a round must explain
_ALONE = 1.0  # times the cost of a face that a round without crumbs must gain ...
_TOGETHER = 0.5  # ... or with crumbs, each a face gained, or where rounds of other edges end
_CUT = 0.5  # times the cost of a face by which a chamfer, of one parameter more, must be likelier
_SHARED = 0.5  # share of the points of a crumb that gives way that must be on the round
_LOOSE = 1.0  # cost of a patch on a crumb for its surface, which fits whatever is there
_PASSES = 2
_N_RADII = 48
_REFINEMENTS = 2
_SAME_BALL = 6.0  # rise of the misfit for which the ball of a neighbour is the better guess
_SPREAD = 0.1  # of the radius of a ball among those of its edges
_BIAS = 0.25  # of a radius, by which the nearer of two surfaces misleads


@dataclass(frozen=True)
class _Ball:
    """What rolls along an edge, inside (``side`` -1) or outside of the part."""

    edge: Stretch
    radius: float
    side: float

    def misfit(self, radius: float) -> float:
        """Of all points along the edge, if the ball had another radius."""
        return float(self.edge.misfit_with_round(radius, self.side, only=True).sum())


def with_rounds(
    label: Labels, fits: Fits, chamfers: Fits, evidence: Evidence, options: RegionOptions
) -> tuple[Labels, dict[int, RegionFit]]:
    """Labels with the rounds that the points along borders ask for, and their surfaces.

    Rounds between faces along one direction are cylinders, between faces about one axis tori.
    Crumbs that stand between the two give way if the round explains the points no worse, a face
    less counted.

    Parameters
    ----------
    label, fits : regions and surface of each.
    chamfers : those that are chamfers, which no round replaces.
    """
    label = label.copy()
    rounds: dict[int, RegionFit] = {}
    balls: dict[int, _Ball] = {}
    known, settled = ChainMap(rounds, dict(fits)), ChainMap(rounds, dict(chamfers))
    for _ in range(_PASSES):  # what crumbs at a corner hold is known when both rounds are
        for edge in stretches(label, known, settled, evidence, options, bent=True):
            found = _rolled(edge, label, known, options)
            if found is not None:
                edge, ball, surface = found
                name = int(label.max()) + 1
                balls[name] = ball
                rounds[name] = held_fit(surface, np.flatnonzero(edge.field), evidence)
                names = (*edge.faces, *edge.rounds, *edge.crumbs, name)
                _assign(label, edge.field, names, edge.crumbs, known, evidence, options)
    present = np.unique(label)
    surfaces = {name: fit.surface for name, fit in rounds.items()} | _rolled_on(balls, known)
    return label, {
        name: held_fit(surface, np.flatnonzero(label == name), evidence)
        for name, surface in surfaces.items()
        if name in present
    }


def _assign(
    label: Labels,
    field: Mask,
    names: tuple[int, ...],
    crumbs: tuple[int, ...],
    fits: Fits,
    evidence: Evidence,
    options: RegionOptions,
) -> None:
    """Give patches to the surfaces that neighbours together find cheapest."""
    members = np.flatnonzero(field)
    costs = np.stack(
        [Claim(fits[name], evidence, options).patch_costs(field)[members] for name in names],
        axis=1,
    )
    costs[:, [name in crumbs for name in names]] += _LOOSE
    label[members] = np.array(names)[cheapest_together(costs, members, evidence.graph)]


def _rolled(
    edge: Stretch, label: Labels, fits: Fits, options: RegionOptions
) -> tuple[Stretch, _Ball, Surface] | None:
    """The edge without the crumbs that stay, the ball of least misfit, and the round it leaves.

    None if the points do not ask for one, or rather for a chamfer.
    """
    angle = float(np.arccos(edge.cosine))
    radii = np.geomspace(_MIN_WIDTH / angle, edge.reach / np.tan(0.5 * angle), _N_RADII)
    if radii[0] >= radii[-1]:
        return None
    surfaces = [fits[name].surface for name in edge.rounds]
    known = [ball_radius(each) for each in surfaces if isinstance(each, Cylinder | Torus)]
    while True:
        radius, side = _rolling_on(edge, known, *_best_ball(edge, radii))
        rounded = edge.misfit_with_round(radius, side)
        is_on = rounded < 0.5 * _OFF**2
        gain, stays = 0.0, []
        for crumb in edge.crumbs:
            own = edge.owner == crumb
            on = own & is_on
            distance = fits[crumb].surface.signed_distance(edge.points[on])
            rise = float((rounded[on] - misfit(distance, edge.noise[on])).sum())
            gain += options.face_cost - rise
            if rise > options.face_cost or np.count_nonzero(on) < _SHARED * np.count_nonzero(own):
                stays.append(crumb)
        if not stays:
            break
        edge = edge.without(stays, label)
    if not 1.01 * radii[0] < radius < 0.99 * radii[-1]:
        return None
    in_crumb = np.isin(edge.owner, edge.crumbs)
    alone = edge.known - edge.misfit_with_round(radius, side, only=True)
    gain += float(alone[~in_crumb].sum())
    least = (_TOGETHER if edge.crumbs or edge.rounds else _ALONE) * options.face_cost
    if len(known) > 1 and radius in known:
        least = 0.0  # a ball that comes in at one end and goes out at the other
    # What a crumb holds beyond the round is for others to explain.
    lost = (is_on | ~in_crumb) & (edge.known > 0.5 * _OFF**2)
    explained = float((edge.known - rounded)[lost].sum())
    if gain < least or explained < _EXPLAINED * edge.known[lost].sum():
        return None
    chamfered = _misfit_of_chamfer(edge, edge.points[lost]) + _CUT * options.face_cost
    if chamfered < rounded.sum():
        return None
    if _is_chamfer(edge, radius, side, options):
        return None
    surface = _surface(edge, [fits[face] for face in edge.faces], radius, side)
    return None if surface is None else (edge, _Ball(edge, radius, side), surface)


def _misfit_of_chamfer(edge: Stretch, lost: Array) -> float:
    """What is left if a line across the edge, in place of a ball, explains the lost points."""
    line = fit_line(edge.sweep.flattened(lost), float(np.median(edge.noise)))
    chamfer = None if line is None else edge.sweep.surface(line)
    if chamfer is None:
        return np.inf
    cut = misfit(chamfer.signed_distance(edge.points), edge.noise)
    return float(np.minimum(cut, edge.known).sum())


def _is_chamfer(edge: Stretch, radius: float, side: float, options: RegionOptions) -> bool:
    """Whether a cut clearly explains the points better than a ball that rolls along.

    Of a small chamfer few points lie off both faces, too few for a line through these.
    """
    if edge.outline is not None:
        return False  # its setbacks are measured along flat faces
    cut = best_cut(edge)
    if cut is None or cut.side != side:
        return False
    of_ball = cut.edge.misfit_with_round(radius, side, only=True)
    return cut.total(cut.setbacks) + _CUT * options.face_cost < float(of_ball.sum())


def _best_ball(edge: Stretch, radii: Array) -> tuple[float, float]:
    """Radius and side, outside positive, of the ball that leaves the least misfit."""
    best, radius, side = np.inf, 0.0, 0.0
    for trial_side in (-1.0, 1.0):
        around = radii
        for _ in range(_REFINEMENTS):
            costs = [edge.misfit_with_round(r, trial_side).sum() for r in around]
            k = int(np.argmin(costs))
            if costs[k] < best:
                best, radius, side = float(costs[k]), float(around[k]), trial_side
            around = np.linspace(around[max(k - 1, 0)], around[min(k + 1, len(around) - 1)], 16)
    # To the nearer of two surfaces, noise looks smaller where they part slowly.
    around = radius * np.linspace(1.0 - _BIAS, 1.0 + _BIAS, _N_RADII)
    costs = [edge.misfit_with_round(r, side, only=True).sum() for r in around]
    return float(around[int(np.argmin(costs))]), side


def _rolled_on(balls: Mapping[int, _Ball], fits: Fits) -> dict[int, Surface]:
    """The rounds that one ball leaves on its way along several edges, where the points bear it.

    The way may lead over rounds that were found whole.
    """
    names = sorted({*balls, *(name for ball in balls.values() for name in ball.edge.rounds)})
    links = np.zeros((len(names), len(names)), dtype=bool)
    for name, ball in balls.items():
        links[names.index(name), [names.index(other) for other in ball.edge.rounds]] = True
    way_of = connected_components(links, directed=False)[1]
    found: dict[int, Surface] = {}
    for way in np.unique(way_of).tolist():
        members = [name for name, other in zip(names, way_of, strict=True) if other == way]
        own = [balls[name] for name in members if name in balls]
        if len(members) < 2 or len({ball.side for ball in own}) > 1:
            continue
        radii = [ball.radius for ball in own]
        among = np.linspace((1.0 - _SPREAD) * min(radii), (1.0 + _SPREAD) * max(radii), _N_RADII)
        totals = [sum(ball.misfit(radius) for ball in own) for radius in among]
        best = int(np.argmin(totals))
        apart = sum(ball.misfit(ball.radius) for ball in own)
        if totals[best] > apart + _SAME_BALL * len(own):
            continue
        for name in members:
            if name in balls:
                edge = balls[name].edge
                faces = [fits[face] for face in edge.faces]
                surface = _surface(edge, faces, float(among[best]), balls[name].side)
                if surface is not None:
                    found[name] = surface
    return found


def _rolling_on(
    edge: Stretch, known: list[float], radius: float, side: float
) -> tuple[float, float]:
    """The ball of a round that ends here, if the points along the edge bear it, or else its own."""
    own = float(edge.misfit_with_round(radius, side, only=True).sum())
    for other in known:
        if float(edge.misfit_with_round(other, side, only=True).sum()) < own + _SAME_BALL:
            return other, side
    return radius, side


def ball_radius(surface: Surface) -> float:
    """Radius of the ball that swept a round; NaN for what is none."""
    match surface:
        case Cylinder():
            return surface.radius
        case Torus():
            return surface.minor_radius
    return np.nan


def _surface(edge: Stretch, faces: list[RegionFit], radius: float, side: float) -> Surface | None:
    """What the ball of a radius sweeps: its centre is as far from both faces."""
    centre = edge.centre(faces, side * radius)
    return None if centre is None else edge.sweep.surface(Circle(centre, radius))
