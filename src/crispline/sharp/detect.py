"""Flat, curved and sharp patches (step 3 of the paper), robust to noise and position."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from crispline.net.graph import components
from crispline.options import DetectOptions
from crispline.surface.base import Array

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Detection:
    """Which patches are curved and which are sharp.

    Attributes
    ----------
    is_curved : curvature above the threshold, shape ``(m,)``.
    is_sharp : curved between flat patches that face different ways, shape ``(m,)``.
    threshold : the larger curvature threshold used, 1/length.
    """

    is_curved: Mask
    is_sharp: Mask
    threshold: float

    def kinds(self) -> NDArray[np.uint8]:
        """0 flat, 1 curved, 2 sharp, shape ``(m,)``."""
        return np.add(self.is_curved, self.is_sharp, dtype=np.uint8)


def detect(
    curvature: Array,
    normals: Array,
    adjacency: csr_array,
    edge_length: float,
    sigma: float,
    options: DetectOptions,
) -> Detection:
    """Classify patches by curvature with hysteresis, and by what lies around them.

    Noise of standard deviation ``sigma`` shows as ``|H| h`` of about
    ``0.17 sigma / h`` on flat patches of side ``h``, so thresholds follow from
    it. A component of patches above the low threshold is curved if it holds at
    least two patches above the high one; a curved patch is sharp if the flat
    patches within ``options.rings`` rings face directions more than
    ``options.spread_deg`` apart. The paper's rule (one threshold, 4 flat of 8
    neighbours) is the special case of a band one patch wide.

    Parameters
    ----------
    curvature : mean curvature at the centres, shape ``(m,)``, 1/length.
    normals : unit normals at the centres, shape ``(m, 3)``.
    adjacency : patches that share a side, shape ``(m, m)``.
    edge_length : side ``h`` of the patches.
    sigma : noise along the normal, the unit of ``edge_length``.
    """
    bend = np.abs(curvature) * edge_length
    noise = sigma / edge_length
    high = max(options.curved_floor, options.curved_sigmas * noise)
    low = max(0.8 * options.curved_floor, 0.6 * options.curved_sigmas * noise)
    candidate = bend > low
    piece = components(adjacency, candidate)
    strong = np.bincount(piece[candidate], bend[candidate] > high, minlength=piece.max() + 1)
    is_curved = candidate & (strong[piece] >= 2)
    spread = normal_spread(normals, adjacency, is_curved, options.rings)
    is_sharp = is_curved & (spread > np.radians(options.spread_deg))
    return Detection(is_curved, is_sharp, high / edge_length)


def normal_spread(
    normals: Array,
    adjacency: csr_array,
    is_curved: Mask,
    rings: int,
    wanted: Mask | None = None,
) -> Array:
    """Angle between the flat normals that differ most within ``rings`` rings, shape ``(m,)``.

    Evaluated at the wanted patches (by default the curved ones), 0 elsewhere. The
    farthest pair is sought by three sweeps (farthest from the mean, then twice
    farthest from the last), which is exact for normals on an arc and never less
    than half the truth.
    """
    reach = adjacency
    for _ in range(rings - 1):
        reach = reach @ adjacency + reach
        reach.data[:] = 1.0
    evaluated = np.flatnonzero(is_curved if wanted is None else wanted)
    rows, columns = reach[evaluated].nonzero()
    centre = evaluated[rows]
    flat = ~is_curved[columns]
    centre, around = centre[flat], columns[flat]
    reference = np.zeros_like(normals)
    for axis in range(3):
        reference[:, axis] = np.bincount(centre, normals[around, axis], minlength=len(normals))
    cosine = np.ones(len(normals))
    for _ in range(3):
        agreement = np.einsum("ij,ij->i", reference[centre], normals[around])
        order = np.lexsort((agreement, centre))
        first = np.ones(len(order), dtype=bool)
        first[1:] = centre[order][1:] != centre[order][:-1]
        farthest = order[first]
        cosine[centre[farthest]] = agreement[farthest]
        reference[centre[farthest]] = normals[around[farthest]]
    return np.arccos(np.clip(cosine, -1.0, 1.0))
