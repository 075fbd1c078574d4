"""The method: from a cloud to a checked model, or to its sharp edges."""

from __future__ import annotations

from dataclasses import replace

from threadpoolctl import threadpool_limits

from crispline.errors import ReconstructionError
from crispline.features import located_features
from crispline.options import Options
from crispline.result import Reconstruction, failure
from crispline.stopwatch import Progress, Stopwatch

# Matrices are small everywhere: threads in the linear algebra would only wait for each other,
# and let the last digits depend on how many there are. Hence ``threadpool_limits(1)``.


def reconstruct(
    cloud: object, options: Options | None = None, progress: Progress | None = None
) -> Reconstruction:
    """Point cloud to checked B-rep model with sharp edges.

    Parameters
    ----------
    cloud : unorganised points on the surface of a part: an array of shape ``(n, 3)``, a
        file name, or what else `PointCloud.from_any` takes.
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
    with watch.guard(), threadpool_limits(1):
        found = located_features(cloud, options, watch)
        if found.opening:
            raise ReconstructionError(found.opening, found.detected)
        watch.stage("solid", 0.85)
        made = found.ladder.climb(options.model)
        result = replace(
            found.result,
            model=made.model,
            solid=made.solid,
            warnings=(*found.result.warnings, *made.warnings),
        )
        if result.valid:
            watch.stage("certificate", 0.95)
            sigma = max(result.noise, options.fit.sigma_floor * result.spacing)
            result = result.certified(found.ladder.points, sigma)
    result = replace(result, timings=watch.stop())
    if not result.valid:
        raise ReconstructionError(failure(result), result)
    return result


def detect(
    cloud: object, options: Options | None = None, progress: Progress | None = None
) -> Reconstruction:
    """Sharp edges and corners of a point cloud, without a solid; see :func:`reconstruct`."""
    watch = Stopwatch(progress)
    with watch.guard(), threadpool_limits(1):
        found = located_features(cloud, options or Options(), watch)
    return replace(found.detected, timings=watch.stop())
