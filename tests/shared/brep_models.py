"""Analytic models with their exact volume, in a unit where the point spacing is 1."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.integrate import quad
from scipy.interpolate import CubicSpline, NdBSpline, make_interp_spline, make_lsq_spline

from crispline.curve import BSplineCurve, Circle, Curve, Line
from crispline.model import Edge, Face, Model
from crispline.surface import (
    BSplineSurface,
    Cone,
    Cylinder,
    Plane,
    Profile,
    RevolvedSurface,
    Sphere,
    Surface,
    Torus,
    perpendicular_frame,
    unit,
)
from crispline.surface.basis import uniform_knots

X, Y, Z = np.eye(3)
TURN = 2 * np.pi
NO_POINTS = np.empty((0, 3))


@dataclass
class Draft:
    """A model in the making: the sides of the edges follow from the loops of the faces."""

    vertices: list[np.ndarray] = field(default_factory=list)
    edges: list[tuple[Curve, int, int]] = field(default_factory=list)
    faces: list[tuple[Surface, int, list[list[tuple[int, int]]]]] = field(default_factory=list)

    def vertex(self, *position: float) -> int:
        self.vertices.append(np.array(position, dtype=float))
        return len(self.vertices) - 1

    def edge(self, curve: Curve, start: int, end: int) -> int:
        self.edges.append((curve, start, end))
        return len(self.edges) - 1

    def line(self, start: int, end: int) -> int:
        a, b = self.vertices[start], self.vertices[end]
        return self.edge(Line(a, unit(b - a), 0.0, float(np.linalg.norm(b - a))), start, end)

    def circle(self, centre, normal, radius, x_axis=None) -> int:
        """A full circle, anticlockwise about its normal, with a vertex of its own."""
        centre, normal = np.asarray(centre, float), np.asarray(normal, float)
        x_axis = perpendicular_frame(normal)[0] if x_axis is None else unit(np.array(x_axis, float))
        vertex = self.vertex(*(centre + radius * x_axis))
        return self.edge(Circle(centre, normal, x_axis, radius, 0.0, TURN), vertex, vertex)

    def arc(self, centre, normal, start: int, end: int) -> int:
        """An arc anticlockwise about its normal between two vertices."""
        centre, normal = np.asarray(centre, float), np.asarray(normal, float)
        a, b = self.vertices[start] - centre, self.vertices[end] - centre
        x_axis = unit(a)
        angle = np.arctan2(b @ np.cross(normal, x_axis), b @ x_axis) % TURN
        radius = float(np.linalg.norm(a))
        return self.edge(Circle(centre, normal, x_axis, radius, 0.0, float(angle)), start, end)

    def face(self, surface: Surface, orientation: int, *loops: Sequence[tuple[int, int]]) -> int:
        self.faces.append((surface, orientation, [list(loop) for loop in loops]))
        return len(self.faces) - 1

    def polygon(self, *corner_loops: Sequence[int], edges: dict, extra=()) -> int:
        """A planar face through vertices, anticlockwise seen from outside."""
        loops = []
        for corners in corner_loops:
            loop = []
            for a, b in zip(corners, [*corners[1:], corners[0]], strict=True):
                if (b, a) in edges:
                    loop.append((edges[b, a], -1))
                else:
                    if (a, b) not in edges:
                        edges[a, b] = self.line(a, b)
                    loop.append((edges[a, b], 1))
            loops.append(loop)
        outer = np.array([self.vertices[i] for i in corner_loops[0]])
        area = np.cross(outer, np.roll(outer, -1, axis=0)).sum(axis=0)
        return self.face(Plane(outer[0], unit(area)), 1, *loops, *extra)

    def model(self) -> Model:
        sides = [[-1, -1] for _ in self.edges]
        for index, (_, _, loops) in enumerate(self.faces):
            for loop in loops:
                for edge, sign in loop:
                    sides[edge][sign < 0] = index
        edges = tuple(
            Edge(curve, start, end, *side, 0.0, np.pi / 2, True)
            for (curve, start, end), side in zip(self.edges, sides, strict=True)
        )
        faces = tuple(
            Face(surface, sign, tuple(map(tuple, loops)), NO_POINTS, np.empty(0), index)
            for index, (surface, sign, loops) in enumerate(self.faces)
        )
        vertices = np.array(self.vertices).reshape(-1, 3)
        return Model(vertices, np.zeros(len(vertices)), edges, faces)


@dataclass(frozen=True)
class Sample:
    model: Model
    volume: float
    n_solids: int = 1


def prism(draft: Draft, outline, low: float, high: float, top=(), bottom=(), is_void=False) -> None:
    """A vertical prism over an anticlockwise outline; ``top``, ``bottom`` are more loops."""
    edges: dict = {}
    n = len(outline)
    floor = [draft.vertex(x, y, low) for x, y in outline]
    roof = [draft.vertex(x, y, high) for x, y in outline]

    def add(*corners, extra=()):
        draft.polygon(corners[::-1] if is_void else corners, edges=edges, extra=extra)

    add(*floor[::-1], extra=bottom)
    add(*roof, extra=top)
    for i in range(n):
        j = (i + 1) % n
        add(floor[i], floor[j], roof[j], roof[i])


def rectangle(w: float, d: float, x: float = 0.0, y: float = 0.0):
    return [(x, y), (x + w, y), (x + w, y + d), (x, y + d)]


def box() -> Sample:
    draft = Draft()
    prism(draft, rectangle(60, 40), 0, 30)
    return Sample(draft.model(), 60 * 40 * 30)


def l_shape() -> Sample:
    draft = Draft()
    prism(draft, [(0, 0), (60, 0), (60, 20), (25, 20), (25, 50), (0, 50)], 0, 15)
    return Sample(draft.model(), (60 * 20 + 25 * 30) * 15)


def two_boxes() -> Sample:
    draft = Draft()
    prism(draft, rectangle(20, 20), 0, 20)
    prism(draft, rectangle(10, 20, x=50), 0, 20)
    return Sample(draft.model(), 20**3 + 10 * 400, n_solids=2)


def box_with_void() -> Sample:
    draft = Draft()
    prism(draft, rectangle(60, 40), 0, 30)
    prism(draft, rectangle(20, 10, x=10, y=10), 10, 20, is_void=True)
    return Sample(draft.model(), 60 * 40 * 30 - 20 * 10 * 10)


def matryoshka() -> Sample:
    """A box in the void of a box."""
    draft = Draft()
    prism(draft, rectangle(60, 60), 0, 60)
    prism(draft, rectangle(40, 40, x=10, y=10), 10, 50, is_void=True)
    prism(draft, rectangle(20, 20, x=20, y=20), 20, 40)
    return Sample(draft.model(), 60**3 - 40**3 + 20**3, n_solids=2)


def open_box() -> Sample:
    closed = box().model
    edges = tuple(
        replace(e, left=-1 if e.left == 5 else e.left, right=-1 if e.right == 5 else e.right)
        for e in closed.edges
    )
    return Sample(replace(closed, edges=edges, faces=closed.faces[:5]), 0.0, n_solids=0)


def box_cylinder() -> Sample:
    """The paper's model: a cylinder on a box."""
    draft = Draft()
    low = draft.circle((30, 20, 30), Z, 12)
    high = draft.circle((30, 20, 50), Z, 12, x_axis=(1, 2, 0))
    prism(draft, rectangle(60, 40), 0, 30, top=[[(low, -1)]])
    draft.face(Cylinder(np.array([30.0, 20, 0]), Z, 12.0), 1, [(low, 1)], [(high, -1)])
    draft.face(Plane(np.array([30.0, 20, 50]), Z), 1, [(high, 1)])
    return Sample(draft.model(), 60 * 40 * 30 + np.pi * 144 * 20)


