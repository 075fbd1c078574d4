"""The whole pipeline on clouds of the paper's model, measured on the STEP file it writes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from crispline import pipeline
from crispline.cadfile.step import read_step
from crispline.cloud.working import working_cloud
from crispline.errors import CrisplineError
from crispline.gauge.accuracy import shape_distances, surface_samples
from crispline.net.orientation import oriented_normals
from crispline.net.quads import quad_net
from crispline.options import Options
from crispline.paper.measure import N_REVERSE, Deviation, mean_and_p99
from crispline.paper.patches import Patches
from crispline.paper.rows import Trial
from crispline.paper.windows import FEATURES, REACH, Feature
from crispline.shapes import Sample, Sampling, box_cylinder, distance_to_box_cylinder, sample
from crispline.spline.bezier import bezier_patches
from crispline.spline.creased import CreasedNet
from crispline.surface.base import Array

N_POINTS = 34_000
"""As many as the paper's cloud."""
POSITION: Mapping[Sampling, str] = {
    "grid": "grid 0.00",
    "half-cell": "grid 0.50",
    "random": "random",
}
"""What the rows call the samplings of :func:`crispline.shapes.sample`."""

_N_MODEL_SAMPLES = 50_000
_DEFLECTION = 0.002


@dataclass(frozen=True)
class WholeRun:
    """One cloud of the whole model."""

    sampling: Sampling
    noise: float
    seed: int
    n_points: int = N_POINTS

    @property
    def title(self) -> str:
        """What progress shows."""
        return f"whole clouds at {100.0 * self.noise:g} % noise"

    @property
    def cost(self) -> float:
        """How long it takes, in runs on grids."""
        return 20.0

    def trials(self, threads: int) -> list[Trial]:
        """Reconstruct the cloud once and measure every kind of feature."""
        scan = sample(
            box_cylinder(),
            self.n_points,
            sampling=self.sampling,
            noise=self.noise,
            seed=self.seed,
        )
        options = Options(threads=threads)
        plain = plain_surface(scan.points, options)
        before = _deviations(scan, plain.distances, *plain.samples(N_REVERSE))
        after: dict[Feature, Deviation] | None = None
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "model.step"
            try:
                pipeline.reconstruct(scan.points, options).write(path)
            except CrisplineError:
                pass
            else:
                model = read_step(path)
                points = surface_samples(model, _N_MODEL_SAMPLES, _DEFLECTION * scan.spacing)
                areas = np.ones(len(points))  # uniform by area
                after = _deviations(scan, lambda x: shape_distances(x, model), points, areas)
        return [
            Trial(
                method="pipeline",
                sampling=POSITION[self.sampling],
                noise=self.noise,
                feature=feature,
                seed=self.seed,
                before=before[feature],
                after=None if after is None else after[feature],
                found=None,
                n_windows=1,
                n_failed=int(after is None),
            )
            for feature in FEATURES
        ]


def plain_surface(points: Array, options: Options) -> Patches:
    """The bicubic surface over the pipeline's own net, before any feature is preserved."""
    threads = options.threads or -1
    cloud = working_cloud(points, options.cloud, threads)
    normals = oriented_normals(cloud, options.net, threads).normals
    net = quad_net(cloud, normals, options.net, threads)
    none = np.zeros((0, 2), dtype=np.int64)
    vertices = cloud.to_user.points(net.vertices)
    return Patches(bezier_patches(CreasedNet(vertices, net.quads, none, none[:, 0])))


def _deviations(
    scan: Sample, distances: Callable[[Array], Array], points: Array, areas: Array
) -> dict[Feature, Deviation]:
    """Per kind of feature: its error, and the reverse distance within a window's reach of it.

    Parameters
    ----------
    distances : maps points ``(n, 3)`` to their distances to the surface.
    points, areas : samples of the surface, shape ``(k, 3)``, and what they stand for.
    """
    away = distance_to_box_cylinder(points) / scan.spacing
    found: dict[Feature, Deviation] = {}
    for feature in FEATURES:
        truth = feature_points(scan, feature)
        near = cKDTree(truth).query(points)[0] <= REACH * scan.spacing
        error = float(distances(truth).mean() / scan.spacing)
        found[feature] = Deviation(error, *mean_and_p99(away[near], areas[near]))
    return found


def feature_points(scan: Sample, feature: Feature) -> Array:
    """True points of all features of a kind, 100 an edge, shape ``(k, 3)``."""
    if feature == "corner":
        return scan.shape.corners
    return np.concatenate([edge.points for edge in scan.shape.edges if edge.kind == feature])
