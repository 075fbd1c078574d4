"""Borders and corners of trimmed faces: solved for on their surfaces, judged by the cloud."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain
from crispline.sharp.corner import Corner, locate_corner
from crispline.sharp.crease import (
    Border,
    Crease,
    Ends,
    border_between,
    contacts_at,
    locate_crease,
)
from crispline.sharp.network import labels_beside, side_labels
from crispline.sharp.trace import Guide
from crispline.surface.base import Array
from crispline.surface.intersect import intersect

_MAX_THINNING = 4.0


@dataclass(frozen=True)
class Search:
    """Finds each border and corner by itself; see :class:`crispline.sharp.draw.Drawing`.

    Attributes
    ----------
    regions : the surface of every label.
    cloud : the raw points, spacings.
    sigma : their noise, spacings.
    thinning : see :func:`thinning`.
    options : what is accepted.
    touches : net vertices at which surfaces touch: borders go all the way to these.
    """

    regions: Mapping[int, RegionFit]
    cloud: cKDTree
    sigma: float
    thinning: float
    options: LocateOptions
    touches: Set[int]

    def borders(self, chains: Sequence[Chain], guides: Sequence[Guide]) -> list[Border]:
        return [
            border_between(
                guide, [self.regions[label] for label in side_labels(chain)], self.options
            )
            for chain, guide in zip(chains, guides, strict=True)
        ]

    def corners(
        self,
        places: Array,
        around: Sequence[Sequence[int]],
        chains: Sequence[Chain],
        borders: Sequence[Border],
    ) -> list[Corner]:
        return [
            self._corner(place, [chains[i] for i in ending], [borders[i] for i in ending])
            for place, ending in zip(places, around, strict=True)
        ]

    def _corner(self, place: Array, chains: Sequence[Chain], borders: Sequence[Border]) -> Corner:
        """The corner where some borders end."""
        surfaces = [self.regions[label].surface for label in labels_beside(chains)]
        if not surfaces:  # patches all round: the net holds it
            return Corner(place, 0.0, is_fallback=False)
        if len(surfaces) == 1:  # a corner of a rim: only the end of the points holds it
            return Corner(intersect(place[None], surfaces)[0][0], 0.0, is_fallback=False)
        return locate_corner(
            place,
            surfaces,
            contacts_at(place, surfaces, borders),
            self.cloud,
            self.thinning * self.options.corner_cloud_distance + 2.0 * self.sigma,
            self.options,
        )

    def creases(
        self, chains: Sequence[Chain], borders: Sequence[Border], ends: Sequence[Ends]
    ) -> list[Crease]:
        away = self.thinning * self.options.crease_cloud_distance + 2.0 * self.sigma
        return [
            locate_crease(
                border,
                tips,
                self.cloud,
                away,
                self.options,
                [int(vertex) in self.touches for vertex in chain.vertices[[0, -1]]],
            )
            for border, tips, chain in zip(borders, ends, chains, strict=True)
        ]


def thinning(cloud: cKDTree) -> float:
    """Spacing where the cloud is thinnest over the median spacing; 1 for an even cloud."""
    distance, _ = nearest(cloud, np.asarray(cloud.data), min(9, cloud.n))
    even, thin = np.quantile(distance[:, -1], [0.5, 0.99])
    return float(np.clip(thin / max(1.5 * even, 1e-12), 1.0, _MAX_THINNING))
