"""Primitives that grow from a few patches to all that lie on them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crispline.fit.choose import PrimitiveFit
from crispline.fit.robust import thinned
from crispline.net.graph import components
from crispline.region.patches import Labels
from crispline.surface import Surface
from crispline.surface.base import Array

N_FIT = 250
"""Patches that a primitive is fitted to while it grows."""

_REACH = 3.0  # patches as many sigmas from a primitive are its own
_GROWN = 1.02  # growth below this has come to rest


@dataclass(frozen=True)
class Growth:
    """A primitive and the patches that it explains.

    Attributes
    ----------
    surface : the primitive.
    patches : that lie on it and hang together.
    worth : their number, each counted the less the farther it lies off: a wide cylinder
        spans two planes that meet at a few degrees, and has more patches than either,
        but not on it (MSAC: Torr and Zisserman 2000).
    """

    surface: Surface
    patches: Labels
    worth: float


@dataclass(frozen=True)
class Ground:
    """The patches among which primitives grow.

    Attributes
    ----------
    points, normals : their centres, spacings, and normals, shape ``(n, 3)``.
    adjacency : which share a side, shape ``(n, n)``.
    is_free : which may be taken, shape ``(n,)``.
    sigma : noise of the centres, spacings.
    min_cosine : patches on a surface have normals at least so much like its own.
    min_share : share of the patches it grows from that a primitive must explain.
    n_steps : how often it may grow.
    """

    points: Array
    normals: Array
    adjacency: csr_array
    is_free: NDArray[np.bool_]
    sigma: float
    min_cosine: float
    min_share: float
    n_steps: int

    def support(self, surface: Surface, seeds: Labels) -> tuple[Labels, float]:
        """Patches on a surface that hang together with most of the seeds, and their worth.

        Only the seeds on it if these are fewer than ``min_share``.
        """
        feet, directions = surface.project(self.points)
        residual = np.einsum("ij,ij->i", self.points - feet, directions) / (_REACH * self.sigma)
        turn = np.einsum("ij,ij->i", self.normals, directions)
        turn *= np.sign(turn[seeds].sum()) or 1.0
        close = self.is_free & (np.abs(residual) < 1.0) & (turn > self.min_cosine)
        patches = np.asarray(seeds[close[seeds]])
        if len(patches) >= self.min_share * len(seeds):
            piece = components(self.adjacency, close)
            pieces, votes = np.unique(piece[patches], return_counts=True)
            patches = np.flatnonzero(close & (piece == pieces[np.argmax(votes)]))
        return patches, float(np.sum(1.0 - np.square(residual[patches])))

    def grown(self, fit: PrimitiveFit, seeds: Labels) -> Growth | None:
        """The primitive, refitted to what it explains until that grows no more."""
        growth: Growth | None = None
        current = seeds
        for _ in range(self.n_steps):
            sample = current[thinned(len(current), N_FIT)]
            surface = fit(self.points[sample], self.normals[sample], self.sigma, None, True)
            if surface is None:
                return None
            growth = Growth(surface, *self.support(surface, seeds))
            if len(growth.patches) < self.min_share * len(seeds):
                return None
            if len(growth.patches) <= _GROWN * len(current):
                break
            current = growth.patches
        return growth

    def without(self, patches: Labels) -> Ground:
        """The same with some patches taken."""
        is_free = self.is_free.copy()
        is_free[patches] = False
        return replace(self, is_free=is_free)
