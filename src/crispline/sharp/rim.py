"""The free border of a face, where the scan ends: a smooth curve on one surface.

No second surface tells where a rim runs, only where the points end, and that is ragged.
So a rim is smoothed, cut into parts at its corners, and straight or round where it is
one within the raggedness.
"""

from __future__ import annotations

import numpy as np

from crispline.curve import (
    Curve,
    arc_length,
    circle_through,
    interpolated,
    resampled,
    smoothed,
)
from crispline.options import LocateOptions
from crispline.region.topology import Topology
from crispline.sharp.network import corner_vertices, rotated, split
from crispline.sharp.refine import curve_along
from crispline.sharp.trace import Guide, forward, smoothing_rounds
from crispline.surface import Plane, Surface
from crispline.surface.base import Array, unit
from crispline.surface.intersect import Constraint, intersect

_ARM = 8  # net vertices on either side of a corner that must be straight ...
_SKIP = 2  # ... without those next to it, which the end of the points rounds off
_MIN_TURN = np.radians(35.0)
_MAX_CORNER_MOVE = 3.0
_ROUNDED = 3.0  # a smoothed rim rounds off its corners over this length


def split_at_kinks(
    topology: Topology, net_vertices: Array, options: LocateOptions
) -> tuple[Topology, Array]:
    """Put a corner wherever a rim turns sharply between two straight stretches.

    Returns
    -------
    topology : with the rims cut at their corners.
    net_vertices : with the new corners where the stretches beside them meet, and the ends
        of creases where these meet the rims.
    """
    net_vertices = net_vertices.copy()
    corners = set(corner_vertices(topology))
    for index, chain in enumerate(topology.chains):
        if chain.right != -1:
            continue
        is_ring = chain.is_closed and int(chain.vertices[0]) not in corners
        path = net_vertices[chain.vertices]
        if is_ring and circle_through(path, 2.0 * options.rim_raggedness, is_closed=True):
            continue
        kinks = _kinks(path, is_ring, options.rim_raggedness)
        positions = sorted(kinks)
        if is_ring and len(positions) < 2:
            continue
        for position in positions:
            net_vertices[chain.vertices[position]] = kinks[position]
        if is_ring:
            topology = rotated(topology, index, positions[0])
            positions = [position - positions[0] for position in positions[1:]]
        # From the back, so that the front part keeps its index and its positions.
        for position in reversed(positions):
            topology = split(topology, index, position)
    return topology, _with_straight_ends(topology, net_vertices, options.rim_raggedness)