def bored_block() -> Sample:
    draft = Draft()
    low = draft.circle((30, 20, 0), Z, 8)
    high = draft.circle((30, 20, 30), Z, 8, x_axis=(-1, 1, 0))
    prism(draft, rectangle(60, 40), 0, 30, top=[[(high, -1)]], bottom=[[(low, 1)]])
    draft.face(Cylinder(np.array([30.0, 20, 0]), -Z, 8.0), -1, [(low, -1)], [(high, 1)])
    return Sample(draft.model(), 60 * 40 * 30 - np.pi * 64 * 30)


def conical_hole() -> Sample:
    draft = Draft()
    rim = draft.circle((30, 20, 30), Z, 10)
    prism(draft, rectangle(60, 40), 0, 30, top=[[(rim, -1)]])
    draft.face(Cone(np.array([30.0, 20, 10]), Z, np.arctan(0.5)), -1, [(rim, 1)])
    return Sample(draft.model(), 60 * 40 * 30 - np.pi * 100 * 20 / 3)


def frustum() -> Sample:
    draft = Draft()
    low = draft.circle((0, 0, 0), Z, 20)
    high = draft.circle((0, 0, 20), Z, 10, x_axis=(0, 1, 0))
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Cone(np.array([0, 0, 40.0]), -Z, np.arctan(0.5)), 1, [(low, 1)], [(high, -1)])
    draft.face(Plane(np.array([0, 0, 20.0]), Z), 1, [(high, 1)])
    return Sample(draft.model(), np.pi * 20 / 3 * (400 + 200 + 100))


