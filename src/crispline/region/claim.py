"""What it costs to give patches, and borders along their sides, to one region."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.options import RegionOptions
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface.base import Array

OUT_OF_REACH = 1e3
"""Cost of a patch that a region may not take."""

MISFIT_CAP = 8.0
"""Squared residuals over 2 sigma^2 count no more than this."""

_TURN_WEIGHT, _TURN_CAP = 4.0, 2.0  # cost of a normal off the surface's: weight (1 - cos), capped


def misfit(distance: Array, noise: Array) -> Array:
    """Squared residuals over 2 sigma^2, capped; both of the same shape."""
    return np.asarray(np.minimum(0.5 * np.square(distance / noise), MISFIT_CAP))


def cheapest_together(costs: Array, members: Labels, graph: PatchGraph) -> Labels:
    """Index of the surface that each patch and its neighbours together find cheapest.

    Parameters
    ----------
    costs : of the ``n`` patches on ``k`` surfaces, shape ``(n, k)``.
    members : the patches, ascending; only these count as neighbours.
    """
    beside = graph.adjacency[members][:, members]
    mean = (costs + beside @ costs) / (1.0 + np.asarray(beside.sum(axis=1))[:, None])
    return np.asarray(np.argmin(mean, axis=1))


class Claim:
    """The costs of one region's surface, worked out where they are asked for and kept.

    They depend on the surface and the raw points only, not on the labels, which
    alone decide what is within reach.
    """

    def __init__(self, fit: RegionFit, evidence: Evidence, options: RegionOptions) -> None:
        self._fit, self._evidence, self._options = fit, evidence, options
        # Zeros that nobody touches take no memory, and most of these stay untouched.
        self._patches = np.zeros(len(evidence.graph))
        self._sides = np.zeros(len(evidence.graph.pairs))
        self._has_patch = np.zeros(len(evidence.graph), dtype=bool)
        self._has_side = np.zeros(len(evidence.graph.pairs), dtype=bool)

    def reach(self, members: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Patches near enough to the region's ``members`` to be taken, shape ``(m,)``."""
        return self._evidence.graph.rings(members, self._options.expansion_rings)

    def patch_costs(self, within: NDArray[np.bool_]) -> Array:
        """Cost of every patch of a mask, out of reach elsewhere, shape ``(m,)``."""
        self._evaluate_patches(np.flatnonzero(within & ~self._has_patch))
        cost = np.full(self._patches.shape, OUT_OF_REACH)
        cost[within] = self._patches[within]
        return cost

    def costs(self, patches: NDArray[np.int64], sides: NDArray[np.int64]) -> tuple[Array, Array]:
        """Cost of patches and the region's share of the cost of a border along sides.

        Two regions can only meet where both their surfaces pass: a side costs more
        the farther it lies from either. So a border moves to where the surfaces
        intersect, and surfaces that do not meet make room for what is between them.

        Returns
        -------
        Shapes ``(m,)`` and ``(e,)``: of all, of which only those asked for up to now mean
        anything, as copies for every region of a large net would take long.
        """
        self._evaluate_patches(patches[~self._has_patch[patches]])
        self._evaluate_sides(sides[~self._has_side[sides]])
        return self._patches, self._sides

    def _evaluate_patches(self, patches: NDArray[np.int64]) -> None:
        if len(patches) == 0:
            return
        graph = self._evidence.graph
        sigma = self._evidence.patch_noise[patches, None]
        distance = self._evidence.misfit(self._fit, patches)
        data = np.minimum(distance**2 / (2.0 * sigma**2), MISFIT_CAP).mean(axis=1)
        directions = self._fit.surface.project(graph.points[patches])[1] * self._fit.orientation
        turn = 1.0 - np.einsum("ij,ij->i", directions, graph.normals[patches])
        self._has_patch[patches] = True
        self._patches[patches] = data + np.minimum(_TURN_WEIGHT * turn, _TURN_CAP)

    def _evaluate_sides(self, sides: NDArray[np.int64]) -> None:
        if len(sides) == 0:
            return
        graph = self._evidence.graph
        middle = graph.points[graph.pairs[sides]].mean(axis=1)
        squared = (self._fit.surface.signed_distance(middle) / self._options.border_miss) ** 2
        self._has_side[sides] = True
        excess = np.minimum(squared, self._options.border_miss_cap)
        self._sides[sides] = self._options.border_cost * (0.5 + excess)
