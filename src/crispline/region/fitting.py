"""Fit every region to its raw points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import cKDTree

from crispline.fit.choose import KINDS, choose_surface, refit
from crispline.net.halfedge import HalfEdges
from crispline.options import FitOptions
from crispline.region.evidence import Evidence
from crispline.region.patches import Labels, PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.surface import Surface
from crispline.surface.base import Array

SCULPTURE_KINDS = ("plane", "bspline")
"""What regions of a sculpture are fitted with: no cylinder or torus is a face of it."""

_MIN_POINTS = 30
_CLEAR_SHARE = 1 / 3
_FAR = 4.0  # beyond every distance that fits ask about, spacings


@dataclass(frozen=True)
class LabelledCloud:
    """Raw points with the region and the clearance that a labelled net gives them.

    Attributes
    ----------
    points, normals : shape ``(n, 3)``, spacings; normals outward.
    region : label of the nearest patch, shape ``(n,)``.
    clearance : distance to the nearest region border, shape ``(n,)``, spacings; infinite
        beyond 4.
    noise : of each point along its normal, shape ``(n,)``, spacings.
    """

    points: Array
    normals: Array
    region: Labels
    clearance: Array
    noise: Array

    def sigma(self, *regions: int) -> float:
        """Noise of the points of some regions, by their median; of all if they have none."""
        members = np.concatenate([self._members(region) for region in regions])
        return float(np.median(self.noise[members] if len(members) else self.noise))

    def samples(self, region: int, options: FitOptions) -> tuple[Array, Array, Array]:
        """Points, normals and clearances that may enter the fit of a region.

        Points within ``options.border_margin`` of the border are left out as long
        as enough others remain: near an edge, noise takes points to the wrong side.
        A narrow region, most of which lies that near, gives the half farthest in.
        """
        members = self._members(region)
        clear = members[self.clearance[members] > options.border_margin]
        if len(clear) < max(_MIN_POINTS, _CLEAR_SHARE * len(members)):
            order = np.argsort(-self.clearance[members], kind="stable")
            clear = np.sort(members[order[: max(_MIN_POINTS, len(members) // 2)]])
        return self.points[clear], self.normals[clear], self.clearance[clear]

    def _members(self, region: int) -> Labels:
        """The points of a region, ascending."""
        first, end = np.searchsorted(self._grouped[1], [region, region + 1])
        return self._grouped[0][first:end]

    @cached_property
    def _grouped(self) -> tuple[Labels, Labels]:
        """The points in the order of their regions, and these."""
        order = np.argsort(self.region, kind="stable")
        return order, self.region[order]


def label_cloud(
    evidence: Evidence, net_vertices: Array, quads: HalfEdges, label: Labels
) -> LabelledCloud:
    """Carry the labels of the patches over to the raw points."""
    left = label[quads.quad]
    right = np.where(quads.twin >= 0, left[np.maximum(quads.twin, 0)], -1)
    border = left != right
    ends = net_vertices[quads.origin[border]], net_vertices[quads.target[border]]
    if border.any():
        marks = np.concatenate([ends[0], 0.5 * (ends[0] + ends[1])])
        clearance, _ = cKDTree(marks).query(
            evidence.points, distance_upper_bound=_FAR, workers=evidence.threads
        )
    else:
        clearance = np.full(len(evidence.points), np.inf)
    return LabelledCloud(
        evidence.points,
        evidence.normals,
        label[evidence.patch],
        np.asarray(clearance),
        evidence.noise,
    )


def fit_regions(
    labelled: LabelledCloud,
    graph: PatchGraph,
    label: Labels,
    options: FitOptions,
    known: Mapping[int, tuple[RegionFit, int]],
    kinds: Sequence[str] = KINDS,
) -> dict[int, tuple[RegionFit, int]]:
    """The surface of every region, with a fingerprint of the points it was fitted to.

    Regions whose fingerprint has not changed since ``known`` keep their fit. Where ``kinds``
    has none that explains a region, and no B-spline either, all kinds are tried.
    """
    fits: dict[int, tuple[RegionFit, int]] = {}
    for region in np.unique(label).tolist():
        points, normals, clearance = labelled.samples(region, options)
        if len(points) < _MIN_POINTS // 2:
            members = label == region
            points, normals = graph.points[members], graph.normals[members]
            clearance = np.full(len(points), 3.0)
        fingerprint = hash((points.tobytes(), options.max_points))
        if region in known and known[region][1] == fingerprint:
            fits[region] = known[region]
            continue
        fit = None
        sigma = labelled.sigma(region)
        if region in known:
            fit = refit(known[region][0].surface, points, normals, sigma, options)
        if fit is None:
            usual = KINDS if len(points) >= 2 * _MIN_POINTS else KINDS[:-1]
            wanted = usual if kinds == KINDS else kinds
            fit = choose_surface(points, normals, sigma, options, wanted, clearance)
            if wanted != usual and fit.surface.kind == "plane" and not fit.is_accepted:
                fit = choose_surface(points, normals, sigma, options, usual, clearance)
        fits[region] = (
            fitted_region(fit.surface, points, normals, fit.is_accepted),
            fingerprint,
        )
    return fits


def held_fit(surface: Surface, patches: Labels, evidence: Evidence) -> RegionFit:
    """A surface that is known from elsewhere, with the raw points of some patches."""
    members = np.isin(evidence.patch, patches)
    if not members.any():
        graph = evidence.graph
        return fitted_region(surface, graph.points[patches], graph.normals[patches], True)
    return fitted_region(surface, evidence.points[members], evidence.normals[members], True)


def fitted_region(surface: Surface, points: Array, normals: Array, is_accepted: bool) -> RegionFit:
    """Attach points and the outward side to a surface."""
    feet, directions = surface.project(points)
    side = 1 if float(np.einsum("ij,ij->", directions, normals)) >= 0.0 else -1
    residuals = np.einsum("ij,ij->i", points - feet, directions)
    return RegionFit(surface, side, points, residuals, is_accepted)
