"""Vertices of the net onto the surface of their region.

The net follows the points with their noise, and within three spacings of a sharp edge the
projection of its vertices is drawn outwards. A region's surface averages over all of its
points, so the bicubic surface is better for passing through that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from crispline.net.quads import QuadNet
from crispline.region.patches import Labels
from crispline.region.regionfit import RegionFit


def settled(
    net: QuadNet, label: Labels, regions: Mapping[int, RegionFit], max_move: float
) -> QuadNet:
    """The net with the inner vertices of every region on its surface.

    Parameters
    ----------
    net : in the frame of the surfaces.
    label : region of every quad, shape ``(m,)``.
    regions : surface of every label.
    max_move : a vertex farther from the surface stays: there the surface does not explain
        the points.
    """
    n = len(net.vertices)
    lowest, highest = np.full(n, np.iinfo(np.int64).max), np.full(n, -1)
    of_corner = np.repeat(label, 4)
    np.minimum.at(lowest, net.quads.ravel(), of_corner)
    np.maximum.at(highest, net.quads.ravel(), of_corner)
    inner = np.where(lowest == highest, lowest, -1)
    vertices = net.vertices.copy()
    for region, fit in sorted(regions.items()):
        mine = np.flatnonzero(inner == region)
        foot = fit.surface.project(vertices[mine])[0]
        is_near = np.linalg.norm(foot - vertices[mine], axis=1) <= max_move
        vertices[mine[is_near]] = foot[is_near]
    return replace(net, vertices=vertices)
