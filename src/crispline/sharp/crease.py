"""One border of two regions as a curve on both their surfaces.

A border is sharp or smooth. A sharp one is the intersection of its surfaces. A
smooth one lies where the surfaces have the same normal, or, if they still cross
cleanly, on the intersection too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from crispline.curve import Curve, Line, arc_length, line_through
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.sharp.between import N_ROUNDS, curve_through, points_along
from crispline.sharp.contact import Branch, Contact
from crispline.sharp.refine import curve_along
from crispline.sharp.rim import rim_curve
from crispline.sharp.trace import MAX_MOVE, Guide, is_sane, traced
from crispline.surface import Surface
from crispline.surface.base import Array
from crispline.surface.intersect import Constraint, angles, distance, intersect

N_SAMPLES = 200
"""Points per curve at which its distance to the surfaces and their angle are measured."""
MIN_CROSSING_DEG = 12.0
"""Surfaces that meet at less than this touch rather than cross."""

Ends = tuple[Array, Array] | None
"""Positions of the first and last vertex of a border; None if it is closed."""

_MAX_GAP = 1e-3
_MAX_TOUCH = 0.02
_MIN_KINK_DEG = 2.0  # shallower crossings are too far off along the surfaces
_EXACT = 1e-9
_WANDERING = 1.02
"""Length of a curve over that of the line between its ends, of one that may be straight."""
_FOLDED = 2.0
"""And of one that cannot be a border."""
_MAX_BRANCH_SPREAD = 0.3
_MAX_ROUNDED_OFF = 2.0
_CLOSED = 0.5
"""A curve that leaves less than this share of a gap closes it."""
_LAST_MOVE = 4.5
"""A chain may lie this far from a curve if there is no nearer one, in spacings: between the walls
of a groove that few points tell apart it does."""


@dataclass(frozen=True)
class Border:
    """What the curve between two regions lies on.

    Attributes
    ----------
    guide : where the border runs.
    surfaces : of the region on the left and, unless the net ends there, on the right.
    orientations : whether their normals point out of the part, see :class:`RegionFit`.
    constraints : the surfaces and, for a border at which they touch, their contact.
    """

    guide: Guide
    surfaces: tuple[Surface, ...]
    orientations: tuple[int, ...]
    constraints: tuple[Constraint, ...]

    @property
    def is_contact(self) -> bool:
        """Whether the surfaces touch instead of crossing."""
        return len(self.constraints) > len(self.surfaces)

    def angle(self, points: Array) -> float:
        """Median angle between the outward normals at points ``(n, 3)``, radians; 0 at a rim."""
        if len(self.surfaces) < 2:
            return 0.0
        return float(np.median(angles(points, self.surfaces, self.orientations)))


@dataclass(frozen=True)
class Crease:
    """A located border.

    Attributes
    ----------
    curve : from the border's first to its last vertex.
    gap : largest distance of the curve to its surfaces, spacings.
    angle : median angle between the outward normals along it, radians; 0 at a rim.
    is_fallback : whether the border was only smoothed, because the surfaces
        have no sane common curve near it.
    """

    curve: Curve
    gap: float
    angle: float
    is_fallback: bool


def border_between(guide: Guide, sides: Sequence[RegionFit], options: LocateOptions) -> Border:
    """Decide whether the surfaces on the two sides of a border cross or touch there.

    Surfaces at a small angle that do not touch, but cross, cross: the curve of equal
    normals would lie beside both.
    """
    surfaces = tuple(side.surface for side in sides)
    orientations = tuple(side.orientation for side in sides)
    crossing = Border(guide, surfaces, orientations, surfaces)
    touching = touching_border(guide, sides, options)
    if touching is None:
        return crossing
    points, gap = intersect(guide.points, surfaces)
    close = np.linalg.norm(points - guide.points, axis=1) <= MAX_MOVE
    if not close.all() or gap.max() >= _MAX_GAP:
        return touching
    least = np.degrees(angles(points, surfaces, orientations).min())
    if least >= MIN_CROSSING_DEG:
        return crossing
    contact, _ = intersect(guide.points, touching.constraints)
    is_near = np.linalg.norm(contact - guide.points, axis=1) <= MAX_MOVE
    touches = is_near.any() and distance(contact[is_near], surfaces).max() <= _MAX_TOUCH
    return touching if touches or least < _MIN_KINK_DEG else crossing


def touching_border(
    guide: Guide, sides: Sequence[RegionFit], options: LocateOptions
) -> Border | None:
    """The border as the curve of equal normals; None where the surfaces meet at an angle."""
    surfaces = tuple(side.surface for side in sides)
    orientations = tuple(side.orientation for side in sides)
    if len(surfaces) < 2:
        return None
    points, _ = intersect(guide.points, surfaces)
    close = np.linalg.norm(points - guide.points, axis=1) <= MAX_MOVE
    at = points if close.mean() > 0.5 else guide.points
    if np.degrees(np.median(angles(at, surfaces, orientations))) >= options.smooth_angle_deg:
        return None
    contact = Contact(surfaces[0], surfaces[1], orientations[0] * orientations[1]).told_along(at)
    return Border(guide, surfaces, orientations, (*surfaces, contact))


def contacts_at(
    vertex: Array, surfaces: Sequence[Surface], borders: Sequence[Border]
) -> list[Constraint]:
    """What holds a corner in directions in which its surfaces do not.

    Parameters
    ----------
    vertex : about where the corner is, shape ``(3,)``.
    surfaces : of the regions round it.
    borders : that end there.

    Returns
    -------
    The contacts of the smooth borders, and of creases that turn there because
    their surfaces touch.
    """
    contacts = [border.constraints[-1] for border in borders if border.is_contact]
    normals = np.concatenate([surface.project(vertex[None])[1] for surface in surfaces])
    spread = np.linalg.svd(normals, compute_uv=False)
    if contacts or len(spread) < 2 or spread[1] > _MAX_BRANCH_SPREAD * spread[0]:
        return contacts
    for border in borders:
        if len(border.surfaces) == 2:
            branch = Branch(*border.surfaces, border.orientations[0] * border.orientations[1])
            if branch.near(vertex[None])[1][0]:
                contacts.extend(branch.contacts)
    return contacts


def locate_crease(
    border: Border,
    ends: Ends,
    cloud: cKDTree,
    max_cloud_distance: float,
    options: LocateOptions,
    cusps: Sequence[bool] = (False, False),
) -> Crease:
    """Locate a border.

    Parameters
    ----------
    border : what it lies on and where it runs.
    ends : positions of its first and last vertex, each shape ``(3,)``; None if
        it is closed and has no corner.
    cloud : the raw points.
    max_cloud_distance : largest distance of the curve to the cloud, spacings.
    options : tolerances.
    cusps : see :func:`crispline.sharp.refine.curve_along`.

    Returns
    -------
    Crease
        A vertex within ``options.corner_gap`` of the common curve is left where
        it is and the curve ends at the nearest point to it; a farther one is
        joined by the curve.
    """
    guide = border.guide
    if len(border.surfaces) == 1:
        return _measured(rim_curve(guide, border.surfaces[0], ends, options), border)
    slack = 0.0
    feet = ends
    if ends is not None:
        slack = max(
            float(np.linalg.norm(ends[0] - guide.points[0])),
            float(np.linalg.norm(ends[1] - guide.points[-1])),
        )
        feet = _end_feet(ends, border.constraints)
    max_gap = options.corner_gap if border.is_contact else _MAX_GAP
    line = line_through(np.stack(ends), _MAX_TOUCH) if ends else None
    if line and not is_sane(line.samples(N_SAMPLES), guide, slack, cloud, max_cloud_distance):
        line = None
    beside: Array | None = None
    for points in traced(guide, border.constraints, feet, max_gap):
        leeway = slack + _rounded_off(border.angle(points))
        if is_sane(points, guide, leeway, cloud, max_cloud_distance):
            curve = curve_along(points, ends, border.constraints, options, cusps)
            if curve is not None:
                crease = _measured(curve, border)
                is_smooth = border.is_contact
                return _straightened(crease, border, line, max_gap) if is_smooth else crease
        elif beside is None:
            leeway += _LAST_MOVE - MAX_MOVE
            if is_sane(points, guide, leeway, cloud, max_cloud_distance):
                beside = points
    start = points = points_along(guide)
    for _ in range(N_ROUNDS):
        points = np.mean([surface.project(points)[0] for surface in border.surfaces], axis=0)
    smooth = curve_through(guide, start, points, ends)
    crease = replace(_measured(smooth, border), is_fallback=True)
    if beside is not None:
        curve = curve_along(beside, ends, border.constraints, options, cusps)
        # A curve beside the net, but in the cloud, is better than none, if it closes the gap.
        if curve is not None and (exact := _measured(curve, border)).gap < _CLOSED * crease.gap:
            crease = exact
    return _straightened(crease, border, line, max_gap)


def _straightened(crease: Crease, border: Border, line: Line | None, max_gap: float) -> Crease:
    """The line that a smooth or lost border may be, if it wanders and its surfaces allow that.

    Where surfaces that touch are nearly one for some way, their noise moves the curve on which
    they have equal normals to and fro. Where they touch nowhere, any curve leaves a gap, and one
    that leaves no less than the line does has no reason to bend. One more than twice as long goes
    back on itself, and no face has it as a border.
    """
    if line is None:
        return crease
    ratio = arc_length(crease.curve.samples(N_SAMPLES))[-1] / arc_length(line.samples(2))[-1]
    if ratio < _WANDERING:
        return crease
    straight = replace(_measured(line, border), is_fallback=crease.is_fallback)
    limit = max(_MAX_TOUCH if ratio < _FOLDED else max_gap, crease.gap)
    return straight if straight.gap <= limit else crease


def _measured(curve: Curve, border: Border) -> Crease:
    """A curve as that of a border."""
    samples = curve.samples(N_SAMPLES)
    gap = float(distance(samples, border.surfaces).max())
    return Crease(curve, gap, border.angle(samples), is_fallback=False)


def _rounded_off(angle: float) -> float:
    """How much farther than at a right angle the net passes a sharper edge, spacings.

    A round of radius 1 between faces that open by ``pi - angle`` leaves their edge by
    ``1 / cos(angle / 2) - 1``.
    """
    leaves = 1.0 / max(float(np.cos(0.5 * angle)), 1e-3)
    return float(np.clip(leaves - np.sqrt(2.0), 0.0, _MAX_ROUNDED_OFF))


def _end_feet(ends: tuple[Array, Array], constraints: Sequence[Constraint]) -> tuple[Array, Array]:
    """Nearest points of the curve to its vertices; the vertices themselves if they lie on it."""
    vertices = np.stack(ends)
    feet, _ = intersect(vertices, constraints)
    moved = np.linalg.norm(feet - vertices, axis=1)
    feet[moved < _EXACT] = vertices[moved < _EXACT]
    return feet[0], feet[1]
