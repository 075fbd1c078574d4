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
from crispline.surface import Similarity


@dataclass
class Network:
    """Collects corners, true curves and surfaces; gives them to ``locate`` with ragged chains."""

    raggedness: float = 1.0
    seed: int = 0
    vertices: list = field(default_factory=list)
    chains: list = field(default_factory=list)
    regions: dict = field(default_factory=dict)
    truth: list = field(default_factory=list)

    def region(self, label, surface, orientation=1):
        points = np.zeros((0, 3))
        self.regions[label] = RegionFit(surface, orientation, points, np.zeros(0))

    def corner(self, *position):
        self.vertices.append(np.array(position, dtype=float))
        return len(self.vertices) - 1

    def chain(self, left, right, start, end, curve=None):
        """``curve`` maps parameters in [0, 1] to points; a straight chain without it.

        ``start`` is None for a closed chain.
        """
        if curve is None:
            a, b = self.vertices[start], self.vertices[end]
            curve = lambda t: a + t[:, None] * (b - a)  # noqa: E731
        dense = curve(np.linspace(0.0, 1.0, 2001))
        length = np.linalg.norm(np.diff(dense, axis=0), axis=1).sum()
        n = max(int(length), 2)
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
            sides = [(i, 1) for i, chain in enumerate(self.chains) if chain.left == label]
            sides += [(i, -1) for i, chain in enumerate(self.chains) if chain.right == label]
            loops[label] = tuple(self._linked(sides))
        return Topology(tuple(self.chains), loops)

    def _linked(self, sides):
        def ends(side):
            vertices = self.chains[side[0]].vertices[:: side[1]]
            return vertices[0], vertices[-1]

        while sides:
            loop = [sides.pop(0)]
            while ends(loop[-1])[1] != ends(loop[0])[0]:
                following = next(s for s in sides if ends(s)[0] == ends(loop[-1])[1])
                sides.remove(following)
                loop.append(following)
            yield tuple(loop)

    def ragged_vertices(self):
        rng = np.random.default_rng(self.seed)
        vertices = np.array(self.vertices)
        shift = rng.normal(size=vertices.shape)
        shift /= np.linalg.norm(shift, axis=1, keepdims=True)
        return vertices + self.raggedness * rng.random((len(vertices), 1)) * shift

    def cloud(self):
        return np.vstack(self.truth)

    def locate(self, motion=None, options=None, sigma=0.0):
        motion = motion or Similarity(1.0, np.eye(3), np.zeros(3))
        regions = {
            label: replace(fit, surface=fit.surface.transformed(motion))
            for label, fit in self.regions.items()
        }
        return locate(
            self.topology(),
            motion.points(self.ragged_vertices()),
            regions,
            cKDTree(motion.points(self.cloud())),
            sigma,
            options or LocateOptions(),
        )


def add_box(network, size, planes, offset=0):
    """A box ``[0, size]`` with faces labelled ``offset + (x0, x1, y0, y1, z0, z1)``."""
    corner = {}
    for bits in np.ndindex(2, 2, 2):
        corner[bits] = network.corner(*(np.array(bits) * size))
    for label, plane in enumerate(planes):
        network.region(offset + label, plane)
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for a, b in np.ndindex(2, 2):
            start, end = [0, 0, 0], [0, 0, 0]
            start[u] = end[u] = a
            start[v] = end[v] = b
            end[axis] = 1
            # Along +axis with u, v right-handed: the face that is met turning left from outside.
            faces = (offset + 2 * u + a, offset + 2 * v + b)
            left, right = faces if a == b else faces[::-1]
            network.chain(left, right, corner[tuple(start)], corner[tuple(end)])
    return corner


@pytest.fixture
def make_network():
    return Network


@pytest.fixture
def add_box_to():
    return add_box
