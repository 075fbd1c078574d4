"""Narrow chamfers along the edges of larger faces.

A chamfer two or three patches wide hardly tells how it leans: seeds find a plane here and a cone
there, each of which leans another way. What a cutter has left along the edges of a face takes
their place if it explains the points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from crispline.options import RegionOptions
from crispline.region.claim import Claim, cheapest_together, misfit
from crispline.region.evidence import Evidence
from crispline.region.fitting import held_fit
from crispline.region.narrow.cut import Cut, asked_cut, cuts_round_one_face
from crispline.region.narrow.stretch import Fits, Mask, stretches
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit
from crispline.surface import Surface

_TOGETHER = 0.5  # times the cost of a face that a chamfer must gain, with the crumbs it replaces
_IN_PLACE = 0.5  # share of a crumb that stays where a chamfer would be, as the ledge of a step is
_SAME_PLACE = 0.1  # spacings; a chamfer that has been found so near stays as it is


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
        if (cut := asked_cut(edge, options)) is not None
    ]
    taken: set[int] = set()
    for group in cuts_round_one_face(cuts):
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
    """The crumbs that give way to chamfers; None if these do not gain enough, or have no place."""
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
        elif max(cut.share(crumb, len(points)) for cut in cuts) > _IN_PLACE:
            return None
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
