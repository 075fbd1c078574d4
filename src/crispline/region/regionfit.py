"""What is known about one region once a surface has been fitted to it."""

from __future__ import annotations

from dataclasses import dataclass

from crispline.surface import Surface
from crispline.surface.base import Array


@dataclass(frozen=True)
class RegionFit:
    """A region's surface and the raw points that it explains.

    Attributes
    ----------
    surface : the fitted surface.
    orientation : +1 if the surface's own normal points out of the part, else -1.
    points : raw points of the region, shape ``(k, 3)``.
    residuals : their signed distances to the surface, shape ``(k,)``.
    is_accepted : whether the residuals are what noise explains.
    """

    surface: Surface
    orientation: int
    points: Array
    residuals: Array
    is_accepted: bool = True
