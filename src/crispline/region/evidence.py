"""What the raw points say of the patches; it stays the same while the labels change."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crispline.cloud.working import WorkingCloud
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.region.sides import nearest_alike
from crispline.surface.base import Array

N_WITNESSES = 4
"""Raw points that speak for a patch."""


@dataclass(frozen=True)
class Evidence:
    """Patches, raw points, and which belong together.

    Attributes
    ----------
    graph : the patches, ``m`` of them.
    points, normals : the raw points and their outward normals, shape ``(n, 3)``, spacings.
    patch : nearest patch of each point, shape ``(n,)``.
    witnesses : the raw points nearest to each patch, shape ``(m, N_WITNESSES, 3)``.
    noise : of each point along the normal (standard deviation), shape ``(n,)``, spacings.
    patch_noise : that of the point nearest to each patch, shape ``(m,)``.
    threads : threads for neighbour queries; results do not depend on it.
    """

    graph: PatchGraph
    points: Array
    normals: Array
    patch: NDArray[np.int64]
    witnesses: Array
    noise: Array
    patch_noise: Array
    threads: int = -1

    def misfit(self, fit: RegionFit, patches: NDArray[np.int64]) -> Array:
        """Distance of the witnesses of patches from a surface, shape ``(k, N_WITNESSES)``."""
        witnesses = self.witnesses[patches].reshape(-1, 3)
        return np.abs(fit.surface.signed_distance(witnesses)).reshape(-1, N_WITNESSES)


def gather_evidence(
    cloud: WorkingCloud,
    normals: Array,
    graph: PatchGraph,
    noise: Array,
    threads: int = -1,
    *,
    is_sided: bool = False,
) -> Evidence:
    """Connect a cloud with outward normals, shape ``(n, 3)``, to the patches over it.

    A normal on the wrong side of the nearest patch is turned round.

    Parameters
    ----------
    noise : of each point along its normal, shape ``(n,)``, spacings.
    is_sided : whether the normals tell the points on one side of a thin wall from those on the
        other.
    """
    if is_sided:
        patch = nearest_alike(cloud.points, normals, graph.tree, graph.normals, 1, threads)[:, 0]
        nearest = nearest_alike(
            graph.points, graph.normals, cloud.tree, normals, N_WITNESSES, threads
        )
    else:
        patch = np.asarray(graph.tree.query(cloud.points, workers=threads)[1])
        nearest = np.asarray(cloud.tree.query(graph.points, k=N_WITNESSES, workers=threads)[1])
    agree = np.einsum("ij,ij->i", normals, graph.normals[patch])
    return Evidence(
        graph=graph,
        points=cloud.points,
        normals=np.where((agree < 0.0)[:, None], -normals, normals),
        patch=np.asarray(patch, dtype=np.int64),
        witnesses=cloud.points[nearest],
        noise=noise,
        patch_noise=noise[nearest[:, 0]],
        threads=threads,
    )