def cone_sector() -> Sample:
    """Half a cone: the apex is a corner."""
    draft = Draft()
    a, b, apex = draft.vertex(10, 0, 0), draft.vertex(-10, 0, 0), draft.vertex(0, 0, 20)
    rim = draft.arc((0, 0, 0), Z, a, b)
    base, left, right = draft.line(b, a), draft.line(b, apex), draft.line(a, apex)
    draft.face(Plane(np.zeros(3), -Z), 1, [(rim, -1), (base, -1)])
    draft.face(Plane(np.zeros(3), -Y), 1, [(base, 1), (right, 1), (left, -1)])
    cone = Cone(np.array([0, 0, 20.0]), -Z, np.arctan(0.5))
    draft.face(cone, 1, [(rim, 1), (left, 1), (right, -1)])
    return Sample(draft.model(), np.pi * 100 * 20 / 6)


def fillet() -> Sample:
    """A box with one rounded edge: the cylinder is tangent to both planes."""
    draft = Draft()
    outline = [(0, 0), (60, 0), (60, 30), (50, 40), (0, 40)]
    floor = [draft.vertex(x, y, 0) for x, y in outline]
    roof = [draft.vertex(x, y, 30) for x, y in outline]
    edges: dict = {
        (floor[2], floor[3]): draft.arc((50, 30, 0), Z, floor[2], floor[3]),
        (roof[2], roof[3]): draft.arc((50, 30, 30), Z, roof[2], roof[3]),
    }
    draft.polygon(floor[::-1], edges=edges)
    draft.polygon(roof, edges=edges)
    for i in (0, 1, 3, 4):
        j = (i + 1) % 5
        draft.polygon([floor[i], floor[j], roof[j], roof[i]], edges=edges)
    loop = [
        (edges[floor[2], floor[3]], 1),
        _use(edges, floor[3], roof[3]),
        (edges[roof[2], roof[3]], -1),
        _use(edges, roof[2], floor[2]),
    ]
    draft.face(Cylinder(np.array([50.0, 30, 0]), Z, 10.0), 1, loop)
    return Sample(draft.model(), (60 * 40 - 100 * (1 - np.pi / 4)) * 30)


def _use(edges: dict, a: int, b: int) -> tuple[int, int]:
    return (edges[a, b], 1) if (a, b) in edges else (edges[b, a], -1)


def sphere_capped_box() -> Sample:
    """A cap lower than a hemisphere."""
    draft = Draft()
    rim = draft.circle((30, 20, 30), Z, 12)
    prism(draft, rectangle(60, 40), 0, 30, top=[[(rim, -1)]])
    draft.face(Sphere(np.array([30.0, 20, 25]), 13.0), 1, [(rim, 1)])
    h = 8.0
    return Sample(draft.model(), 60 * 40 * 30 + np.pi * h * h * (3 * 13 - h) / 3)


def sphere_topped_cylinder() -> Sample:
    draft = Draft()
    low = draft.circle((0, 0, 0), Z, 12)
    high = draft.circle((0, 0, 20), Z, 12, x_axis=(1, 1, 0))
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Cylinder(np.zeros(3), Z, 12.0), 1, [(low, 1)], [(high, -1)])
    draft.face(Sphere(np.array([0, 0, 20.0]), 12.0), 1, [(high, 1)])
    return Sample(draft.model(), np.pi * 144 * 20 + 2 / 3 * np.pi * 12**3)


def ball_on_stick() -> Sample:
    """More than a hemisphere, on a cylinder."""
    draft = Draft()
    low, high = draft.circle((0, 0, 0), Z, 5), draft.circle((0, 0, 20), Z, 5)
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Cylinder(np.zeros(3), Z, 5.0), 1, [(low, 1)], [(high, -1)])
    draft.face(Sphere(np.array([0, 0, 32.0]), 13.0), 1, [(high, 1)])
    h = 13.0 + 12.0
    return Sample(draft.model(), np.pi * 25 * 20 + np.pi * h * h * (39 - h) / 3)


