"""Chains of straight lines between two known ones: the profiles of grooves and undercuts.

In the half plane of an axis a turned part is a polygon: faces across the axis are lines along
the radius, faces about it are lines along the axis, chamfers anything between. All points of a
ring fall on a short piece of it, so that even sides shorter than the spacing of the points
stand out there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

from crispline.fit.outline import (
    Ray,
    densities,
    from_ray,
    outline_between,
    outline_cost,
    price,
)
from crispline.fit.swept import Line, fit_line
from crispline.surface.base import Array

_AXIAL, _RADIAL = 0.0, np.pi / 2.0  # angles of the normals of lines along the axis and across it
_FREE = np.nan
_KINDS = (
    (_FREE,),
    (_AXIAL,),
    (_RADIAL,),
    (_AXIAL, _RADIAL),
    (_RADIAL, _AXIAL),
    (_RADIAL, _AXIAL, _RADIAL),
    (_AXIAL, _RADIAL, _AXIAL),
)
_SLANTS = np.radians([30.0, 60.0, 120.0, 150.0])  # of chamfers, to begin with
_QUANTILES = (0.1, 0.5, 0.9)  # where lines are first looked for among the points
_MIN_TURN = np.radians(15.0)  # between lines that follow each other
_MAX_ROUNDS = 20
_REACH = 3.0  # sigmas; points farther from the chain do not move it
_MIN_POINTS = 8
_AT_REST = 0.1  # nats


@dataclass(frozen=True)
class Chain:
    """Lines that lead from one ray to another.

    Attributes
    ----------
    rays : the two, as their points near the chain have them.
    lines : between the rays, in order, ``k`` of them.
    vertices : where they meet each other and the rays, shape ``(k + 1, 2)``.
    part : to which part each point belongs, 0 and ``k + 1`` for the rays, shape ``(n,)``.
    cost : description length of the points, see :func:`outline_cost`, and of the lines.
    """

    rays: tuple[Ray, Ray]
    lines: tuple[Line, ...]
    vertices: Array
    part: NDArray[np.int64]
    cost: float

    @property
    def lengths(self) -> Array:
        """Of the lines, shape ``(k,)``."""
        return np.asarray(np.linalg.norm(np.diff(self.vertices, axis=0), axis=1))

    def nearest_part(self, flat: Array) -> NDArray[np.int64]:
        """The part that is nearest to each of some points ``(n, 2)``."""
        return np.asarray(np.argmin(_distances(flat, self.vertices, self.rays), axis=0))


def fit_chain(
    flat: Array,
    is_lost: NDArray[np.bool_],
    rays: tuple[Ray, Ray],
    sigma: float,
    min_length: float,
) -> Chain | None:
    """The chain of one to three lines of least description length.

    Parameters
    ----------
    flat : points, shape ``(n, 2)``: distance from the axis and height along it.
    is_lost : which of them lie off both rays, shape ``(n,)``.
    rays : what the chain connects.
    sigma : noise, spacings.
    min_length : of every line, spacings.
    """
    if np.count_nonzero(is_lost) < _MIN_POINTS:
        return None
    best: dict[tuple[float, ...], Chain] = {}
    for lines in _starts(flat[is_lost]):
        chain = _settled(lines, flat, rays, sigma, min_length)
        if chain is None:
            continue
        kind = tuple(-1.0 if _is_slanted(line) else line.angle for line in chain.lines)
        if kind not in best or chain.cost < best[kind].cost:
            best[kind] = chain
    polished = [_polished(chain, flat, sigma, min_length) for chain in best.values()]
    return min(polished, key=lambda chain: chain.cost, default=None)


def corner_cost(flat: Array, rays: tuple[Ray, Ray], sigma: float) -> float:
    """The cost of points if nothing is between two rays; infinite if they do not meet."""
    corner = _settled((), flat, rays, sigma, 0.0)
    return np.inf if corner is None else corner.cost


def _starts(lost: Array) -> Iterator[tuple[Line, ...]]:
    """Lines to begin with, of every kind of chain."""
    across, along = np.quantile(lost, _QUANTILES, axis=0).T
    for kinds in _KINDS:
        if np.isnan(kinds[0]):
            # What else is lost near a chamfer hides its direction.
            middle = np.median(lost, axis=0)
            for angle in _SLANTS:
                line = Line(float(angle), 0.0)
                yield (Line(line.angle, float(middle @ line.normal)),)
            continue
        choices = [across if kind == _AXIAL else along for kind in kinds]
        for offsets in product(*choices):
            if len(offsets) < 3 or offsets[0] != offsets[2]:
                pairs = zip(kinds, offsets, strict=True)
                yield tuple(Line(kind, float(offset)) for kind, offset in pairs)


def _settled(
    lines: tuple[Line, ...],
    flat: Array,
    rays: tuple[Ray, Ray],
    sigma: float,
    min_length: float,
) -> Chain | None:
    """The chain after giving points to lines and moving lines to points until nothing changes.

    The rays are moved along, as strips of the chain may have drawn them aside.
    """
    part = np.full(len(flat), -1)
    for _ in range(_MAX_ROUNDS):
        vertices = _vertices([rays[0].line, *lines, rays[1].line])
        if vertices is None:
            return None
        distances = _distances(flat, vertices, rays)
        before, part = part, np.argmin(distances, axis=0)
        if np.array_equal(part, before):
            break
        is_close = distances.min(axis=0) < _REACH * sigma
        own = [flat[(part == index) & is_close] for index in range(len(lines) + 2)]
        if min(len(points) for points in own) < _MIN_POINTS:
            return None
        lines = tuple(
            _moved(line, points, sigma) for line, points in zip(lines, own[1:-1], strict=True)
        )
        rays = rays[0].shifted(own[0]), rays[1].shifted(own[-1])
    return _chain(rays, lines, flat, sigma, min_length)


def _polished(chain: Chain, flat: Array, sigma: float, min_length: float) -> Chain:
    """The chain of locally greatest likelihood: points near two lines count for both a little.

    Expectation maximisation (Dempster, Laird and Rubin 1977), as long as it pays.
    """
    for _ in range(_MAX_ROUNDS):
        outline = outline_between(flat, chain.vertices, chain.rays)
        density, floor = densities(flat, outline, sigma)
        share = density / (density.sum(axis=0) + floor)
        lines = tuple(
            _weighted(line, flat, weights)
            for line, weights in zip(chain.lines, share[1:-1], strict=True)
        )
        rays = tuple(
            Ray(_weighted(ray.line, flat, weights, turns=False), ray.toward)
            for ray, weights in zip(chain.rays, share[[0, -1]], strict=True)
        )
        after = _chain((rays[0], rays[1]), lines, flat, sigma, min_length)
        if after is None or after.cost >= chain.cost - _AT_REST:
            break
        chain = after
    return chain


def _is_slanted(line: Line) -> bool:
    return line.angle not in (_AXIAL, _RADIAL)


def _weighted(line: Line, flat: Array, weights: Array, turns: bool = True) -> Line:
    """The line of its kind through weighted points; its direction stays if it is a ray's."""
    middle = weights @ flat / max(float(weights.sum()), 1e-12)
    if turns and _is_slanted(line):
        local = flat - middle
        normal = np.linalg.eigh((local * weights[:, None]).T @ local)[1][:, 0]
        line = Line(float(np.arctan2(normal[1], normal[0])), 0.0)
    return Line(line.angle, float(middle @ line.normal))


