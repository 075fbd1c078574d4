"""How likely points are on a surface of revolution, told by its profile alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.distance import cdist

from crispline.fit.swept import Circle, Line
from crispline.surface.base import Array

CAP = 8.0
"""What a point far from everything counts more than one on a line, in squared residuals over
2 sigma^2."""
_PIECE = 0.5  # of an outline, in sigmas
_N_ARC = 24  # spans that an arc is drawn with
_CIRCLE_PARAMETERS = 3
_OWN = 1.0  # points nearer to a line than this tell how far it goes, spacings


@dataclass(frozen=True)
class Ray:
    """A line that is known, on the side of its own points.

    Attributes
    ----------
    line : the line.
    toward : a place among its points, shape ``(2,)``.
    """

    line: Line
    toward: Array

    @property
    def heading(self) -> Array:
        """Either direction along the line, unit, shape ``(2,)``."""
        return np.array([-self.line.normal[1], self.line.normal[0]])

    def shifted(self, own: Array) -> Ray:
        """The ray moved sideways onto points ``(n, 2)``."""
        offset = float(np.mean(own @ self.line.normal))
        return Ray(Line(self.line.angle, offset), self.toward)


def outline_cost(flat: Array, outline: Array, sigma: float) -> float:
    """Minus the log likelihood of points of even density on what an outline turns to.

    Where every point counts for the nearest line only, many lines in a small place explain
    anything; here each has to share its points with its whole length.

    Parameters
    ----------
    flat : points, shape ``(n, 2)``: distance from the axis and height along it.
    outline : polyline in the same plane, shape ``(k, 2)``.
    sigma : noise, spacings. A point counts :data:`CAP` at most, relative to one on the outline.
    """
    density, floor = densities(flat, outline, sigma)
    return float(-np.log(density.sum(axis=0) + floor).sum())


def densities(flat: Array, outline: Array, sigma: float) -> tuple[Array, float]:
    """Of points ``(n, 2)`` on every span of an outline, shape ``(k - 1, n)``, and elsewhere."""
    spans = np.linalg.norm(np.diff(outline, axis=0), axis=1)
    counts = np.maximum(np.ceil(spans / (_PIECE * sigma)).astype(int), 1)
    first = np.cumsum(counts) - counts
    starts, ends = outline[:-1].repeat(counts, axis=0), outline[1:].repeat(counts, axis=0)
    rank = np.arange(counts.sum()) - first.repeat(counts)
    pieces = starts + ((rank + 0.5) / counts.repeat(counts))[:, None] * (ends - starts)
    weights = (spans / counts).repeat(counts) * np.abs(pieces[:, 0])
    squared = cdist(pieces, flat, "sqeuclidean") / sigma**2
    kernel = np.exp(-0.5 * squared) * (weights / (np.sqrt(2.0 * np.pi) * sigma))[:, None]
    total = max(float(weights.sum()), 1e-12)
    floor = np.exp(-CAP) * float(np.median(np.abs(flat[:, 0]))) / total
    return np.add.reduceat(kernel, first, axis=0) / total, floor


def round_cost(flat: Array, circle: Circle, rays: tuple[Ray, Ray], sigma: float) -> float:
    """The cost of points if an arc of a circle leads from one ray to the other."""
    ends = []
    for ray in rays:
        away = float(circle.centre @ ray.line.normal) - ray.line.offset
        foot = circle.centre - away * ray.line.normal
        half = float(np.sqrt(max(circle.radius**2 - away**2, 0.0)))
        side = 1.0 if (ray.toward - foot) @ ray.heading >= 0.0 else -1.0
        ends.append(foot + side * half * ray.heading)
    start, end = (np.arctan2(*(place - circle.centre)[::-1]) for place in ends)
    turn = (end - start) % (2.0 * np.pi)
    costs = []
    for sweep in (turn, turn - 2.0 * np.pi):
        angle = start + np.linspace(0.0, sweep, _N_ARC)
        arc = circle.centre + circle.radius * np.column_stack([np.cos(angle), np.sin(angle)])
        arc[[0, -1]] = ends
        costs.append(outline_cost(flat, outline_between(flat, arc, rays), sigma))
    return min(costs) + price(_CIRCLE_PARAMETERS, len(flat))


def price(n_parameters: int, n_points: int) -> float:
    """Description length of parameters (Schwarz 1978)."""
    return 0.5 * n_parameters * float(np.log(n_points))


def outline_between(flat: Array, vertices: Array, rays: tuple[Ray, Ray]) -> Array:
    """The vertices between the far ends of the rays, as far as there are points."""
    return np.vstack(
        [_far_end(flat, vertices[0], rays[0]), vertices, _far_end(flat, vertices[-1], rays[1])]
    )


def _far_end(flat: Array, start: Array, ray: Ray) -> Array:
    heading = ray.heading * (1.0 if (ray.toward - start) @ ray.heading >= 0.0 else -1.0)
    is_own = np.abs(flat @ ray.line.normal - ray.line.offset) < _OWN
    ahead = (flat[is_own] - start) @ heading
    return np.asarray(start + max(float(ahead.max(initial=0.0)), 0.0) * heading)


def from_ray(flat: Array, start: Array, ray: Ray) -> Array:
    """Distances of points ``(n, 2)`` from the part of a ray's line that begins at ``start``."""
    heading = ray.heading * (1.0 if (ray.toward - start) @ ray.heading >= 0.0 else -1.0)
    offset = flat - start
    ahead = np.maximum(offset @ heading, 0.0)
    return np.asarray(np.linalg.norm(offset - ahead[:, None] * heading, axis=1))