def rounded_box() -> Sample:
    """All edges and corners rounded: quarter cylinders and octants of spheres."""
    w, d, h, r = 40.0, 30.0, 20.0, 5.0
    draft = Draft()
    size = np.array([w, d, h])
    corner: dict = {}  # (octant, axis): vertex where the octant meets the plane across the axis
    for octant in np.ndindex(2, 2, 2):
        sign = 2 * np.array(octant) - 1
        centre = sign * (size / 2 - r)
        for axis in range(3):
            corner[octant, axis] = draft.vertex(*(centre + r * sign[axis] * np.eye(3)[axis]))
    lines: dict = {}  # (axis of the line, the octant at its low end, the plane's axis)
    arcs: dict = {}
    for octant in np.ndindex(2, 2, 2):
        sign = 2 * np.array(octant) - 1
        for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            normal = np.eye(3)[k] * (1 if sign[i] * sign[j] > 0 else -1)
            centre = sign * (size / 2 - r)
            a, b = corner[octant, i], corner[octant, j]
            arcs[octant, k] = (draft.arc(centre, normal, a, b), a, b)
            if octant[k] == 0:
                other = tuple(1 if m == k else octant[m] for m in range(3))
                for p in (i, j):
                    lines[k, octant, p] = (
                        draft.line(corner[octant, p], corner[other, p]),
                        corner[octant, p],
                        corner[other, p],
                    )
    every = [*lines.values(), *arcs.values()]

    def loop(vertices):
        found = []
        for a, b in zip(vertices, [*vertices[1:], vertices[0]], strict=True):
            found.append(
                next((e, 1) if (a, b) == (p, q) else (e, -1)
                     for e, p, q in every if {a, b} == {p, q})
            )  # fmt: skip
        return found

    def outward(vertices, normal):
        p = np.array([draft.vertices[v] for v in vertices])
        middle = p.mean(axis=0)
        turn = np.cross(p - middle, np.roll(p, -1, axis=0) - middle).sum(axis=0) @ normal
        return vertices if turn > 0 else vertices[::-1]

    for octant in np.ndindex(2, 2, 2):
        sign = 2 * np.array(octant) - 1
        ring = outward([corner[octant, m] for m in range(3)], sign)
        draft.face(Sphere(sign * (size / 2 - r), r), 1, loop(ring))
    for k, octant in {(k, octant) for k, octant, _ in lines}:
        i, j = (k + 1) % 3, (k + 2) % 3
        other = tuple(1 if m == k else octant[m] for m in range(3))
        sign = 2 * np.array(octant) - 1
        normal = sign * (1 - np.eye(3)[k])
        ring = [corner[octant, i], corner[octant, j], corner[other, j], corner[other, i]]
        draft.face(Cylinder(sign * (size / 2 - r), np.eye(3)[k], r), 1, loop(outward(ring, normal)))
    for axis in range(3):
        for side in (0, 1):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            ring = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                octant = [0, 0, 0]
                octant[axis], octant[i], octant[j] = side, a, b
                ring.append(corner[tuple(octant), axis])
            normal = (2 * side - 1) * np.eye(3)[axis]
            draft.face(Plane(draft.vertices[ring[0]], normal), 1, loop(outward(ring, normal)))
    a, b, c = size - 2 * r
    volume = (
        a * b * c + 2 * r * (a * b + b * c + c * a)
        + np.pi * r * r * (a + b + c) + 4 / 3 * np.pi * r**3
    )  # fmt: skip
    return Sample(draft.model(), volume)


def stepped_shaft() -> Sample:
    """Coaxial cylinder, cone, cylinder that share rims."""
    draft = Draft()
    turns = [(1, 0, 0), (0, 1, 0), (1, -3, 0), (-1, 0, 0)]
    rims = [
        draft.circle((0, 0, z), Z, r, x_axis=x)
        for z, r, x in zip((0, 20, 30, 50), (10, 10, 20, 20), turns, strict=True)
    ]
    draft.face(Plane(np.zeros(3), -Z), 1, [(rims[0], -1)])
    draft.face(Cylinder(np.zeros(3), Z, 10.0), 1, [(rims[0], 1)], [(rims[1], -1)])
    cone = Cone(np.array([0, 0, 10.0]), Z, np.pi / 4)
    draft.face(cone, 1, [(rims[1], 1)], [(rims[2], -1)])
    draft.face(Cylinder(np.zeros(3), Z, 20.0), 1, [(rims[2], 1)], [(rims[3], -1)])
    draft.face(Plane(np.array([0, 0, 50.0]), Z), 1, [(rims[3], 1)])
    return Sample(draft.model(), np.pi * (2000 + 10 / 3 * 700 + 8000))


def vase_profile() -> Profile:
    """Radii 4 to 7 over heights -2 to 18, which are the parameter."""
    knots = uniform_knots(-2.0, 18.0, 4)
    heights = np.array([knots[i + 1 : i + 4].mean() for i in range(len(knots) - 4)])
    return Profile(knots, np.column_stack([[5.0, 4, 7, 6, 5, 4, 5], heights]))


def _vase_volume(profile: Profile, height: float) -> float:
    """Of the whole turn between 0 and a height."""

    def section(z: float) -> float:
        return float(np.pi * profile.derivatives(np.array([z]), 0)[0, 0, 0] ** 2)

    inner = np.unique(profile.knots)
    breaks = [0.0, *inner[(inner > 0.0) & (inner < height)], height]
    return sum(quad(section, low, high)[0] for low, high in pairwise(breaks))


def vase() -> Sample:
    """A spline turned about an axis, between two planes and beside a coaxial cylinder."""
    profile = vase_profile()
    low, high = profile.derivatives(np.array([0.0, 15.0]), 0)[0, :, 0]
    draft = Draft()
    foot = draft.circle((0, 0, 0), Z, low, x_axis=(0, 1, 0))
    neck = draft.circle((0, 0, 15), Z, high, x_axis=(1, 1, 0))
    rim = draft.circle((0, 0, 20), Z, high)
    body = RevolvedSurface(np.zeros(3), Z, profile)
    draft.face(Plane(np.zeros(3), -Z), 1, [(foot, -1)])
    draft.face(body, 1, [(foot, 1)], [(neck, -1)])
    draft.face(Cylinder(np.zeros(3), Z, float(high)), 1, [(neck, 1)], [(rim, -1)])
    draft.face(Plane(np.array([0, 0, 20.0]), Z), 1, [(rim, 1)])
    return Sample(draft.model(), _vase_volume(profile, 15.0) + 5.0 * np.pi * high**2)