def _chain(
    rays: tuple[Ray, Ray], lines: tuple[Line, ...], flat: Array, sigma: float, min_length: float
) -> Chain | None:
    """The chain with its points and cost; None if it folds or a line is too short."""
    vertices = _vertices([rays[0].line, *lines, rays[1].line])
    if vertices is None or not _is_forward(vertices, rays):
        return None
    spans = np.linalg.norm(np.diff(vertices, axis=0), axis=1)
    if spans.min(initial=np.inf) < min_length:
        return None
    cost = outline_cost(flat, outline_between(flat, vertices, rays), sigma)
    cost += price(sum(1 + _is_slanted(line) for line in lines), len(flat))
    part = np.argmin(_distances(flat, vertices, rays), axis=0)
    return Chain(rays, lines, vertices, part, cost)


def _moved(line: Line, own: Array, sigma: float) -> Line:
    """The line of its kind through its points."""
    if _is_slanted(line):
        return fit_line(own, sigma) or line
    return Line(line.angle, float(np.mean(own @ line.normal)))


def _vertices(lines: Sequence[Line]) -> Array | None:
    """Where each line meets the next; None if two are nearly parallel."""
    normals = np.array([line.normal for line in lines])
    offsets = np.array([line.offset for line in lines])
    turn = normals[:-1, 0] * normals[1:, 1] - normals[:-1, 1] * normals[1:, 0]
    if np.abs(turn).min() < np.sin(_MIN_TURN):
        return None
    x = offsets[:-1] * normals[1:, 1] - offsets[1:] * normals[:-1, 1]
    y = normals[:-1, 0] * offsets[1:] - normals[1:, 0] * offsets[:-1]
    return np.asarray(np.column_stack([x, y]) / turn[:, None])


def _is_forward(vertices: Array, rays: tuple[Ray, Ray]) -> bool:
    """Whether both rays have their own points ahead, and not the whole chain with them."""
    for ray, own, other in zip(rays, vertices[[0, -1]], vertices[[-1, 0]], strict=True):
        ahead = float((ray.toward - own) @ ray.heading)
        between = float((other - own) @ ray.heading)
        if ahead * between > 0.0 and abs(between) > abs(ahead):
            return False
    return True


def _distances(flat: Array, vertices: Array, rays: tuple[Ray, Ray]) -> Array:
    """Of points from every part of the chain, shape ``(k + 2, n)``."""
    rows = [from_ray(flat, vertices[0], rays[0])]
    for start, end in pairwise(vertices):
        span = end - start
        share = (flat - start) @ span / max(float(span @ span), 1e-12)
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * span
        rows.append(np.linalg.norm(flat - foot, axis=1))
    rows.append(from_ray(flat, vertices[-1], rays[1]))
    return np.array(rows)
