"""Nets whose surface passes through given points instead of lying inside of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from crispline.spline.bezier import corner_points
from crispline.spline.creased import CreasedNet
from crispline.spline.sectors import net_sectors


def passing_through(net: CreasedNet, n_rounds: int = 8) -> CreasedNet:
    """The net whose limit surface passes through the vertices of another.

    A limit surface cuts the bends of its control net: by ``h^2 / 3R`` on a sphere of
    radius ``R`` covered with quads of side ``h``. Each round moves every control
    point by what its limit point still misses.

    Parameters
    ----------
    net : its vertices are the points to pass through.
    n_rounds : after ``n`` rounds at most ``(2/3)^n`` of the miss is left along creases and
        ``(8/9)^n`` of a miss that alternates from vertex to vertex; a smooth one is gone
        after a few. Noise is followed the less, the rougher it is.

    Returns
    -------
    A net with the same quads, creases and corners. Corners stay where they are, as do
    vertices without quads.
    """
    control, sectors = net, net_sectors(net)
    for _ in range(n_rounds):
        miss = net.vertices - corner_points(control, sectors).position
        control = replace(control, vertices=control.vertices + np.nan_to_num(miss))
    return control