def half_vase() -> Sample:
    """One half of a turned spline; its profile runs down the axis, so that it faces inwards."""
    profile = vase_profile()
    low, high = profile.derivatives(np.array([0.0, 15.0]), 0)[0, :, 0]
    draft = Draft()
    a, b = draft.vertex(low, 0, 0), draft.vertex(-low, 0, 0)
    c, d = draft.vertex(high, 0, 15), draft.vertex(-high, 0, 15)
    foot, top = draft.arc((0, 0, 0), Z, a, b), draft.arc((0, 0, 15), Z, c, d)
    piece = profile.between(0.0, 15.0)
    radius, height = piece.control_points.T
    sides = [
        draft.edge(
            BSplineCurve(piece.knots, np.column_stack([side * radius, 0.0 * radius, height])), *ends
        )
        for side, ends in ((1.0, (a, c)), (-1.0, (b, d)))
    ]
    below, above = draft.line(b, a), draft.line(d, c)
    body = RevolvedSurface(np.zeros(3), Z, profile.reversed())
    draft.face(body, -1, [(foot, 1), (sides[1], 1), (top, -1), (sides[0], -1)])
    draft.face(Plane(np.zeros(3), -Z), 1, [(foot, -1), (below, -1)])
    draft.face(Plane(np.array([0, 0, 15.0]), Z), 1, [(top, 1), (above, 1)])
    draft.face(Plane(np.zeros(3), -Y), 1, [(below, 1), (sides[0], 1), (above, -1), (sides[1], -1)])
    return Sample(draft.model(), 0.5 * _vase_volume(profile, 15.0))


def closed_spline(points) -> BSplineCurve:
    """A clamped cubic through points, smooth where it closes; the last repeats the first."""
    t = np.linspace(0.0, 1.0, len(points))
    periodic = CubicSpline(t, points, bc_type="periodic")
    knots = np.concatenate([np.zeros(3), t, np.ones(3)])
    grid = np.linspace(0.0, 1.0, 8 * len(points))
    return BSplineCurve(knots, np.asarray(make_lsq_spline(grid, periodic(grid), knots, 3).c))


def slanted_cylinder() -> Sample:
    """A cylinder cut by a slanted plane: one rim is an ellipse, as a spline."""
    draft = Draft()
    low = draft.circle((0, 0, 0), Z, 10, x_axis=(0, -1, 0))
    angle = np.linspace(0, TURN, 65) + 1.0
    ring = 10 * np.column_stack([np.cos(angle), np.sin(angle), 3 + 0.5 * np.cos(angle)])
    spline = closed_spline(ring)
    vertex = draft.vertex(*spline.control_points[0])
    high = draft.edge(spline, vertex, vertex)
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Cylinder(np.zeros(3), Z, 10.0), 1, [(low, 1)], [(high, -1)])
    draft.face(Plane(np.array([0, 0, 30.0]), unit(np.array([-0.5, 0, 1]))), 1, [(high, 1)])
    return Sample(draft.model(), np.pi * 100 * 30)


def notched_cylinder() -> Sample:
    """A step cut into the top: corners on the upper rim, none on the lower."""
    draft = Draft()
    low = draft.circle((0, 0, 0), Z, 10, x_axis=(1, 1, 0))
    y = 6.0
    x = 8.0
    corners = [(x, y), (-x, y)]
    lower = [draft.vertex(*c, 20) for c in corners]
    upper = [draft.vertex(*c, 30) for c in corners]
    small = draft.arc((0, 0, 20), Z, lower[0], lower[1])
    big = draft.arc((0, 0, 30), Z, upper[1], upper[0])
    chord, edge = draft.line(lower[0], lower[1]), draft.line(upper[0], upper[1])
    right, left = draft.line(lower[0], upper[0]), draft.line(lower[1], upper[1])
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    rim = [(small, -1), (right, 1), (big, -1), (left, -1)]
    draft.face(Cylinder(np.zeros(3), Z, 10.0), 1, [(low, 1)], rim)
    draft.face(Plane(np.array([0, 0, 20.0]), Z), 1, [(small, 1), (chord, -1)])
    draft.face(Plane(np.array([0, 0, 30.0]), Z), 1, [(big, 1), (edge, 1)])
    draft.face(Plane(np.array([0, y, 0]), Y), 1, [(chord, 1), (left, 1), (edge, -1), (right, -1)])
    segment = 100 * np.arccos(0.6) - y * x
    return Sample(draft.model(), np.pi * 100 * 20 + (np.pi * 100 - segment) * 10)


