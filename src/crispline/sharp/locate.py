"""Step four of the paper, for fitted surfaces: where creases and corners are.

The border network of the labels tells which surfaces meet; the surfaces tell
where. Corners come first, then the curves between them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from crispline.model import Edge, Face, Model
from crispline.options import LocateOptions
from crispline.region.regionfit import RegionFit
from crispline.region.topology import Chain, Topology
from crispline.sharp.corner import Corner
from crispline.sharp.crease import Border, Crease, Ends
from crispline.sharp.doubt import Doubt
from crispline.sharp.draw import Drawing
from crispline.sharp.finder import Finder
from crispline.sharp.fourfold import with_corners_parted
from crispline.sharp.network import (
    chains_at,
    chains_by_end,
    corner_vertices,
    labels_beside,
)
from crispline.sharp.revise import split_at_branches
from crispline.sharp.rim import split_at_kinks
from crispline.sharp.search import Search, thinning
from crispline.sharp.short import collapsible_chains, without_short_borders
from crispline.sharp.sites import Sites
from crispline.sharp.tears import mended
from crispline.sharp.touch import met_at_touches
from crispline.sharp.trace import Guide, guide_along
from crispline.surface.base import Array
from crispline.surface.intersect import distance

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
    patched: Collection[int] = (),
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
    patched : labels of regions that become patches: their borders stay sides of the net, as
        long as these are, and the corners at the ends of short ones are held by the others.
    """
    doubts: list[Doubt] = []
    finder: Finder = Drawing(regions, options)
    if not is_sculpture:
        topology, torn = mended(topology, net_vertices, regions, cloud)
        doubts += [_torn(chain, net_vertices) for chain in torn]
        topology = split_at_branches(topology, net_vertices, regions)
        held = _held(topology, patched)
        met = met_at_touches(topology, net_vertices, regions, options, held)
        topology, net_vertices, touches = met
        finder = Search(regions, cloud, sigma, thinning(cloud), options, touches)
    topology, net_vertices = split_at_kinks(topology, net_vertices, options)
    anchors = corner_vertices(topology)
    guides = [_guide(chain, net_vertices, anchors) for chain in topology.chains]
    borders = finder.borders(topology.chains, guides)
    around = chains_by_end(topology, anchors)
    places, ending = net_vertices[list(around)], list(around.values())
    first = finder.corners(places, ending, topology.chains, borders)
    corners = dict(zip(around, first, strict=True))
    held = _held(topology, patched)
    sites = Sites(topology, net_vertices, tuple(borders), corners)
    if not is_sculpture:
        sites = with_corners_parted(sites, held, finder, options)
    sites, short = without_short_borders(
        sites, held, finder, options, may_exchange=not is_sculpture
    )
    doubts += short
    topology, corners = sites.topology, dict(sites.corners)
    if patched:
        short_ones = [topology.chains[index] for index in collapsible_chains(sites, options)]
        tips = {int(vertex) for chain in short_ones for vertex in chain.vertices[[0, -1]]}
        around = {
            vertex: [i for i in ending if not _is_beside(topology.chains[i], patched)]
            for vertex, ending in chains_by_end(topology, sorted(tips)).items()
        }
        places = sites.vertices[list(around)]
        apart = finder.corners(places, list(around.values()), topology.chains, sites.borders)
        corners |= dict(zip(around, apart, strict=True))
    ends = [_ends(*pair, corners) for pair in zip(topology.chains, sites.borders, strict=True)]
    creases = finder.creases(topology.chains, sites.borders, ends)
    doubts += _doubts(topology, corners, creases)
    model = _model(topology, regions, corners, sites.borders, creases, options)
    return Located(model, topology, tuple(doubts))


def _held(topology: Topology, labels: Collection[int]) -> set[int]:
    """Net vertices at the ends of the borders of some regions."""
    beside = [chain for chain in topology.chains if _is_beside(chain, labels)]
    return {int(vertex) for chain in beside for vertex in chain.vertices[[0, -1]]}


def _is_beside(chain: Chain, labels: Collection[int]) -> bool:
    return chain.left in labels or chain.right in labels


def _guide(chain: Chain, net_vertices: Array, anchors: Collection[int]) -> Guide:
    """Where the border that a chain stands for runs."""
    is_ring = chain.is_closed and int(chain.vertices[0]) not in anchors
    return guide_along(net_vertices[chain.vertices], is_ring)


def _ends(chain: Chain, border: Border, corners: Mapping[int, Corner]) -> Ends:
    """Where the border of a chain starts and ends."""
    if border.guide.is_closed:
        return None
    start, end = int(chain.vertices[0]), int(chain.vertices[-1])
    return corners[start].position, corners[end].position


def _torn(chain: Chain, net_vertices: Array) -> Doubt:
    """What to say of a tear that was mended."""
    text = (
        f"regions {_names([chain])} are so close to each other that the net is torn, or bridged, "
        "near {place}; that is mended: scan it more densely"
    )
    return Doubt(text, net_vertices[chain.vertices[0]])


def _doubts(
    topology: Topology, corners: Mapping[int, Corner], creases: Sequence[Crease]
) -> list[Doubt]:
    """One for every border and corner that the surfaces do not determine."""
    doubts = []
    for chain, crease in zip(topology.chains, creases, strict=True):
        if not crease.is_fallback:
            continue
        place = crease.curve.samples(3)[1]
        if crease.angle > _OPPOSITE and crease.gap > _LOST_GAP:
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
) -> Model:
    """Number the vertices and faces and measure the gaps."""
    face_of = {label: index for index, label in enumerate(sorted(topology.loops))} | {-1: -1}
    number = {vertex: index for index, vertex in enumerate(sorted(corners))}
    positions = [corners[vertex].position for vertex in number]
    gaps = [corners[vertex].gap for vertex in number]
    edges = []
    for chain, border, crease in zip(topology.chains, borders, creases, strict=True):
        tips = crease.curve.samples(2)
        if border.guide.is_closed:
            start = end = len(positions)
            positions.append(tips[0])
            gaps.append(float(distance(tips[:1], border.surfaces)[0]))
        else:
            start, end = number[int(chain.vertices[0])], number[int(chain.vertices[-1])]
        for vertex, tip in ((start, tips[0]), (end, tips[1])):
            gaps[vertex] = max(gaps[vertex], float(np.linalg.norm(tip - positions[vertex])))
        is_sharp = bool(np.degrees(crease.angle) >= options.smooth_angle_deg)
        left, right = face_of[chain.left], face_of[chain.right]
        edges.append(
            Edge(crease.curve, start, end, left, right, crease.gap, crease.angle, is_sharp)
        )
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
