"""Bezier pieces joined to B-splines."""

from __future__ import annotations

import numpy as np

from crispline.spline.bezier import corner_points, gathered_patches
from crispline.spline.creased import CreasedNet, Index, net_sides, subdivided
from crispline.surface import BSplineSurface
from crispline.surface.base import Array
from crispline.surface.basis import uniform_knots


def uniform_controls(bezier: Array) -> Array:
    """Control points of a clamped uniform cubic B-spline from the points of its pieces.

    Parameters
    ----------
    bezier : points of ``a`` cubic pieces over unit intervals that join with equal
        first and second derivatives, shape ``(3 a + 1, ...)``.

    Returns
    -------
    Shape ``(a + 3, ...)``, for the knots ``uniform_knots(0, a, a)``. A control point
    is the blossom at three knots, and ``f(0, 1, 2) = 2 f(0, 1, 1) - f(0, 0, 1)``.
    """
    inner = 2.0 * bezier[2:-3:3] - bezier[1:-3:3]
    return np.concatenate([bezier[:2], inner, bezier[-2:]])


def rectangle_surface(patches: Array, block: Index) -> BSplineSurface:
    """One uniform B-spline from the exact patches of a rectangle.

    Parameters
    ----------
    patches : Bezier patches of the whole net, shape ``(m, 4, 4, 3)``.
    block : turned quads, shape ``(a, b)``, see :func:`crispline.spline.rectangles.rectangles`.
    """
    a, b = block.shape
    turned = np.empty((a, b, 4, 4, 3))
    for corner in range(4):
        mine = block % 4 == corner
        turned[mine] = np.rot90(patches[block[mine] // 4], -corner, axes=(1, 2))
    grid = np.empty((3 * a + 1, 3 * b + 1, 3))
    for p in range(4):
        for q in range(4):
            grid[p : 3 * a - 2 + p : 3, q : 3 * b - 2 + q : 3] = turned[:, :, p, q]
    along_u = uniform_controls(grid).swapaxes(0, 1)
    controls = uniform_controls(along_u).swapaxes(0, 1)
    return BSplineSurface(uniform_knots(0.0, a, a), uniform_knots(0.0, b, b), controls)


def refined_surfaces(net: CreasedNet, quads: Index, depth: int) -> list[BSplineSurface]:
    """Surfaces of some quads over the unit square, from the net subdivided round them.

    Each has ``2^depth x 2^depth`` bicubic pieces. Where these join, tangents are
    continuous: a vertex that is not regular is never inside a quad.
    """
    near = _around(net, quads)
    for _ in range(depth):
        near = subdivided(near)
    n_patches = len(quads) * 4**depth
    grids = gathered_patches(corner_points(near), near.quads[:n_patches])
    for _ in range(depth):
        grids = _four_to_one(grids)
    # Equal derivatives put each joint midway between its neighbours: it is no control point.
    index = np.arange(grids.shape[1])
    kept = index[(index % 3 != 0) | (index == 0) | (index == index[-1])]
    joints = np.arange(1, 2**depth) / 2**depth
    knots = np.concatenate([np.zeros(4), np.repeat(joints, 2), np.ones(4)])
    return [BSplineSurface(knots, knots, grid[np.ix_(kept, kept)]) for grid in grids]


def _around(net: CreasedNet, quads: Index) -> CreasedNet:
    """The part of a net that the surface of some quads depends on; these come first."""
    is_chosen = np.zeros(len(net.quads), dtype=bool)
    is_chosen[quads] = True
    is_near = np.zeros(len(net.vertices), dtype=bool)
    is_near[net.quads[quads]] = True
    others = np.flatnonzero(is_near[net.quads].any(axis=1) & ~is_chosen)
    kept = net.quads[np.concatenate([quads, others])]
    used, local = np.unique(kept, return_inverse=True)
    local = local.reshape(-1, 4)
    number = np.full(len(net.vertices), -1)
    number[used] = np.arange(len(used))
    none = np.zeros((0, 2), dtype=np.int64)
    ends = net_sides(local.ravel(), np.roll(local, -1, axis=1).ravel(), none, len(used)).ends
    creases = np.sort(number[net.creases], axis=1)
    creases = creases[(creases >= 0).all(axis=1)]
    is_side = np.isin(creases @ [len(used), 1], ends @ [len(used), 1])
    corners = number[net.corners]
    return CreasedNet(net.vertices[used], local, creases[is_side], corners[corners >= 0])


def _four_to_one(grids: Array) -> Array:
    """Grids of Bezier points of the four children of each quad as one grid.

    Child ``i`` starts at corner ``i`` of its quad and is turned by as many right angles.
    """
    size = grids.shape[1]
    children = grids.reshape(-1, 4, size, size, 3)
    joined = np.empty((len(children), 2 * size - 1, 2 * size - 1, 3))
    low, high = slice(0, size), slice(size - 1, None)
    for i, place in enumerate([(low, low), (high, low), (high, high), (low, high)]):
        joined[:, *place] = np.rot90(children[:, i], i, axes=(1, 2))
    return joined
