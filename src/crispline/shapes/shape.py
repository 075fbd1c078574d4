"""Shapes known exactly: trimmed analytic faces, sharp edges, corners."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crispline.surface.base import Array

N_EDGE_POINTS = 100
"""Points per edge polyline, as in the paper's measure."""

_N_QUADRATURE = 500
_N_ARC = 2001


def everywhere(u: Array, v: Array) -> NDArray[np.bool_]:
    """Trimming test of a face that fills its parameter rectangle."""
    return np.ones(np.broadcast(u, v).shape, dtype=bool)


def unstretched(u: Array, v: Array) -> Array:
    """Area element of a face whose parameters are lengths along it."""
    return np.ones(np.broadcast(u, v).shape)


@dataclass(frozen=True)
class ShapeFace:
    """One face: a parameter rectangle mapped into space and trimmed.

    Attributes
    ----------
    kind : ``plane``, ``cylinder`` or ``free-form``.
    u, v : bounds of the parameter rectangle, in the shape's length unit.
    evaluate : maps parameters, both of shape ``(n,)``, to points and outward
        unit normals, both ``(n, 3)``.
    contains : tells which parameters lie on the trimmed face.
    stretch : area element ``|S_u x S_v|``.
    is_closed_u : whether the face closes on itself in u.
    """

    kind: str
    u: tuple[float, float]
    v: tuple[float, float]
    evaluate: Callable[[Array, Array], tuple[Array, Array]]
    contains: Callable[[Array, Array], NDArray[np.bool_]] = everywhere
    stretch: Callable[[Array, Array], Array] = unstretched
    is_closed_u: bool = False

    def midpoints(self, n_u: int, n_v: int) -> tuple[Array, Array]:
        """Parameters of the centres of ``n_u x n_v`` cells, both of shape ``(n_u * n_v,)``."""
        u = self.u[0] + (np.arange(n_u) + 0.5) * ((self.u[1] - self.u[0]) / n_u)
        v = self.v[0] + (np.arange(n_v) + 0.5) * ((self.v[1] - self.v[0]) / n_v)
        grid_u, grid_v = np.meshgrid(u, v, indexing="ij")
        return grid_u.ravel(), grid_v.ravel()

    @cached_property
    def area_and_stretch(self) -> tuple[float, float]:
        """Area by the midpoint rule (relative error below 1e-4), largest area element."""
        u, v = self.midpoints(_N_QUADRATURE, _N_QUADRATURE)
        stretch = self.stretch(u, v)
        rectangle = (self.u[1] - self.u[0]) * (self.v[1] - self.v[0])
        area = rectangle * float(np.mean(stretch * self.contains(u, v)))
        return area, float(stretch.max())


@dataclass(frozen=True)
class ShapeEdge:
    """A sharp edge: ``points`` ``(N_EDGE_POINTS, 3)`` at equal arc length.

    An open edge includes both ends; a closed one does not repeat its start.
    """

    kind: str
    points: Array


@dataclass(frozen=True)
class Shape:
    """A closed shape.

    Attributes
    ----------
    name : what the command line calls it.
    length : the model's length that noise levels refer to.
    faces, edges : see `ShapeFace`, `ShapeEdge`; tangent edges are not listed.
    corners : points where three or more sharp edges meet, shape ``(c, 3)``.
    """

    name: str
    length: float
    faces: tuple[ShapeFace, ...]
    edges: tuple[ShapeEdge, ...]
    corners: Array

    @property
    def area(self) -> float:
        """Total area of the faces (relative error below 1e-4)."""
        return sum(face.area_and_stretch[0] for face in self.faces)


def edge(
    kind: str,
    curve: Callable[[Array], Array],
    start: float,
    end: float,
    *,
    is_closed: bool = False,
) -> ShapeEdge:
    """Edge along a curve, sampled at equal arc length.

    Parameters
    ----------
    kind : name of the group that accuracy is reported for.
    curve : maps parameters ``(n,)`` to exact points ``(n, 3)``.
    start, end : parameter range.
    is_closed : whether the curve returns to its start.
    """
    parameters = np.linspace(start, end, _N_ARC)
    steps = np.linalg.norm(np.diff(curve(parameters), axis=0), axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    wanted = np.linspace(0.0, length[-1], N_EDGE_POINTS, endpoint=not is_closed)
    return ShapeEdge(kind, curve(np.interp(wanted, length, parameters)))


def line(kind: str, start: Array, end: Array) -> ShapeEdge:
    """Straight edge between two points, shape ``(3,)``."""
    return edge(kind, lambda t: start + t[:, None] * (end - start), 0.0, 1.0)


def circle(kind: str, centre: Array, x_radius: Array, y_radius: Array) -> ShapeEdge:
    """Full circle ``centre + cos t x_radius + sin t y_radius`` (vectors of shape ``(3,)``)."""

    def curve(t: Array) -> Array:
        return centre + np.cos(t)[:, None] * x_radius + np.sin(t)[:, None] * y_radius

    return edge(kind, curve, 0.0, 2.0 * np.pi, is_closed=True)


def plane_face(
    origin: Array,
    x_axis: Array,
    y_axis: Array,
    u: tuple[float, float],
    v: tuple[float, float],
    contains: Callable[[Array, Array], NDArray[np.bool_]] = everywhere,
) -> ShapeFace:
    """Part of the plane ``origin + u x_axis + v y_axis``; its normal is ``x_axis x y_axis``."""
    normal = np.cross(x_axis, y_axis)

    def evaluate(u: Array, v: Array) -> tuple[Array, Array]:
        points = origin + u[:, None] * x_axis + v[:, None] * y_axis
        return points, np.broadcast_to(normal, points.shape)

    return ShapeFace("plane", u, v, evaluate, contains)


def cylinder_face(
    origin: Array,
    x_axis: Array,
    y_axis: Array,
    radius: float,
    v: tuple[float, float],
    *,
    angle: tuple[float, float] = (0.0, 2.0 * np.pi),
    is_hole: bool = False,
    contains: Callable[[Array, Array], NDArray[np.bool_]] = everywhere,
) -> ShapeFace:
    """Part of the cylinder about ``origin + v (x_axis x y_axis)``.

    ``u`` is the arc length ``radius * angle`` from ``x_axis`` towards ``y_axis``.
    The normal points to the axis if the material is outside (``is_hole``).
    """
    axis = np.cross(x_axis, y_axis)

    def evaluate(u: Array, v: Array) -> tuple[Array, Array]:
        t = (u / radius)[:, None]
        radial = np.cos(t) * x_axis + np.sin(t) * y_axis
        return origin + radius * radial + v[:, None] * axis, -radial if is_hole else radial

    bounds = (radius * angle[0], radius * angle[1])
    is_full = bool(np.isclose(angle[1] - angle[0], 2.0 * np.pi))
    return ShapeFace("cylinder", bounds, v, evaluate, contains, is_closed_u=is_full)
