"""How well a model explains its cloud: the residuals of all points on the shape as written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from crispline import occt
from crispline.cadfile.step import open_step, step_bytes
from crispline.cloud.nearest import nearest
from crispline.gauge.distance import Deviations, Gauge
from crispline.occt.measure import Tessellation
from crispline.surface.base import Array

N_SIGMAS = 3.0
"""A point is explained if it lies within this many noise sigmas of the model."""
MIN_POINTS = 20
"""Faces with fewer points have no quantile to speak of, and none is held against them."""
_SAME = 1e-5
"""A point this near to one that was measured is the same, but for rounding, in spacings."""
_MAX_FACES = 300
"""Shapes of more faces are measured as they are in memory: reading them back takes long."""


@dataclass(frozen=True)
class Residuals:
    """Signed deviations in numbers, in the unit of the points; NaN where there is no point.

    Attributes
    ----------
    n_points : how many.
    rms, p95, max : root mean square, 95 % quantile and largest of their sizes.
    mean : signed mean; positive if the points lie outside.
    explained : share within the limit that was given.
    """

    n_points: int
    rms: float
    p95: float
    max: float
    mean: float
    explained: float


@dataclass(frozen=True)
class Certificate:
    """Lengths in the user's unit.

    Attributes
    ----------
    noise : the sigma that the shares refer to: that of the cloud, or the floor of the fits.
    spacing : mean distance between neighbouring points.
    whole : of all points.
    faces : of the points nearest to each face, in exploration order.
    points, found : the points that were measured, shape ``(n, 3)``, and where each lies.
    gauge : what they were measured with.
    """

    noise: float
    spacing: float
    whole: Residuals
    faces: tuple[Residuals, ...]
    points: Array = field(compare=False, repr=False)
    found: Deviations = field(compare=False, repr=False)
    gauge: Gauge = field(compare=False, repr=False)

    def deviations(self, points: Array) -> Deviations:
        """Where points lie; those that were measured already are not measured again.

        Parameters
        ----------
        points : shape ``(n, 3)``, for example the cloud with its outliers.
        """
        away, row = nearest(cKDTree(self.points), points, 1)
        other = np.flatnonzero(away[:, 0] > _SAME * self.spacing)
        known = self.found
        same = row[:, 0]
        distance, face, foot = known.distance[same], known.face[same], known.foot[same]
        if len(other):
            rest = self.gauge.deviations(points[other])
            distance[other], face[other], foot[other] = rest.distance, rest.face, rest.foot
        return Deviations(distance, face, foot)

    @property
    def worst_face(self) -> int | None:
        """The face with the largest p95 among those with ``MIN_POINTS`` points; None if none."""
        judged = [i for i, face in enumerate(self.faces) if face.n_points >= MIN_POINTS]
        return max(judged, key=lambda i: self.faces[i].p95, default=None)


def certify(
    shape: Any, points: Array, spacing: float, noise: float, mesh: Tessellation | None = None
) -> Certificate:
    """Measure a cloud against a shape as it comes back from a STEP file.

    Parameters
    ----------
    shape : in the user's unit.
    points : the cloud without outliers, shape ``(n, 3)``.
    spacing : mean distance between neighbouring points.
    noise : standard deviation of the points along the normal, at least the floor of the fits.
    mesh : see :func:`crispline.gauge.distance.deviations`.

    Raises
    ------
    InputError
        The shape has no face.
    """
    n_faces = len(occt.subshapes(shape, occt.FACE))
    gauge = Gauge.of(_as_written(shape, n_faces), spacing, mesh)
    found = gauge.deviations(points)
    return Certificate(
        noise,
        spacing,
        residuals(found.distance, N_SIGMAS * noise),
        face_residuals(found, n_faces, N_SIGMAS * noise),
        points,
        found,
        gauge,
    )


def residuals(distance: Array, limit: float) -> Residuals:
    """The numbers of signed deviations, shape ``(n,)``; ``limit`` as in `Residuals.explained`.

    >>> residuals(np.array([-1.0, 3.0]), limit=2.0)  # doctest: +NORMALIZE_WHITESPACE
    Residuals(n_points=2, rms=2.23606797749979, p95=2.9, max=3.0, mean=1.0, explained=0.5)
    """
    if not len(distance):
        return Residuals(0, *[float("nan")] * 5)
    size = np.abs(distance)
    return Residuals(
        len(size),
        float(np.sqrt(np.mean(size**2))),
        float(np.quantile(size, 0.95)),
        float(size.max()),
        float(distance.mean()),
        float(np.mean(size <= limit)),
    )


def face_residuals(found: Deviations, n_faces: int, limit: float) -> tuple[Residuals, ...]:
    """The numbers of each face's points, in exploration order."""
    order = np.argsort(found.face, kind="stable")
    ends = np.searchsorted(found.face[order], np.arange(1, n_faces))
    return tuple(residuals(part, limit) for part in np.split(found.distance[order], ends))


def _as_written(shape: Any, n_faces: int) -> Any:
    """The shape after a round trip through STEP; itself if that gives other faces."""
    if n_faces > _MAX_FACES:
        return shape
    for has_pcurves in (False, True):
        reader = open_step(step_bytes(shape, has_pcurves))
        copy = reader.OneShape() if reader is not None and reader.TransferRoots() else None
        if copy is not None and len(occt.subshapes(copy, occt.FACE)) == n_faces:
            return copy
    return shape