def cross_bored_cylinder(n_bores: int = 1) -> Sample:
    """A cylinder with radial through bores at right angles; their rims lie in its wall."""
    big, small, height = 20.0, 6.0, 30.0
    draft = Draft()
    low, high = draft.circle((0, 0, 0), Z, big), draft.circle((0, 0, 80), Z, big)
    holes = []
    for i in range(n_bores):
        axis = (X, Y)[i]
        side = np.cross(Z, axis)
        centre = np.array([0, 0, height * (1 + 0.8 * i)])
        rims = []
        for sign in (1, -1):
            t = np.linspace(0, TURN, 97) + 0.3
            across = small * np.cos(t)
            ring = (
                centre + sign * np.sqrt(big**2 - across**2)[:, None] * axis
                + across[:, None] * side + small * np.sin(t)[:, None] * Z
            )  # fmt: skip
            spline = closed_spline(ring)
            vertex = draft.vertex(*spline.control_points[0])
            rims.append(draft.edge(spline, vertex, vertex))
        # Both run anticlockwise about the bore's axis.
        holes += [[(rims[0], -1)], [(rims[1], 1)]]
        draft.face(Cylinder(centre, axis, small), -1, [(rims[0], 1)], [(rims[1], -1)])
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Plane(np.array([0, 0, 80.0]), Z), 1, [(high, 1)])
    draft.face(Cylinder(np.zeros(3), Z, big), 1, [(low, 1)], [(high, -1)], *holes)
    bore = quad(lambda y: 4 * np.sqrt(big**2 - y * y) * np.sqrt(small**2 - y * y), -small, small)[0]
    return Sample(draft.model(), np.pi * big**2 * 80 - n_bores * bore)


def perforated_ring() -> Sample:
    """A tube wall with so many holes, overlapping in angle, that every seam must cross one."""
    return cross_bored_rows(rows=3, per_row=4)


def cross_bored_rows(rows: int, per_row: int) -> Sample:
    big, small = 20.0, 7.0
    draft = Draft()
    height = 18.0 * rows + 4
    low, high = draft.circle((0, 0, 0), Z, big), draft.circle((0, 0, height), Z, big)
    holes = []
    for row in range(rows):
        for i in range(per_row):
            angle = TURN * (i + row / rows) / per_row
            axis = np.array([np.cos(angle), np.sin(angle), 0])
            side = np.cross(Z, axis)
            centre = np.array([0, 0, 11.0 + 18.0 * row])
            t = np.linspace(0, TURN, 97)
            across = small * np.cos(t)
            outer = (
                centre + np.sqrt(big**2 - across**2)[:, None] * axis
                + across[:, None] * side + small * np.sin(t)[:, None] * Z
            )  # fmt: skip
            spline = closed_spline(outer)
            vertex = draft.vertex(*spline.control_points[0])
            rim = draft.edge(spline, vertex, vertex)
            depth = 10.0
            floor = draft.circle(centre + depth * axis, axis, small)
            holes.append([(rim, -1)])
            draft.face(Cylinder(centre, axis, small), -1, [(rim, 1)], [(floor, -1)])
            draft.face(Plane(centre + depth * axis, axis), 1, [(floor, 1)])
    draft.face(Plane(np.zeros(3), -Z), 1, [(low, -1)])
    draft.face(Plane(np.array([0, 0, height]), Z), 1, [(high, 1)])
    draft.face(Cylinder(np.zeros(3), Z, big), 1, [(low, 1)], [(high, -1)], *holes)
    bore = quad(
        lambda y: (np.sqrt(big**2 - y * y) - 10.0) * 2 * np.sqrt(small**2 - y * y), -small, small
    )[0]
    return Sample(draft.model(), np.pi * big**2 * height - rows * per_row * bore)


def whole_sphere() -> Sample:
    draft = Draft()
    draft.face(Sphere(np.array([5.0, 6, 7]), 20.0), 1)
    return Sample(draft.model(), 4 / 3 * np.pi * 20**3)


def whole_torus() -> Sample:
    draft = Draft()
    draft.face(Torus(np.array([5.0, 6, 7]), unit(np.array([1.0, 2, 3])), 20.0, 6.0), 1)
    return Sample(draft.model(), 2 * np.pi**2 * 20 * 36)


def pipe_elbow() -> Sample:
    """A quarter of a torus between two discs: its loops wind the short way."""
    draft = Draft()
    start = draft.circle((20, 0, 0), Y, 6, x_axis=(1, 0, 1))
    end = draft.circle((0, 20, 0), X, 6, x_axis=(0, 0, 1))
    draft.face(Plane(np.array([20.0, 0, 0]), -Y), 1, [(start, -1)])
    draft.face(Torus(np.zeros(3), Z, 20.0, 6.0), 1, [(start, 1)], [(end, 1)])
    draft.face(Plane(np.array([0, 20.0, 0]), -X), 1, [(end, -1)])
    return Sample(draft.model(), np.pi**2 / 2 * 20 * 36)


