"""Walls that taper off between two faces which part slowly.

A face that rises out of another as gently as a ramp has a wall beside it that ends in a wedge.
Where the wall is lower than a patch the regions of the two faces touch, though their surfaces do
not meet there but at the wedge's tip. The wall's surface is known, and where it passes along such
a border it goes on between the two.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from crispline.net.halfedge import HalfEdges
from crispline.options import RegionOptions
from crispline.region.borders import Borders
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit

Mask = NDArray[np.bool_]

_APART = 0.25  # surfaces that are nearer to each other than this meet as well as they can, spacings
_ALONG = 1.5  # a border so near to a wall's surface runs along it, spacings
_UPRIGHT = np.cos(np.radians(60.0))  # walls lean less than this from both faces
_ALIKE = np.cos(np.radians(20.0))  # the two faces lean less from each other than this
_FAR = 3.0  # spacings
_MIN_SIDES = 2


def with_wedges(
    label: Labels,
    fits: Mapping[int, RegionFit],
    graph: PatchGraph,
    quads: HalfEdges,
    options: RegionOptions,
) -> tuple[Labels, set[int]]:
    """Labels in which walls go on between faces that do not meet, and which walls did.

    Parameters
    ----------
    label, fits : regions and surface of each.
    """
    label = label.copy()
    grown: set[int] = set()
    corners = quads.origin.reshape(-1, 4)
    for pair, wall, along in list(_borders(label, fits, graph, options)):
        sides = graph.pairs[along]
        patches = np.unique(sides)
        # Only from where the wall ends already: elsewhere another face passes by.
        reached = np.zeros(quads.n_vertices, dtype=bool)
        reached[corners[label == wall]] = True
        while True:
            touched = reached.copy()
            touched[corners[patches[reached[corners[patches]].any(axis=1)]]] = True
            if np.array_equal(touched, reached):
                break
            reached = touched
        patches = patches[reached[corners[patches]].all(axis=1)]
        size = np.bincount(label, minlength=max(pair) + 1)
        giving = max(pair, key=lambda name: (int(size[name]), name))
        taken = patches[label[patches] == giving]
        if len(taken) < _MIN_SIDES:
            continue
        keeping = pair[0] if giving == pair[1] else pair[1]
        others = np.zeros(quads.n_vertices, dtype=bool)
        others[corners[patches[label[patches] == keeping]]] = True
        beside = (label == giving) & others[corners].any(axis=1)
        label[taken] = wall
        label[beside] = wall  # no two of them may touch across a vertex
        grown.add(wall)
    return label, grown


def _borders(
    label: Labels, fits: Mapping[int, RegionFit], graph: PatchGraph, options: RegionOptions
) -> Iterator[tuple[tuple[int, int], int, NDArray[np.int64]]]:
    """Two faces, a wall that touches both, and the sides of their border along it."""
    size = np.bincount(label)
    borders = Borders.of(label, graph)
    pairs = borders.regions
    for a, b in pairs.tolist():
        if min(size[a], size[b]) < options.crumb_patches:
            continue
        if not (fits[a].is_accepted and fits[b].is_accepted):
            continue
        sides = borders.sides(a, b)
        places = graph.points[graph.pairs[sides]].mean(axis=1)
        (first, up), (second, also) = (fits[name].surface.project(places) for name in (a, b))
        alike = fits[a].orientation * fits[b].orientation * np.einsum("ij,ij->i", up, also)
        height = np.linalg.norm(first - second, axis=1)
        # Where their tangent planes cross is so far from the border that it is not that.
        is_apart = height > np.maximum(_APART, _FAR * np.sqrt(np.maximum(1.0 - alike**2, 0.0)))
        is_apart &= (height < options.max_step_height) & (alike > _ALIKE)
        if np.count_nonzero(is_apart) < _MIN_SIDES:
            continue
        beside = [set(pairs[(pairs == name).any(axis=1)].ravel().tolist()) for name in (a, b)]
        for wall in sorted((beside[0] & beside[1]) - {a, b}):
            if size[wall] < options.crumb_patches or not fits[wall].is_accepted:
                continue
            feet, normals = fits[wall].surface.project(0.5 * (first + second))
            away = np.linalg.norm(feet - 0.5 * (first + second), axis=1)
            is_upright = np.abs(np.einsum("ij,ij->i", normals, up)) < _UPRIGHT
            along = is_apart & is_upright & (away < _ALONG)
            if np.count_nonzero(along) >= _MIN_SIDES:
                yield (a, b), wall, sides[along]
