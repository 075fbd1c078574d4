"""Step four of the paper, for fitted surfaces: where creases and corners are.

The border network of the labels tells which surfaces meet; the surfaces tell
where. Corners come first, then the curves between them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from crispline.cloud.nearest import nearest
from crispline.model import Edge, Face, Model
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.corner import Corner, locate_corner
from crispline.sharp.crease import (
    N_SAMPLES,
    Border,
    Crease,
    border_between,
    contacts_at,
    locate_crease,
)
from crispline.sharp.doubt import Doubt
from crispline.sharp.draw import N_SAMPLES as N_DRAWN
from crispline.sharp.draw import drawn_border, drawn_corner, drawn_crease
from crispline.sharp.network import (
    chains_at,
    chains_by_end,
    contracted,
    corner_vertices,
    labels_beside,
)
from crispline.sharp.revise import collapsible_chain, split_at_branches
from crispline.sharp.rim import split_at_kinks
from crispline.sharp.tears import mended
from crispline.sharp.touch import met_at_touches
from crispline.sharp.trace import guide_along
from crispline.surface.base import Array
from crispline.surface.intersect import distance, intersect

_MAX_THINNING = 4.0
_OPPOSITE = np.radians(120.0)  # sides of a wall that face away from each other so much ...
_LOST_GAP = 0.5  # ... and stay this far from their border, in spacings, have a face between them


@dataclass(frozen=True)
class Located:
    """Where everything is.

    Attributes
    ----------
    model : faces in the order of their labels, with honest gaps.
    topology : the border network after collapses and splits; its chains stand
        in the order of the model's edges.
    doubts : one per corner or border that the surfaces do not determine, and
        per collapsed border.
    """

    model: Model
    topology: Topology
    doubts: tuple[Doubt, ...]


def locate(
    topology: Topology,
    net_vertices: Array,
    regions: Mapping[int, RegionFit],
    cloud: cKDTree,
    sigma: float,
    options: LocateOptions,
    *,
    is_sculpture: bool = False,
) -> Located:
    """Turn a labelled net and its fitted surfaces into a boundary representation.

    Parameters
    ----------
    topology : chains, corners and loops of the labels.
    net_vertices : vertices of the net, spacings, shape ``(n, 3)``.
    regions : the fitted surface of every label.
    cloud : the raw points, spacings.
    sigma : noise of the raw points, spacings.
    options : what is accepted.
    is_sculpture : whether the model will be of patches: then borders are only drawn between
        their surfaces, and only sharp ones hold a corner.
    """
    search = _Search(regions, cloud, sigma, _thinning(cloud), options, is_sculpture)
    doubts: list[Doubt] = []
    touches: set[int] = set()
    if not is_sculpture:
        topology, torn = mended(topology, net_vertices, regions, cloud)
        doubts += [_torn(chain, net_vertices) for chain in torn]
        topology = split_at_branches(topology, net_vertices, regions)
        found = met_at_touches(topology, net_vertices, regions, options)
        topology, net_vertices, touches = found
    topology, net_vertices = split_at_kinks(topology, net_vertices, options)
    anchors = corner_vertices(topology)
    borders = [search.border(chain, net_vertices, anchors) for chain in topology.chains]
    corners = {
        vertex: search.corner(vertex, topology, net_vertices, borders, around)
        for vertex, around in chains_by_end(topology, anchors).items()
    }
    while (index := collapsible_chain(topology, net_vertices, corners, options)) is not None:
        gone = topology.chains[index]
        kept, lost = int(gone.vertices[0]), int(gone.vertices[-1])
        net_vertices = net_vertices.copy()
        net_vertices[kept] = 0.5 * (net_vertices[kept] + net_vertices[lost])
        topology = contracted(topology, index)
        del borders[index], corners[lost]
        around = chains_at(topology, kept)
        corners[kept] = search.corner(kept, topology, net_vertices, borders, around)
        text = (
            f"the border of regions {_names([gone])} near {{place}} is shorter "
            "than its corners are certain and became one corner"
        )
        doubts.append(Doubt(text, net_vertices[kept]))
    creases = [
        search.crease(chain, border, corners, touches)
        for chain, border in zip(topology.chains, borders, strict=True)
    ]
    doubts += _doubts(topology, corners, borders, creases)
    n_samples = N_DRAWN if is_sculpture else N_SAMPLES
    model = _model(topology, regions, corners, borders, creases, options, n_samples)
    return Located(model, topology, tuple(doubts))


@dataclass(frozen=True)
class _Search:
    """What every corner and crease is located on and judged by."""

    regions: Mapping[int, RegionFit]
    cloud: cKDTree
    sigma: float
    thinning: float
    options: LocateOptions
    is_sculpture: bool

    def border(self, chain: Chain, net_vertices: Array, anchors: Collection[int]) -> Border:
        """The border that a chain stands for."""
        sides = [self.regions[label] for label in (chain.left, chain.right) if label != -1]
        is_ring = chain.is_closed and int(chain.vertices[0]) not in anchors
        guide = guide_along(net_vertices[chain.vertices], is_ring)
        find = drawn_border if self.is_sculpture else border_between
        return find(guide, sides, self.options)

    def corner(
        self,
        vertex: int,
        topology: Topology,
        net_vertices: Array,
        borders: Sequence[Border],
        around: list[int],
    ) -> Corner:
        """The corner at a net vertex, where the chains ``around`` end."""
        if self.is_sculpture:
            around = [index for index in around if not borders[index].is_contact]
        labels = labels_beside(topology.chains[index] for index in around)
        surfaces = [self.regions[label].surface for label in labels]
        if not surfaces:
            return Corner(net_vertices[vertex], 0.0, is_fallback=False)
        if len(surfaces) == 1:  # a corner of a rim: only the end of the points holds it
            foot = intersect(net_vertices[vertex][None], surfaces)[0][0]
            return Corner(foot, 0.0, is_fallback=False)
        if self.is_sculpture:
            return drawn_corner(net_vertices[vertex], surfaces, self.options)
        beside = [borders[index] for index in around]
        contacts = contacts_at(net_vertices[vertex], surfaces, beside)
        return locate_corner(
            net_vertices[vertex],
            surfaces,
            contacts,
            self.cloud,
            self.thinning * self.options.corner_cloud_distance + 2.0 * self.sigma,
            self.options,
        )

    def crease(
        self, chain: Chain, border: Border, corners: Mapping[int, Corner], touches: Collection[int]
    ) -> Crease:
        """The curve of a border; it goes all the way to a corner where surfaces touch."""
        ends, options = None, self.options
        if not border.guide.is_closed:
            start, end = int(chain.vertices[0]), int(chain.vertices[-1])
            ends = (corners[start].position, corners[end].position)
            if start in touches or end in touches:
                options = replace(options, corner_gap=0.0)
        if self.is_sculpture:
            return drawn_crease(border, ends)
        max_cloud_distance = self.thinning * self.options.crease_cloud_distance + 2.0 * self.sigma
        return locate_crease(border, ends, self.cloud, max_cloud_distance, options)


def _thinning(cloud: cKDTree) -> float:
    """Spacing where the cloud is thinnest over the median spacing; 1 for an even cloud."""
    distance, _ = nearest(cloud, np.asarray(cloud.data), min(9, cloud.n))
    even, thin = np.quantile(distance[:, -1], [0.5, 0.99])
    return float(np.clip(thin / max(1.5 * even, 1e-12), 1.0, _MAX_THINNING))


def _torn(chain: Chain, net_vertices: Array) -> Doubt:
    """What to say of a tear that was mended."""
    text = (
        f"the wall between regions {_names([chain])} is so thin that the net is torn near "
        "{place}; the tear is closed: scan it more densely"
    )
    return Doubt(text, net_vertices[chain.vertices[0]])


def _doubts(
    topology: Topology,
    corners: Mapping[int, Corner],
    borders: Sequence[Border],
    creases: Sequence[Crease],
) -> list[Doubt]:
    """One for every border and corner that the surfaces do not determine."""
    doubts = []
    for chain, border, crease in zip(topology.chains, borders, creases, strict=True):
        if not crease.is_fallback:
            continue
        place = crease.curve.samples(3)[1]
        if border.angle(crease.curve.samples(N_SAMPLES)) > _OPPOSITE and crease.gap > _LOST_GAP:
            text = (
                f"a face between regions {_names([chain])} near {{place}} is lost, as it is only "
                f"{2.0 * crease.gap:.2g} spacings wide: scan it more densely"
            )
        else:
            text = (
                f"the surfaces of regions {_names([chain])} have no common curve near {{place}}: "
                f"their border is smoothed, with a gap of {crease.gap:.2g} spacings"
            )
        doubts.append(Doubt(text, place))
    for vertex, corner in corners.items():
        if corner.is_fallback:
            around = [topology.chains[index] for index in chains_at(topology, vertex)]
            text = (
                f"the surfaces of regions {_names(around)} have no common point near {{place}}: "
                f"the corner has a gap of {corner.gap:.2g} spacings"
            )
            doubts.append(Doubt(text, corner.position))
    return doubts


def _model(
    topology: Topology,
    regions: Mapping[int, RegionFit],
    corners: Mapping[int, Corner],
    borders: Sequence[Border],
    creases: Sequence[Crease],
    options: LocateOptions,
    n_samples: int,
) -> Model:
    """Number the vertices and faces and measure the gaps."""
    face_of = {label: index for index, label in enumerate(sorted(topology.loops))} | {-1: -1}
    number = {vertex: index for index, vertex in enumerate(sorted(corners))}
    positions = [corners[vertex].position for vertex in number]
    gaps = [corners[vertex].gap for vertex in number]
    edges = []
    for chain, border, crease in zip(topology.chains, borders, creases, strict=True):
        samples = crease.curve.samples(n_samples)
        if border.guide.is_closed:
            start = end = len(positions)
            positions.append(samples[0])
            gaps.append(float(distance(samples[:1], border.surfaces)[0]))
        else:
            start, end = number[int(chain.vertices[0])], number[int(chain.vertices[-1])]
        for vertex, tip in ((start, samples[0]), (end, samples[-1])):
            gaps[vertex] = max(gaps[vertex], float(np.linalg.norm(tip - positions[vertex])))
        angle = border.angle(samples)
        is_sharp = bool(np.degrees(angle) >= options.smooth_angle_deg)
        left, right = face_of[chain.left], face_of[chain.right]
        edges.append(Edge(crease.curve, start, end, left, right, crease.gap, angle, is_sharp))
    faces = tuple(
        Face(
            regions[label].surface,
            regions[label].orientation,
            topology.loops[label],
            regions[label].points,
            regions[label].residuals,
            label,
        )
        for label in sorted(topology.loops)
    )
    vertices = np.array(positions, dtype=np.float64).reshape(-1, 3)
    return Model(vertices, np.array(gaps, dtype=np.float64), tuple(edges), faces)


def _names(chains: Iterable[Chain]) -> str:
    """The regions beside chains, for a message."""
    return ", ".join(str(label) for label in labels_beside(chains))
