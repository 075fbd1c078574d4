"""Border networks with exact truth: known curves between known surfaces, made ragged."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.locate import locate
from crispline.surface import Cone, Cylinder, Plane, Similarity

X, Y, Z = np.eye(3)
TURN = 2.0 * np.pi


@dataclass
class Network:
    """Collects surfaces, corners and true curves; gives them to ``locate`` with ragged chains.

    Every net vertex is up to ``raggedness`` spacings away from the truth, in any
    direction, so that chains zig-zag and run backwards.
    """

    raggedness: float = 1.0
    seed: int = 0
    vertices: list = field(default_factory=list)
    chains: list = field(default_factory=list)
    regions: dict = field(default_factory=dict)
    truth: list = field(default_factory=list)

    def region(self, label, surface, orientation=1, points=()):
        points = np.reshape(points, (-1, 3)).astype(float)
        self.regions[label] = RegionFit(surface, orientation, points, np.zeros(len(points)))

    def corner(self, *position):
        self.vertices.append(np.array(position, dtype=float))
        return len(self.vertices) - 1

    def chain(self, left, right, start=None, end=None, curve=None):
        """``curve`` maps parameters in [0, 1] to points; without it the chain is straight."""
        if curve is None:
            curve = straight(self.vertices[start], self.vertices[end])
        dense = curve(np.linspace(0.0, 1.0, 2001))
        n = max(int(length(dense)), 2)
        inner = curve(np.linspace(0.0, 1.0, n + 1))[(0 if start is None else 1) : -1]
        first = len(self.vertices)
        self.vertices.extend(inner)
        ring = list(range(first, first + len(inner)))
        ring = [*ring, first] if start is None else [start, *ring, end]
        self.chains.append(Chain(np.array(ring), left, right))
        self.truth.append(dense)

    def topology(self):
        loops = {}
        for label in self.regions:
            uses = [(i, 1) for i, chain in enumerate(self.chains) if chain.left == label]
            uses += [(i, -1) for i, chain in enumerate(self.chains) if chain.right == label]
            loops[label] = tuple(self._linked(uses))
        return Topology(tuple(self.chains), loops)

    def _linked(self, uses):
        def ends(use):
            vertices = self.chains[use[0]].vertices[:: use[1]]
            return vertices[0], vertices[-1]

        while uses:
            loop = [uses.pop(0)]
            while ends(loop[-1])[1] != ends(loop[0])[0]:
                following = next(use for use in uses if ends(use)[0] == ends(loop[-1])[1])
                uses.remove(following)
                loop.append(following)
            yield tuple(loop)

    def net_vertices(self):
        rng = np.random.default_rng(self.seed)
        shift = rng.normal(size=(len(self.vertices), 3))
        shift /= np.linalg.norm(shift, axis=1, keepdims=True)
        return np.array(self.vertices) + self.raggedness * rng.random((len(shift), 1)) * shift

    def located(self, motion=None, options=None, **only):
        motion = motion or Similarity(1.0, np.eye(3), np.zeros(3))
        regions = {
            label: replace(fit, surface=fit.surface.transformed(motion))
            for label, fit in self.regions.items()
        }
        cloud = cKDTree(motion.points(np.vstack(self.truth)))
        net_vertices = motion.points(self.net_vertices())
        found = locate(
            self.topology(), net_vertices, regions, cloud, 0.0, options or LocateOptions(), **only
        )
        return found.model, tuple(doubt.sentence(motion) for doubt in found.doubts)


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


def straight(a, b):
    return lambda t: a + t[:, None] * (b - a)


def ring(radius, height):
    """A circle about the z axis."""
    return lambda t: np.column_stack(
        [radius * np.cos(TURN * t), radius * np.sin(TURN * t), np.full(t.shape, height)]
    )


def box(raggedness, seed, size=(40.0, 30.0, 20.0)):
    """Faces 0 to 5 are x=0, x=a, y=0, y=b, z=0, z=c."""
    network = Network(raggedness, seed)
    corner = {bits: network.corner(*(np.array(bits) * size)) for bits in np.ndindex(2, 2, 2)}
    for axis, side in np.ndindex(3, 2):
        direction = np.eye(3)[axis]
        network.region(
            2 * axis + side, Plane(side * size[axis] * direction, (2 * side - 1) * direction)
        )
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for a, b in np.ndindex(2, 2):
            start = np.zeros(3, dtype=int)
            start[[u, v]] = a, b
            end = start + np.eye(3, dtype=int)[axis]
            faces = (2 * u + a, 2 * v + b)
            left, right = faces if a == b else faces[::-1]
            network.chain(left, right, corner[tuple(start)], corner[tuple(end)])
    return network


def box_with_fillet(raggedness, seed, radius=5.0, lift=0.0):
    """The box with its edge y=b, z=c rounded (region 6), the top plane lifted off the fillet."""
    a, b, c = 40.0, 30.0, 20.0
    network = Network(raggedness, seed)
    for axis, (low, high) in enumerate(((0.0, a), (0.0, b), (0.0, c + lift))):
        direction = np.eye(3)[axis]
        network.region(2 * axis, Plane(low * direction, -direction))
        network.region(2 * axis + 1, Plane(high * direction, direction))
    network.region(6, Cylinder(np.array([0.0, b - radius, c - radius]), X, radius))
    section = [(0.0, 0.0), (b, 0.0), (b, c - radius), (b - radius, c), (0.0, c)]
    sides = [4, 3, 6, 5, 2]
    corner = {
        (end, k): network.corner(end * a, *yz) for end in (0, 1) for k, yz in enumerate(section)
    }

    def arc(end):
        return lambda t: np.column_stack(
            [
                np.full(t.shape, end * a),
                b - radius + radius * np.cos(0.25 * TURN * t),
                c - radius + radius * np.sin(0.25 * TURN * t),
            ]
        )

    for k, side in enumerate(sides):
        following = (k + 1) % 5
        network.chain(1, side, corner[1, k], corner[1, following], arc(1) if side == 6 else None)
        network.chain(side, 0, corner[0, k], corner[0, following], arc(0) if side == 6 else None)
        network.chain(sides[k - 1], side, corner[0, k], corner[1, k])
    return network


def nut(raggedness, seed, inside=0.0, lost=7.0):
    """A prism of six sides (0 to 5), whose corners a cone turns (6 to 11), end (12) and base (13).

    In the end the cone passes ``inside`` the middle of each side. For ``lost`` on either side of
    it the labels show no cone.
    """
    apothem, depth, slope = 45.0, 40.0, np.tan(np.radians(30.0))
    network = Network(raggedness, seed)
    radius = apothem - inside
    cone = Cone(radius * slope * Z, -Z, np.radians(60.0))

    def place(k, aside, height=None):
        """On side ``k``, this far aside of its middle; on the cone if no height is given."""
        turn = TURN * k / 6.0
        if height is None:
            height = np.minimum(slope * (radius - np.hypot(apothem, aside)), 0.0)
        across = np.outer(np.full(np.shape(aside), apothem), [np.cos(turn), np.sin(turn)])
        along = np.outer(aside, [-np.sin(turn), np.cos(turn)])
        return np.column_stack([across + along, np.broadcast_to(height, np.shape(aside))])

    half = apothem * slope
    for k in range(6):
        network.region(
            k, Plane(place(k, np.zeros(1), 0.0)[0], place(k, np.zeros(1), 0.0)[0] / apothem)
        )
        network.region(6 + k, cone, 1, place(k, np.linspace(lost, half, 9)))
    network.region(12, Plane(np.zeros(3), Z))
    network.region(13, Plane(-depth * Z, -Z))
    tips = [
        [network.corner(*place(k, np.array([side * lost]), 0.0)[0]) for side in (-1, 1)]
        for k in range(6)
    ]
    shoulders = [network.corner(*place(k, np.array([half]))[0]) for k in range(6)]
    feet = [network.corner(*place(k, np.array([half]), -depth)[0]) for k in range(6)]
    for k in range(6):
        following = (k + 1) % 6
        before, after = tips[k][1], tips[following][0]

        def arc(t, k=k):
            angle = TURN * (k + t) / 6.0 + np.arctan2(lost, apothem) * (1.0 - 2.0 * t)
            return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), 0.0 * t])

        def rise(t, k=k):
            return place(k, lost + t * (half - lost))

        def fall(t, k=following):
            return place(k, -half + t * (half - lost))

        network.chain(12, k, *tips[k])
        network.chain(12, 6 + k, before, after, arc)
        network.chain(6 + k, k, before, shoulders[k], rise)
        network.chain(6 + k, following, shoulders[k], after, fall)
        network.chain(following, k, shoulders[k], feet[k])
        network.chain(13, k, feet[k], feet[k - 1])
    return network


def hip_roof(raggedness, seed, mismatch=0.0, ridge=2.0):
    """A pyramid whose labels show a short ridge, or one corner if ``ridge`` is zero; two opposite
    faces are lifted by ``mismatch``.
    """
    base, height = 10.0, 8.0
    network = Network(raggedness, seed)
    apex = height * Z
    feet = [
        network.corner(x * base, y * base, 0.0) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    for label, direction in enumerate((-Y, X, Y, -X)):
        normal = height * direction + base * Z
        normal /= np.linalg.norm(normal)
        network.region(label, Plane(apex + (label % 2) * mismatch * normal, normal))
    network.region(4, Plane(np.zeros(3), -Z))
    near = far = network.corner(-ridge / 2, 0.0, height)
    if ridge:
        far = network.corner(ridge / 2, 0.0, height)
    for k, top in enumerate((near, far, far, near)):
        network.chain(k, 4, feet[k], feet[(k + 1) % 4])
        network.chain((k - 1) % 4, k, feet[k], top)
    if ridge:
        network.chain(2, 0, near, far)
    return network


def equal_cylinders(raggedness, seed, difference=0.0):
    """Two half-pipes of radius 10 that cross: one closed border with two sharp turns."""
    network = Network(raggedness, seed)
    network.region(0, Cylinder(np.zeros(3), X, 10.0))
    network.region(1, Cylinder(np.zeros(3), Z, 10.0 + difference))
    network.chain(
        1,
        0,
        curve=lambda t: np.column_stack(
            [
                10.0 * np.cos(TURN * t),
                10.0 * np.sin(TURN * t),
                10.0 * np.abs(np.cos(TURN * t)),
            ]
        ),
    )
    return network


@pytest.fixture
def shapes():
    """The makers above, by name."""
    makers = (Network, ring, length, box, box_with_fillet, nut, hip_roof, equal_cylinders)
    return {maker.__name__: maker for maker in makers}
