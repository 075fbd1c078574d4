"""Bezier pieces joined to B-splines."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.spline.bezier import corner_points, gathered_patches
from crispline.spline.creased import CreasedNet, Index, net_sides, subdivided
from crispline.surface import BSplineSurface
from crispline.surface.base import Array
from crispline.surface.basis import DEGREE


def joined_knots(is_fine: NDArray[np.bool_], depth: int) -> Array:
    """Clamped cubic knots over unit intervals, some of them fine, shape ``(k + 8,)``.

    A fine interval has ``2^depth`` pieces that join with equal first derivatives; where
    that is one piece, it joins its neighbours so. All others have equal second derivatives.

    >>> joined_knots(np.array([True, False]), 1).tolist()
    [0.0, 0.0, 0.0, 0.0, 0.5, 0.5, 1.0, 2.0, 2.0, 2.0, 2.0]
    >>> joined_knots(np.array([True, False]), 0).tolist()
    [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]
    """
    n = len(is_fine)
    joints = np.arange(1, 2**depth) / 2**depth
    inside = np.flatnonzero(is_fine)[:, None] + joints
    is_rough = (is_fine[:-1] | is_fine[1:]) & (depth == 0)
    between = np.repeat(np.arange(1.0, n), 1 + is_rough)
    inner = np.sort(np.concatenate([between, np.repeat(inside.ravel(), 2)]))
    return np.concatenate([np.zeros(DEGREE + 1), inner, np.full(DEGREE + 1, float(n))])


def spline_controls(bezier: Array, knots: Array) -> Array:
    """Control points of a clamped cubic B-spline from the Bezier points of its pieces.

    Parameters
    ----------
    bezier : points of ``a`` cubic pieces between distinct knots, shape ``(3 a + 1, ...)``.
    knots : inner ones at most twice; at a single one the pieces before and after have equal
        first and second derivatives, at a double one equal first derivatives.

    Returns
    -------
    Shape ``(len(knots) - 4, ...)``. A control point is the blossom ``f`` at three knots:
    ``f(x, y, z) = f(x, y, y) + (z - y) / (y - x) (f(x, y, y) - f(x, x, y))``.
    """
    x, y, z = knots[1:-3], knots[2:-2], knots[3:-1]
    breaks = np.unique(knots)
    at = 3 * np.searchsorted(breaks, x)  # where the piece that begins at x begins
    rises, rises_again = x < y, y < z
    place = at + np.where(rises, 2, np.where(rises_again, 1, 0))
    controls = bezier[place]
    bent = np.flatnonzero(rises & rises_again)
    share = ((z - y) / np.where(rises, y - x, 1.0))[bent]
    share = share.reshape(-1, *[1] * (bezier.ndim - 1))
    controls[bent] += share * (bezier[place[bent]] - bezier[place[bent] - 1])
    return controls


@dataclass(frozen=True)
class Fine:
    """Patches of quads that are not exactly the limit surface, as finer ones that are nearer.

    Attributes
    ----------
    depth : how often the quads were subdivided; the inner joints of each have continuous
        tangents, as a vertex that is not regular is never inside a quad.
    number : the row of each quad in ``grids``, -1 for exact ones, shape ``(m,)``.
    grids : Bezier points, shape ``(k, s, s, 3)`` with ``s = 3 * 2^depth + 1``; axes as in
        :func:`crispline.spline.bezier.bezier_patches`.
    """

    depth: int
    number: Index
    grids: Array

    def sides(self, half_edge: Index) -> Array:
        """Bezier points along sides of quads that are not exact, shape ``(n, s, 3)``."""
        grids = self.grids[self.number[half_edge // 4]]
        found = np.empty_like(grids[:, 0])
        borders = (grids[:, :, 0], grids[:, -1], grids[:, ::-1, -1], grids[:, 0, ::-1])
        for side, border in enumerate(borders):
            mine = half_edge % 4 == side
            found[mine] = border[mine]
        return found


def fine_patches(net: CreasedNet, quads: Index, depth: int) -> Fine:
    """The patches of some quads, from the net subdivided round them."""
    number = np.full(len(net.quads), -1)
    number[quads] = np.arange(len(quads))
    if not len(quads):
        return Fine(depth, number, np.empty((0, 3 * 2**depth + 1, 3 * 2**depth + 1, 3)))
    near = _around(net, quads)
    for _ in range(depth):
        near = subdivided(near)
    grids = gathered_patches(corner_points(near), near.quads[: len(quads) * 4**depth])
    for _ in range(depth):
        grids = _four_to_one(grids)
    return Fine(depth, number, grids)


def rectangle_surfaces(patches: Array, fine: Fine, blocks: list[Index]) -> list[BSplineSurface]:
    """One B-spline from the patches of each rectangle, one unit of its parameters a quad.

    Parameters
    ----------
    patches : Bezier patches of the whole net, shape ``(m, 4, 4, 3)``.
    fine : takes the place of those that are not exact, which only the corners of a
        rectangle may be.
    blocks : turned quads, shape ``(a, b)``, see :func:`crispline.spline.rectangles.rectangles`.
    """
    alike: dict[tuple[object, ...], list[int]] = {}
    for index, block in enumerate(blocks):
        ends = block[:: max(len(block) - 1, 1), :: max(block.shape[1] - 1, 1)]
        is_fine = fine.number[ends // 4] >= 0
        alike.setdefault((block.shape, is_fine.tobytes()), []).append(index)
    surfaces: list[BSplineSurface] = [None] * len(blocks)  # type: ignore[list-item]
    for group in alike.values():
        many = np.stack([blocks[index] for index in group], axis=-1)
        knots_u, knots_v, controls = _alike_surfaces(patches, fine, many)
        for index, mine in zip(group, np.moveaxis(controls, 2, 0), strict=True):
            surfaces[index] = BSplineSurface(knots_u, knots_v, np.ascontiguousarray(mine))
    return surfaces


def _alike_surfaces(patches: Array, fine: Fine, blocks: Index) -> tuple[Array, Array, Array]:
    """Knots and control points ``(p, q, k, 3)`` of ``k`` rectangles with fine quads at the
    same places; ``blocks`` has shape ``(a, b, k)``.
    """
    a, b, k = blocks.shape
    turned = np.empty((a, b, k, 4, 4, 3))
    for corner in range(4):
        mine = blocks % 4 == corner
        turned[mine] = np.rot90(patches[blocks[mine] // 4], -corner, axes=(1, 2))
    grid = np.empty((3 * a + 1, 3 * b + 1, k, 3))
    for p in range(4):
        for q in range(4):
            grid[p : 3 * a - 2 + p : 3, q : 3 * b - 2 + q : 3] = turned[..., p, q, :]
    is_fine = fine.number[blocks[..., 0] // 4] >= 0
    in_u, in_v = (np.asarray(is_fine.any(axis=axis)) for axis in (1, 0))
    grid = _with_fine_ends(grid, in_u, fine.depth)
    grid = _with_fine_ends(grid.swapaxes(0, 1), in_v, fine.depth).swapaxes(0, 1)
    size = fine.grids.shape[1]
    for i, j in {(0, 0), (0, b - 1), (a - 1, 0), (a - 1, b - 1)}:
        if is_fine[i, j]:
            along = slice(0, size) if i == 0 else slice(len(grid) - size, None)
            across = slice(0, size) if j == 0 else slice(grid.shape[1] - size, None)
            for corner in range(4):
                mine = np.flatnonzero(blocks[i, j] % 4 == corner)
                finer = fine.grids[fine.number[blocks[i, j, mine] // 4]]
                turned_finer = np.rot90(finer, -corner, axes=(1, 2))
                grid[along, across, mine] = np.moveaxis(turned_finer, 0, 2)
    knots_u, knots_v = joined_knots(in_u, fine.depth), joined_knots(in_v, fine.depth)
    along_u = spline_controls(grid, knots_u).swapaxes(0, 1)
    return knots_u, knots_v, spline_controls(along_u, knots_v).swapaxes(0, 1)


def _with_fine_ends(bezier: Array, is_fine: NDArray[np.bool_], depth: int) -> Array:
    """The same pieces, the first and last cut into ``2^depth`` if they are fine."""
    first = _cut(bezier[:4], depth if is_fine[0] else 0)
    if len(is_fine) == 1:
        return first
    last = _cut(bezier[-4:], depth if is_fine[-1] else 0)
    return np.concatenate([first, bezier[4:-3], last[1:]])


def _cut(piece: Array, depth: int) -> Array:
    """A cubic in halves of halves, ``depth`` times: its Bezier points (de Casteljau 1959)."""
    if depth == 0:
        return piece
    rows, start, end = piece, [piece[0]], [piece[-1]]
    for _ in range(DEGREE):
        rows = 0.5 * (rows[:-1] + rows[1:])
        start.append(rows[0])
        end.append(rows[-1])
    halves = _cut(np.stack(start), depth - 1), _cut(np.stack(end[::-1]), depth - 1)
    return np.concatenate([halves[0], halves[1][1:]])


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
