"""Borders and corners of a sculpture: drawn between their surfaces, where they are sharp.

Its model is of patches, which need creases to follow and nothing else. No curve on two
surfaces is solved for, and where a border is smooth the net is as good a place as any.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from crispline.curve import Curve, interpolated, line_through, resampled
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.sharp.contact import Contact
from crispline.sharp.corner import Corner
from crispline.sharp.crease import Border, Crease, curve_gap, smoothed_crease
from crispline.sharp.trace import Guide, forward
from crispline.surface import Surface
from crispline.surface.base import Array
from crispline.surface.intersect import distance, newton_step

N_SAMPLES = 25
"""Points per curve at which its distance to the surfaces is measured."""

_N_PLACES = 15  # along a guide, to tell its angle
_N_SMOOTH = 8  # of the curve of a smooth border
_NEWTON_STEPS = 2


def drawn_border(guide: Guide, sides: Sequence[RegionFit], options: LocateOptions) -> Border:
    """The border, a contact where the surfaces meet at less than ``smooth_angle_deg``."""
    surfaces = tuple(side.surface for side in sides)
    orientations = tuple(side.orientation for side in sides)
    border = Border(guide, surfaces, orientations, surfaces)
    if len(surfaces) < 2:
        return border
    places = np.linspace(0, len(guide.points) - 1, min(_N_PLACES, len(guide.points)))
    if np.degrees(border.angle(guide.points[places.astype(np.int64)])) >= options.smooth_angle_deg:
        return border
    contact = Contact(surfaces[0], surfaces[1], orientations[0] * orientations[1])
    return replace(border, constraints=(*surfaces, contact))


def drawn_corner(net_vertex: Array, surfaces: Sequence[Surface], options: LocateOptions) -> Corner:
    """Where sharp borders meet: after two of Newton's steps to their surfaces, if that is near.

    Parameters
    ----------
    net_vertex : shape ``(3,)``.
    surfaces : of the regions beside the border, two or more.
    """
    position = net_vertex[None]
    for _ in range(_NEWTON_STEPS):
        position = position + newton_step(position, surfaces)
    if np.linalg.norm(position - net_vertex) > options.corner_move:
        position = net_vertex[None]
    return Corner(position[0], float(distance(position, surfaces)[0]), is_fallback=False)


def drawn_crease(border: Border, ends: tuple[Array, Array] | None) -> Crease:
    """The curve of a border, through its vertices; ``ends`` is None if it is closed."""
    if not border.is_contact:
        return smoothed_crease(border, ends, N_SAMPLES)
    guide = border.guide
    if ends is None:
        curve: Curve = interpolated(guide.points, is_closed=True)
    else:
        inner = resampled(guide.points, _N_SMOOTH)[1:-1]
        directions = Guide(guide.points, is_closed=False).directions()
        middle = directions[np.linspace(0, len(directions) - 1, _N_SMOOTH).astype(np.int64)[1:-1]]
        ordered = forward(inner, middle, ends)
        if len(ordered) == 2:
            halfway = guide.points[len(guide.points) // 2]
            curve = line_through(ordered, 0.0) or interpolated(
                np.stack([ends[0], halfway, ends[1]]), is_closed=False
            )
        else:
            curve = interpolated(ordered, is_closed=False)
    return Crease(curve, curve_gap(curve, border.surfaces, N_SAMPLES), is_fallback=False)
