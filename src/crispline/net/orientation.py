"""Choose among orientations of the normals by how well an indicator explains the points."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from crispline.cloud.facing import Facing, facing, hints
from crispline.cloud.normals import orient_by_spanning_tree, principal_normals
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.working import WorkingCloud
from crispline.errors import InputError
from crispline.net.places import with_places_turned
from crispline.net.poisson import point_areas, poisson_indicator
from crispline.net.sheets import has_near_sheets, told_apart
from crispline.net.signs import CELL, Couplings, is_inside_out, with_best_signs
from crispline.options import NetOptions
from crispline.surface.base import Array

MAX_CONTRADICTION = 0.05
"""A file that contradicts itself, or is silent, at more of the points is not believed ..."""
_MAX_MISSING = 0.1
_WORSE = 1.25
"""... nor is one whose sides explain the points that much worse than the best found without."""
_FAIR = 0.65
"""Share of ``good_spread`` above which the smooth pieces are turned before trees are compared."""


@dataclass(frozen=True)
class Orientation:
    """Which way the surface faces.

    Attributes
    ----------
    cloud : the cloud; where the sides of walls are told, with neighbours on the own sheet only.
    normals : outward unit normals, shape ``(n, 3)``.
    spread : scatter of their indicator at the points over its jump across the surface.
    is_sided : whether the normals tell the points on one side of a thin wall from the others.
    notes : sentences for the user about what was not used.
    """

    cloud: WorkingCloud
    normals: Array
    spread: float
    is_sided: bool = False
    notes: tuple[str, ...] = ()


def oriented_normals(
    cloud: WorkingCloud,
    options: NetOptions,
    threads: int = -1,
    given: PointCloud | None = None,
) -> Orientation:
    """Outward normals of a cloud: as its file tells, else the best of several spanning trees.

    A file that brings normals or scanner positions is believed if it agrees with itself,
    neighbour by neighbour, and explains the points about as well as the best spanning tree.
    Where walls are thin, the indicator tells the sides that the tree confused.

    Parameters
    ----------
    cloud : ``n`` points.
    options : ``normals`` says what the file counts.
    threads : threads for neighbour queries and transforms; the result does not depend on it.
    given : the cloud as it was read, or None if it has points only.

    Raises
    ------
    InputError
        The normals of the file are asked for, and it has none.
    """
    told = [] if given is None or options.normals == "none" else list(hints(given, cloud))
    if options.normals == "file" and not told:
        raise InputError(
            "expected a cloud with normals or scanner positions, it has points only; leave out "
            "`--normals file` or export the cloud with its normals"
        )
    notes: list[str] = []
    best: Orientation | None = None
    for hint in told:
        if hint.missing > _MAX_MISSING and options.normals == "auto":
            notes.append(
                f"{hint.source} of the file are missing at {_percent(hint.missing)} of the "
                "points: not used"
            )
            continue
        found = facing(cloud, hint, options.normal_neighbours[0], threads)
        if found.contradiction > MAX_CONTRADICTION and options.normals == "auto":
            notes.append(
                f"{hint.source} of the file contradict each other at "
                f"{_percent(found.contradiction)} of the points: not used"
            )
            continue
        candidate = _turned_outward(found, threads)
        if options.normals == "auto":
            best = best or best_tree(cloud, options, threads)
        if best is None or candidate.spread < _WORSE * best.spread:
            return replace(candidate, notes=tuple(notes))
        notes.append(f"{hint.source} of the file fit the points badly: not used")
    best = best or best_tree(cloud, options, threads)
    return replace(_repaired(best, options, threads), notes=tuple(notes))


def best_tree(cloud: WorkingCloud, options: NetOptions, threads: int = -1) -> Orientation:
    """Outward normals of a cloud that is nothing but points.

    No single spanning-tree setting is safe on every part, but a wrong
    orientation shows: the Poisson indicator then scatters at the points. So
    settings are tried in turn and the smallest *spread* (scatter at the points
    over the jump across the surface) wins; where it is large, the smooth pieces of
    the surface are turned for the better first. The search ends when two settings
    agree on the smallest spread and it is below ``options.good_spread``.
    """
    areas = point_areas(cloud.distances)
    best: tuple[float, Array] | None = None
    known: list[Couplings] = []
    for k in options.normal_neighbours:
        normals = principal_normals(cloud.points, cloud.neighbours, k)
        for bending, offset_weight in itertools.product((2.0, 1.0, 0.0), (0.25, 1.0)):
            oriented = orient_by_spanning_tree(
                cloud.points, normals, cloud.neighbours, bending, offset_weight
            )
            spread = indicator_spread(cloud.points, oriented, areas, threads)
            if spread >= _FAIR * options.good_spread:
                oriented, spread = _with_pieces_turned(
                    cloud, oriented, spread, areas, threads, known
                )
            confirmed = best is not None and abs(spread - best[0]) < 0.05 * best[0]
            if best is None or spread < best[0]:
                best = spread, oriented
            if confirmed and best[0] < options.good_spread:
                return Orientation(cloud, best[1], best[0])
    if best is None:
        raise ValueError("options.normal_neighbours must not be empty")
    return Orientation(cloud, best[1], best[0])


def indicator_spread(points: Array, normals: Array, areas: Array, threads: int = -1) -> float:
    """Scatter of the indicator at the points over its jump across the surface."""
    indicator = poisson_indicator(points, normals, areas, CELL, threads=threads)
    reach = 1.5 * indicator.cell
    jump = np.median(
        indicator.at(points - reach * normals) - indicator.at(points + reach * normals)
    )
    return float(np.std(indicator.at(points)) / max(abs(float(jump)), 1e-12))


def _repaired(found: Orientation, options: NetOptions, threads: int) -> Orientation:
    """The orientation after what trees get wrong unseen: pieces, thin walls, small places.

    Each is changed only where that explains the points better.
    """
    if found.spread < _FAIR * options.good_spread:
        # A face of a hundredth of the points hardly shows in the spread.
        areas = point_areas(found.cloud.distances)
        turned = _with_pieces_turned(found.cloud, found.normals, found.spread, areas, threads)
        found = replace(found, normals=turned[0], spread=turned[1])
    best = _with_near_sheets_apart(found, threads)
    normals = with_places_turned(best.cloud, best.normals, options.normal_neighbours, threads)
    if (normals == best.normals).all():
        return best
    areas = point_areas(best.cloud.distances)
    spread = indicator_spread(best.cloud.points, normals, areas, threads)
    best = replace(best, normals=normals, spread=spread)
    # What was the wrong way round has misled the normals near it.
    apart = _with_near_sheets_apart(replace(best, cloud=found.cloud), threads)
    return apart if apart.cloud is not found.cloud else best


def _with_pieces_turned(
    cloud: WorkingCloud,
    normals: Array,
    spread: float,
    areas: Array,
    threads: int,
    known: list[Couplings] | None = None,
) -> tuple[Array, float]:
    """The normals and their spread, with other signs of whole smooth pieces if that lessens it."""
    turned = with_best_signs(cloud.points, normals, cloud.neighbours, areas, threads, known)
    turned_spread = indicator_spread(cloud.points, turned, areas, threads)
    return (turned, turned_spread) if turned_spread < spread else (normals, spread)


def _with_near_sheets_apart(found: Orientation, threads: int) -> Orientation:
    """The orientation with the sides of thin walls told apart, if there are any and it helps."""
    if not has_near_sheets(found.cloud, found.normals, threads):
        return found
    own, normals = told_apart(found.cloud, found.normals, threads)
    spread = indicator_spread(own.points, normals, point_areas(own.distances), threads)
    if spread >= found.spread:
        return found
    return Orientation(own, normals, spread, is_sided=True)


def _turned_outward(found: Facing, threads: int) -> Orientation:
    """The orientation of a file; as a whole the other way if a closed surface is inside out.

    A closed surface encloses a positive volume, whichever way the normals of a file look, and
    a room that was scanned from within is a body like any other. Of an open one only the file
    knows the outside.
    """
    points, normals = found.cloud.points, found.normals
    areas = point_areas(found.cloud.distances)
    if is_inside_out(points, normals, areas):
        normals = -normals
    spread = indicator_spread(points, normals, areas, threads)
    return Orientation(found.cloud, normals, spread, is_sided=True)


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"
