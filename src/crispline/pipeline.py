"""The method, stage by stage."""

from __future__ import annotations

from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from crispline.brep.compose import make_solid
from crispline.cloud.pointcloud import PointCloud
from crispline.cloud.working import WorkingCloud, working_cloud
from crispline.errors import ReconstructionError
from crispline.net.halfedge import half_edges
from crispline.net.orientation import oriented_normals
from crispline.net.quads import quad_net
from crispline.options import Options
from crispline.region.evidence import gather_evidence
from crispline.region.patches import PatchGraph
from crispline.region.segment import segment
from crispline.region.topology import border_topology
from crispline.result import Reconstruction, failure
from crispline.sharp.curvature import curvature
from crispline.sharp.detect import detect as detect_sharp
from crispline.sharp.locate import locate
from crispline.sharp.preserve import preserve
from crispline.spline.catmull_clark import patch_centres
from crispline.stopwatch import Progress, Stopwatch


def reconstruct(
    cloud: PointCloud | ArrayLike, options: Options | None = None, progress: Progress | None = None
) -> Reconstruction:
    """Point cloud to checked B-rep model with sharp edges.

    Parameters
    ----------
    cloud : unorganised points on the surface of a part; an array has shape ``(n, 3)``.
    options : see :class:`crispline.options.Options`.
    progress : called with the name of each stage and the share of the run done.

    Raises
    ------
    InputError
        The cloud cannot be used.
    ReconstructionError
        No valid model could be made; ``partial`` holds edges, corners and faces.
    """
    options = options or Options()
    watch = Stopwatch(progress)
    with watch.guard():
        found = _features(cloud, options, watch)
        if found.opening:
            raise ReconstructionError(found.opening, found.result)
        watch.stage("solid", 0.85)
        points = found.cloud.to_user.points(found.cloud.points)
        solid = make_solid(found.result.model, points, found.cloud.spacing)
    result = replace(found.result, solid=solid, timings=watch.stop())
    if not result.valid:
        raise ReconstructionError(failure(result), result)
    return result


def detect(
    cloud: PointCloud | ArrayLike, options: Options | None = None, progress: Progress | None = None
) -> Reconstruction:
    """Sharp edges and corners of a point cloud, without a solid; see :func:`reconstruct`."""
    watch = Stopwatch(progress)
    with watch.guard():
        found = _features(cloud, options or Options(), watch)
    return replace(found.result, timings=watch.stop())


@dataclass(frozen=True)
class _Features:
    """The clean cloud, the result as far as edges and corners, and where the net is open."""

    cloud: WorkingCloud
    result: Reconstruction
    opening: str


def _features(points: PointCloud | ArrayLike, options: Options, watch: Stopwatch) -> _Features:
    """Everything up to the located edges and corners."""
    threads = options.threads or -1
    given = points if isinstance(points, PointCloud) else PointCloud.from_arrays(points)
    watch.stage("cloud", 0.0)
    cloud = working_cloud(given.points, options.cloud, threads)
    watch.stage("normals", 0.05)
    normals, _ = oriented_normals(cloud, options.net, threads)
    watch.stage("net", 0.1)
    net = quad_net(cloud, normals, options.net, threads)
    quads = half_edges(net.quads, len(net.vertices))
    watch.stage("curvature", 0.4)
    centres = patch_centres(net.vertices, net.quads)
    graph = PatchGraph(centres.point, centres.normal, quads.pairs(), net.edge_length)
    sigma = max(cloud.sigma, options.fit.sigma_floor)
    detection = detect_sharp(
        curvature(centres), graph.normals, graph.adjacency, graph.edge_length, sigma, options.detect
    )
    watch.stage("regions", 0.45)
    evidence = gather_evidence(cloud, normals, graph, sigma, threads)
    regions = segment(
        evidence, net.vertices, quads, detection.is_sharp, options.region, options.fit
    )
    watch.stage("edges", 0.8)
    topology = border_topology(quads, regions.label)
    located = locate(topology, net.vertices, regions.fits, cloud.tree, sigma, options.locate)
    patches = preserve(net, located.topology, located.model)
    opening = quads.opening(cloud.to_user.points(net.vertices))
    result = Reconstruction(
        model=located.model.transformed(cloud.to_user),
        patches=replace(patches, vertices=cloud.to_user.points(patches.vertices)),
        spacing=cloud.spacing,
        noise=cloud.sigma * cloud.spacing,
        warnings=(
            *cloud.warnings(given.n_dropped),
            *([opening] if opening else []),
            *(d.sentence(cloud.to_user) for d in located.doubts),
        ),
    )
    return _Features(cloud, result, opening)