def rounded_disc() -> Sample:
    """The outer half of a torus between two planes: its loops wind the long way."""
    draft = Draft()
    low, high = draft.circle((0, 0, -5), Z, 20), draft.circle((0, 0, 5), Z, 20, x_axis=(1, 1, 0))
    draft.face(Plane(np.array([0, 0, -5.0]), -Z), 1, [(low, -1)])
    draft.face(Torus(np.zeros(3), Z, 20.0, 5.0), 1, [(low, 1)], [(high, -1)])
    draft.face(Plane(np.array([0, 0, 5.0]), Z), 1, [(high, 1)])
    return Sample(draft.model(), np.pi * 400 * 10 + np.pi**2 * 25 * 20 + 4 / 3 * np.pi * 125)


def half_elbow() -> Sample:
    """The outer upper quarter of the tube of an elbow: a torus patch that winds nowhere."""
    draft = Draft()
    a0, a1 = draft.vertex(26, 0, 0), draft.vertex(20, 0, 6)
    b0, b1 = draft.vertex(0, 26, 0), draft.vertex(0, 20, 6)
    o0, o1 = draft.vertex(20, 0, 0), draft.vertex(0, 20, 0)
    outer, top, inner = (
        draft.arc((0, 0, 0), Z, a0, b0),
        draft.arc((0, 0, 6), Z, a1, b1),
        draft.arc((0, 0, 0), Z, o0, o1),
    )
    start, end = draft.arc((20, 0, 0), -Y, a0, a1), draft.arc((0, 20, 0), X, b0, b1)
    edges: dict = {}
    for p, q in ((o0, a0), (o0, a1), (o1, b0), (o1, b1)):
        edges[p, q] = draft.line(p, q)
    draft.face(Torus(np.zeros(3), Z, 20.0, 6.0), 1, [(outer, 1), (end, 1), (top, -1), (start, -1)])
    draft.face(
        Plane(np.zeros(3), -Z),
        1,
        [(edges[o0, a0], -1), (inner, 1), (edges[o1, b0], 1), (outer, -1)],
    )
    draft.face(
        Cylinder(np.zeros(3), Z, 20.0),
        -1,
        [(inner, -1), (edges[o0, a1], 1), (top, 1), (edges[o1, b1], -1)],
    )
    draft.face(Plane(np.zeros(3), -Y), 1, [(edges[o0, a0], 1), (start, 1), (edges[o0, a1], -1)])
    draft.face(Plane(np.zeros(3), -X), 1, [(edges[o1, b1], 1), (end, -1), (edges[o1, b0], -1)])
    quarter = np.pi * 36 / 4
    centroid = 20 + 4 * 6 / (3 * np.pi)
    return Sample(draft.model(), np.pi / 2 * centroid * quarter)


def pierced_torus() -> Sample:
    """A torus with a flat on its outside: one loop, and both seams in the face."""
    draft = Draft()
    major, minor, cut = 20.0, 6.0, 24.0
    # Section of the torus by x = cut: a closed quartic round (cut, 0, 0).
    limit = np.arccos((cut - major) / minor)
    v = limit * np.sin(np.linspace(0, TURN, 161))
    sign = np.sign(np.cos(np.linspace(0, TURN, 161)))
    ring_radius = major + minor * np.cos(v)
    y = sign * np.sqrt(np.maximum(ring_radius**2 - cut**2, 0.0))
    angle = np.arctan2(minor * np.sin(v), y)
    order = np.argsort(angle[:-1], kind="stable")
    ring = np.column_stack([np.full(161, cut), y, minor * np.sin(v)])[order]
    ring = ring[np.r_[True, np.linalg.norm(np.diff(ring, axis=0), axis=1) > 1e-6]]
    spline = closed_spline(np.vstack([ring, ring[:1]]))
    vertex = draft.vertex(*spline.control_points[0])
    rim = draft.edge(spline, vertex, vertex)
    draft.face(Torus(np.zeros(3), Z, major, minor), 1, [(rim, -1)])
    draft.face(Plane(np.array([cut, 0, 0]), X), 1, [(rim, 1)])

    def section(x: float) -> float:
        def width(z: float) -> float:
            outer = major + np.sqrt(max(minor**2 - z * z, 0.0))
            return 2 * np.sqrt(max(outer**2 - x * x, 0.0))

        top = np.sqrt(max(minor**2 - (x - major) ** 2, 0.0))
        return quad(width, -top, top)[0]

    lost = quad(section, cut, major + minor)[0]
    return Sample(draft.model(), 2 * np.pi**2 * major * minor**2 - lost)