def rim_curve(
    guide: Guide, surface: Surface, ends: tuple[Array, Array] | None, options: LocateOptions
) -> Curve:
    """The curve of a rim, on its surface.

    Parameters
    ----------
    guide : where the points end, smoothed.
    surface : of the face.
    ends : positions of the first and last vertex; None for a closed rim.

    Returns
    -------
    Curve
        The cut of the surface with a plane if the rim stays within
        ``options.rim_raggedness`` of it, or a circle on a plane; else a B-spline.
    """
    # Smoothing draws round rims inward; adding back what a second smoothing takes away
    # (Tukey's twicing) leaves only the square of that.
    n_rounds = smoothing_rounds(len(guide.points))
    again = smoothed(guide.points, n_rounds, guide.is_closed)
    path = surface.project(2.0 * guide.points - again)[0]
    if ends is None:
        path[-1] = path[0]
        if isinstance(surface, Plane):
            circle = circle_through(path, options.rim_raggedness, is_closed=True)
            if circle is not None:
                return circle
    carrier = _cutting_plane(path, surface, ends, options.rim_raggedness)
    constraints: list[Constraint] = [surface] if carrier is None else [surface, carrier]
    directions = guide.directions()
    if ends is None:
        ordered = forward(path, directions, None)
        points = ordered if len(ordered) >= 6 else path
    else:
        # Near a corner the guide is rounded off, and would lead back to it in a hook.
        away = np.linalg.norm(path[:, None] - np.stack(ends), axis=2).min(axis=1)
        inner = away > min(_ROUNDED, 0.25 * guide.length)
        if not inner.any():
            inner[1:-1] = True
        points = forward(path[inner], directions[inner], ends)
        if len(points) == 2 and np.linalg.norm(ends[1] - ends[0]) < 1.0:
            points = np.stack([ends[0], path[len(path) // 2], ends[1]])
    points = _moved_to(points, constraints, keeps_ends=ends is not None)
    if len(points) < 5:
        points = resampled(points, 9)
    found = curve_along(points, ends, constraints, options)
    return found or interpolated(guide.points, guide.is_closed)


def _with_straight_ends(topology: Topology, net_vertices: Array, raggedness: float) -> Array:
    """The net's vertices, with the ends of rims where straight rims and creases meet.

    The end of the points is rounded off at corners, and ragged: the longest straight
    stretch of each border tells best where it leads.
    """
    arms: dict[int, tuple[list[Array], list[Array]]] = {}
    for chain in topology.chains:
        if chain.is_closed:
            continue
        for vertices in (chain.vertices, chain.vertices[::-1]):
            rims, creases = arms.setdefault(int(vertices[0]), ([], []))
            arm = _straight_arm(net_vertices[vertices], raggedness)
            if arm is not None:
                (rims if chain.right == -1 else creases).append(arm)
    moved = net_vertices.copy()
    for vertex, (rims, creases) in arms.items():
        if len(rims) == 2 and not creases:
            rims, creases = rims[:1], rims[1:]
        if not rims or not creases:
            continue
        # Every rim with every crease; where a rim leaves another, that one stands for it.
        rim, crease = np.repeat(rims, len(creases), axis=0), np.tile(creases, (len(rims), 1, 1))
        meeting, gap = _meeting(rim[:, 0], rim[:, 1], crease[:, 0], crease[:, 1])
        is_good = np.abs(np.einsum("ij,ij->i", rim[:, 1], crease[:, 1])) < np.cos(_MIN_TURN)
        away = np.linalg.norm(meeting - net_vertices[vertex], axis=1)
        is_good &= (gap < 2.0) & (away < _MAX_CORNER_MOVE)
        if is_good.any():
            moved[vertex] = meeting[is_good].mean(axis=0)
    return moved


def _straight_arm(path: Array, raggedness: float) -> Array | None:
    """Point and direction ``(2, 3)`` of the longest straight start of a chain, if there is any."""
    length = len(path) - 2 * _SKIP
    while length >= _ARM:
        point, direction, rough = _lines(path[None, _SKIP : _SKIP + length])
        if rough[0] < 0.7 * raggedness:
            return np.concatenate([point, direction])
        length //= 2
    return None


def _kinks(path: Array, is_ring: bool, raggedness: float) -> dict[int, Array]:
    """Positions at which a chain turns between straight arms, and where the arms meet."""
    n = len(path) - 1 if is_ring else len(path)
    reach = _SKIP + _ARM
    if n < (2 * reach if is_ring else 2 * reach + 1):
        return {}
    index = np.arange(n) if is_ring else np.arange(reach, n - reach)
    steps = np.arange(_SKIP, reach)
    before, after = path[(index[:, None] - steps) % n], path[(index[:, None] + steps) % n]
    start, heading, rough_before = _lines(before)
    end, onward, rough_after = _lines(after)
    turn = np.arccos(np.clip(-np.einsum("ij,ij->i", heading, onward), -1.0, 1.0))
    is_straight = np.maximum(rough_before, rough_after) < raggedness
    meeting, gap = _meeting(start, heading, end, onward)
    is_near = np.linalg.norm(meeting - path[index], axis=1) < _MAX_CORNER_MOVE
    score = np.where(is_straight & is_near & (gap < 2.0) & (turn > _MIN_TURN), turn, 0.0)
    # Of a run of candidates the one nearest to where its arms meet stands for all.
    away = np.linalg.norm(meeting - path[index], axis=1)
    order = [i for i in np.lexsort((index, away)) if score[i] > 0.0]
    kinks: dict[int, Array] = {}
    for i in order:
        others = np.abs(np.array(list(kinks), dtype=np.int64) - index[i])
        if is_ring:
            others = np.minimum(others, n - others)
        if len(others) == 0 or others.min() > _ARM:
            kinks[int(index[i])] = meeting[i]
    return kinks


def _lines(points: Array) -> tuple[Array, Array, Array]:
    """Least-squares lines through rows of points ``(m, k, 3)``, away from the first point.

    Returns a point of each line, its unit direction, and the rms distance to it.
    """
    middle = points.mean(axis=1)
    offset = points - middle[:, None]
    values, axes = np.linalg.eigh(np.einsum("mki,mkj->mij", offset, offset))
    direction = axes[:, :, 2]
    along = np.einsum("mi,mi->m", points[:, -1] - points[:, 0], direction)
    direction = np.where(along < 0.0, -1.0, 1.0)[:, None] * direction
    rough = np.sqrt(np.maximum(values[:, :2].sum(axis=1), 0.0) / points.shape[1])
    return middle, direction, rough


def _meeting(a: Array, u: Array, b: Array, v: Array) -> tuple[Array, Array]:
    """Midpoints between pairs of lines where they are closest, and their distance there."""
    between = b - a
    dot = np.einsum("ij,ij->i", u, v)
    sine = np.maximum(1.0 - dot**2, 1e-12)
    along_u, along_v = np.einsum("ij,ij->i", between, u), np.einsum("ij,ij->i", between, v)
    foot_a = a + ((along_u - dot * along_v) / sine)[:, None] * u
    foot_b = b + ((dot * along_u - along_v) / sine)[:, None] * v
    return 0.5 * (foot_a + foot_b), np.linalg.norm(foot_a - foot_b, axis=1)


def _cutting_plane(
    path: Array, surface: Surface, ends: tuple[Array, Array] | None, raggedness: float
) -> Plane | None:
    """The plane in which a rim lies, through its ends; None if it lies in none."""
    if ends is None:
        if isinstance(surface, Plane):
            return None
        origin = path[:-1].mean(axis=0)
        normal = np.linalg.svd(path[:-1] - origin, full_matrices=False)[2][2]
    else:
        origin, chord = ends[0], ends[1] - ends[0]
        if np.linalg.norm(chord) < 0.3 * arc_length(path)[-1]:
            return None
        chord = unit(chord)
        offset = path - origin
        offset = offset - (offset @ chord)[:, None] * chord
        upright = np.cross(chord, surface.project(path)[1].mean(axis=0))
        if np.linalg.norm(upright) < 0.5:
            return None
        normal = unit(upright)
        if not _is_within(np.linalg.norm(offset, axis=1), raggedness):
            # Bent: the plane holds the bulge as well.
            bulge = np.linalg.svd(offset, full_matrices=False)[2][0]
            normal = unit(np.cross(chord, bulge))
    if not _is_within(np.abs((path - origin) @ normal), raggedness):
        return None
    # A plane that grazes the surface does not tell where the rim runs.
    across = np.abs(surface.project(path)[1] @ normal)
    if across.max() > 0.9:
        return None
    return Plane(origin, normal)


def _is_within(distance: Array, raggedness: float) -> bool:
    """Whether distances are no more than what a ragged end of the points explains."""
    rms = float(np.sqrt(np.mean(distance**2)))
    return rms <= 0.5 * raggedness and float(distance.max()) <= 1.5 * raggedness


def _moved_to(points: Array, constraints: list[Constraint], keeps_ends: bool) -> Array:
    """Points on all constraints; the ends of an open rim stay."""
    moved, _ = intersect(points, constraints)
    if keeps_ends:
        moved[0], moved[-1] = points[0], points[-1]
    else:
        moved[-1] = moved[0]
    return moved
