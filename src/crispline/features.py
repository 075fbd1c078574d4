"""The method, stage by stage, up to the located edges and corners."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from crispline.brep.ladder import Ladder
from crispline.cloud.average import averaged
from crispline.cloud.noise import noise_levels
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.scale import N_NEIGHBOURS
from crispline.cloud.thin import thin_walls
from crispline.cloud.waves import noise_growth
from crispline.cloud.working import WorkingCloud, working_cloud
from crispline.errors import ReconstructionError
from crispline.net.halfedge import HalfEdges, half_edges
from crispline.net.orientation import oriented_normals
from crispline.net.quads import QuadNet, quad_net
from crispline.net.strays import stray_pieces, strays_sentence
from crispline.options import Options
from crispline.region.amend import moved_near, without_narrow, without_regions
from crispline.region.evidence import Evidence, gather_evidence
from crispline.region.patches import PatchGraph
from crispline.region.regionfit import RegionFit
from crispline.region.segment import Segmentation, segment
from crispline.region.topology import Topology, border_topology
from crispline.result import Reconstruction
from crispline.sharp.blend import blended
from crispline.sharp.curvature import curvature
from crispline.sharp.detect import detect as detect_sharp
from crispline.sharp.locate import Located, locate
from crispline.sharp.patched import LabelledNet
from crispline.sharp.preserve import preserve
from crispline.sharp.settle import settled
from crispline.sharp.tangency import adjusted
from crispline.spline.catmull_clark import patch_centres
from crispline.stopwatch import Stopwatch
from crispline.surface.base import Array

_BETTER = 0.8
"""Share of what corners leave open that other borders must leave at most."""


@dataclass(frozen=True)
class Features:
    """What is known before a solid is built.

    Attributes
    ----------
    ladder : what a model is made from.
    result : the edges and corners, the sharpened surface, and what the user should know.
    opening : where the net is open by accident, in words; empty if it is not.
    """

    ladder: Ladder
    result: Reconstruction
    opening: str

    @property
    def detected(self) -> Reconstruction:
        """The result with what the surfaces leave open."""
        return replace(self.result, warnings=(*self.result.warnings, *self.ladder.doubts))


def located_features(points: object, options: Options, watch: Stopwatch) -> Features:
    """From the cloud to the located edges and corners; see :func:`crispline.reconstruct`.

    Raises
    ------
    ReconstructionError
        Thin walls tear the net: no surface found on it would be one of the part.
    """
    threads = options.threads or -1
    given = PointCloud.from_any(points)
    watch.stage("cloud", 0.0)
    cloud = working_cloud(given.points, options.cloud, threads)
    cloud = averaged(cloud, options.cloud, threads)
    watch.stage("normals", 0.05)
    walls = thin_walls(cloud).sentence(cloud)
    facing = oriented_normals(cloud, options.net, threads, given)
    cloud, normals = facing.cloud, facing.normals
    watch.stage("net", 0.1)
    net = quad_net(cloud, normals, options.net, threads)
    quads = half_edges(net.quads, len(net.vertices))
    if walls and (n_rims := quads.tears()):
        raise ReconstructionError(f"the net over the points is torn at {n_rims} places: {walls}")
    watch.stage("curvature", 0.4)
    centres = patch_centres(net.vertices, net.quads)
    graph = PatchGraph(centres.point, centres.normal, quads.pairs(), net.edge_length)
    sigma = max(cloud.sigma, options.fit.sigma_floor)
    detection = detect_sharp(
        curvature(centres), graph.normals, graph.adjacency, graph.edge_length, sigma, options.detect
    )
    watch.stage("regions", 0.45)
    noise = noise_levels(cloud.points, cloud.neighbours, sigma)
    # Curvature is seen at the scale of the points, surfaces at that of faces.
    growth = options.fit.noise_growth or noise_growth(cloud.points, cloud.tree, noise, threads)
    noise, sigma = growth * noise, growth * sigma
    fit = replace(options.fit, noise_growth=growth)
    # Points that err together are one witness for a face, not two dozen.
    witnesses = 1.0 + fit.shared_variance * N_NEIGHBOURS
    region = replace(options.region, face_cost=witnesses * options.region.face_cost)
    options = replace(options, fit=fit, region=region)
    evidence = gather_evidence(cloud, normals, graph, noise, threads, is_sided=facing.is_sided)
    regions = segment(
        evidence, net.vertices, quads, detection.is_sharp, options.region, options.fit
    )
    watch.stage("edges", 0.8)
    raw = cloud.to_user.points(cloud.scan)
    stray = np.full(len(raw), -1)
    if net.is_open:
        stray = stray_pieces(cloud.scan, net.vertices, options.net.min_piece, threads)
    place = _Placing(net, quads, evidence, cloud, raw[stray < 0], sigma, options)
    ladder = place.best_ladder(regions)
    places = cloud.to_user.points(net.vertices)
    opening = "" if net.is_open else quads.opening(places)
    strays = strays_sentence(raw, stray)
    rims = (quads.rims(places),) if net.is_open and not quads.is_closed else ()
    result = Reconstruction(
        model=ladder.model.transformed(cloud.to_user),
        patches=replace(ladder.net, vertices=cloud.to_user.points(ladder.net.vertices)),
        spacing=cloud.spacing,
        noise=growth * cloud.scan_noise * cloud.sigma * cloud.spacing,
        warnings=(
            *cloud.warnings(given.n_dropped),
            *([_shared(growth)] if growth > 1.0 else []),
            *facing.notes,
            *([walls] if walls else []),
            *net.notes,
            *([strays] if strays else []),
            *([opening] if opening else rims),
        ),
        patch_kinds=detection.kinds(),
        plain_vertices=cloud.to_user.points(net.vertices),
    )
    return Features(ladder, result, opening)


def _shared(growth: float) -> str:
    """That points err together, and what that means for the faces."""
    return (
        f"points err together with those round them, {growth:.2g} times as much over a face as "
        "over two dozen points: faces are judged by that noise, and what is finer than it is lost"
    )


@dataclass(frozen=True)
class _Placing:
    """From regions to what a model is built from.

    Attributes
    ----------
    points : what the model is compared with, in the user's unit.
    """

    net: QuadNet
    quads: HalfEdges
    evidence: Evidence
    cloud: WorkingCloud
    points: Array
    sigma: float
    options: Options

    def ladder(self, regions: Segmentation) -> Ladder:
        """The edges and corners of the regions, and what tells other ways if they fail."""
        net, options, to_user = self.net, self.options, self.cloud.to_user
        topology = border_topology(self.quads, regions.label)
        fits, find = _finder(topology, net.vertices, regions, self.cloud, self.sigma, options)
        located = find()
        smooth = settled(net, regions.label, fits, options.locate.settle_move)
        max_move = options.locate.preserve_move
        return Ladder(
            located.model,
            LabelledNet(smooth, regions.label, located.topology),
            preserve(smooth, located.topology, located.model, max_move),
            net.vertices,
            to_user,
            self.points,
            max_move,
            regions.has_faces,
            tuple(d.sentence(to_user) for d in located.doubts if regions.has_faces),
            lambda labels: find(patched=labels),
            lambda labels: self._amended(
                without_regions(regions, labels, self.evidence, self.quads, options.region)
            ),
            lambda labels: self._amended(
                without_narrow(regions, labels, self.evidence.graph, self.quads, options.region)
            ),
        )

    def best_ladder(self, regions: Segmentation) -> Ladder:
        """The ladder of the regions, or of those with other borders near lost corners if these
        leave less open.
        """
        first = self.ladder(regions)
        max_gap = self.options.locate.corner_gap
        lost = first.model.vertex_gaps > max_gap
        if not (regions.has_faces and lost.any()):
            return first
        places, options = first.model.vertices[lost], self.options.region
        moved = moved_near(regions, places, self.evidence, self.quads, options)
        if moved is None:
            return first
        second = self.ladder(moved)
        gaps = [one.model.vertex_gaps[one.model.vertex_gaps > max_gap] for one in (first, second)]
        return second if gaps[1].sum() < _BETTER * gaps[0].sum() else first

    def _amended(self, regions: Segmentation | None) -> Ladder | None:
        return None if regions is None else self.ladder(regions)


def _finder(
    topology: Topology,
    net_vertices: Array,
    regions: Segmentation,
    cloud: WorkingCloud,
    sigma: float,
    options: Options,
) -> tuple[Mapping[int, RegionFit], Callable[..., Located]]:
    """The surfaces as they meet each other, and what locates where.

    A sculpture is made of patches, which have sharp edges only, and clear ones.
    """
    fits, accepted = regions.fits, options.locate
    if regions.has_faces:
        fits = adjusted(topology, net_vertices, fits, sigma, options.fit, accepted)
        fits = blended(topology, net_vertices, fits, sigma, options.fit, accepted)
    else:
        clear = max(accepted.smooth_angle_deg, accepted.sculpture_angle_deg)
        accepted = replace(accepted, smooth_angle_deg=clear)
    return fits, partial(
        locate,
        topology,
        net_vertices,
        fits,
        cloud.tree,
        sigma,
        accepted,
        is_sculpture=not regions.has_faces,
    )