def spline_top() -> Sample:
    """A block under a wavy B-spline face; its borders are the face's own rows, resampled."""
    w, d = 60.0, 40.0
    knots_u = np.concatenate([np.zeros(3), np.linspace(0, 1, 8), np.ones(3)])
    knots_v = np.concatenate([np.zeros(3), np.linspace(0, 1, 6), np.ones(3)])
    margin = 0.12

    def greville(knots):
        return np.array([knots[i + 1 : i + 4].mean() for i in range(len(knots) - 4)])

    gu = (greville(knots_u) * (1 + 2 * margin) - margin) * w
    gv = (greville(knots_v) * (1 + 2 * margin) - margin) * d
    xx, yy = np.meshgrid(gu, gv, indexing="ij")
    zz = 30 + 3 * np.sin(xx / 9) * np.cos(yy / 7)
    surface = BSplineSurface(knots_u, knots_v, np.stack([xx, yy, zz], axis=-1))
    heights = NdBSpline((knots_u, knots_v), surface.control_points[:, :, 2], 3)

    def to_uv(x, y):
        return np.column_stack([(np.asarray(x) / w + margin), (np.asarray(y) / d + margin)]) / (
            1 + 2 * margin
        )

    draft = Draft()
    outline = rectangle(w, d)
    floor = [draft.vertex(x, y, 0) for x, y in outline]
    roof = [draft.vertex(x, y, float(heights(to_uv([x], [y]))[0])) for x, y in outline]
    edges: dict = {}
    for i in range(4):
        j = (i + 1) % 4
        t = np.linspace(0, 1, 60)
        x = outline[i][0] + t * (outline[j][0] - outline[i][0])
        y = outline[i][1] + t * (outline[j][1] - outline[i][1])
        spline = make_interp_spline(t, np.column_stack([x, y, heights(to_uv(x, y))]), k=3)
        curve = BSplineCurve(np.asarray(spline.t), np.asarray(spline.c))
        edges[roof[i], roof[j]] = draft.edge(curve, roof[i], roof[j])
    draft.polygon(floor[::-1], edges=edges)
    for i in range(4):
        j = (i + 1) % 4
        draft.polygon([floor[i], floor[j], roof[j], roof[i]], edges=edges)
    draft.face(surface, 1, [(edges[roof[i], roof[(i + 1) % 4]], 1) for i in range(4)])
    x, wx = np.polynomial.legendre.leggauss(60)
    gx, gy = np.meshgrid((x + 1) / 2 * w, (x + 1) / 2 * d, indexing="ij")
    z = heights(to_uv(gx.ravel(), gy.ravel())).reshape(60, 60)
    return Sample(draft.model(), float(wx @ z @ wx * w * d / 4))


SAMPLES = {
    f.__name__: f
    for f in (
        box, l_shape, two_boxes, box_with_void, matryoshka, box_cylinder, bored_block,
        conical_hole, frustum, cone_sector, fillet, sphere_capped_box, sphere_topped_cylinder,
        ball_on_stick, rounded_box, stepped_shaft, slanted_cylinder, notched_cylinder,
        cross_bored_cylinder, perforated_ring, whole_sphere, whole_torus, pipe_elbow,
        rounded_disc, half_elbow, pierced_torus, spline_top, vase, half_vase,
    )
}  # fmt: skip


def shaken(model: Model, amount: float, seed: int) -> Model:
    """The model as a fit to noisy points leaves it: surfaces and vertices moved by up to
    about ``amount``, edges where they were, so that nothing meets any more."""
    rng = np.random.default_rng(seed)
    border = [model.vertices, *(edge.curve.samples(9) for edge in model.edges)]
    size = max(1.0, float(np.ptp(np.concatenate(border), axis=0).max())) if model.edges else 1.0
    faces = []
    for face in model.faces:
        moved = rng.uniform(-amount, amount, 3) / np.sqrt(3)
        tilt = rng.uniform(-amount, amount, 3) / size
        grown = float(rng.uniform(-amount, amount))
        match s := face.surface:
            case Plane():
                surface: Surface = Plane(s.origin + moved, unit(s.normal + tilt))
            case Cylinder():
                surface = Cylinder(s.origin + moved, unit(s.axis + tilt), s.radius + grown)
            case Cone():
                angle = s.half_angle * (1 + grown / size)
                surface = Cone(s.apex + moved, unit(s.axis + tilt), angle)
            case Sphere():
                surface = Sphere(s.centre + moved, s.radius + grown)
            case Torus():
                surface = Torus(
                    s.centre + moved, unit(s.axis + tilt), s.major_radius, s.minor_radius + grown
                )
            case RevolvedSurface():
                surface = RevolvedSurface(s.origin + moved, unit(s.axis + tilt), s.profile)
            case BSplineSurface():
                surface = BSplineSurface(s.knots_u, s.knots_v, s.control_points + moved)
        faces.append(replace(face, surface=surface))
    vertices = model.vertices + rng.uniform(-amount, amount, model.vertices.shape) / 3
    return replace(model, vertices=vertices, faces=tuple(faces))
