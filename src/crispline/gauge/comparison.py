"""Any CAD model against any cloud: the deviation of every point, in numbers per face."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crispline import occt
from crispline.cloud.scale import cloud_scale
from crispline.gauge.carriers import carriers
from crispline.gauge.certificate import (
    MIN_POINTS,
    N_SIGMAS,
    Residuals,
    face_residuals,
    residuals,
)
from crispline.gauge.distance import Deviations, deviations
from crispline.occt.measure import diagonal, face_areas
from crispline.surface.base import Array

_N_BINS = 39
_SHOWN = 0.995
"""Share of the points whose sizes set the range of the histogram."""
_FINEST = 1 / 200
"""Search step on the model where the cloud is sparse or its spacing unknown, in model sizes."""
_STRANGER = 0.05
"""Median deviation above which cloud and model hardly belong together, in model sizes."""


@dataclass(frozen=True)
class ComparedFace:
    """A face and the points nearest to it.

    Attributes
    ----------
    kind, parameters : of the surface, as :meth:`crispline.surface.Surface.parameters` has them.
    area : of the trimmed face.
    residuals : of its points.
    """

    kind: str
    parameters: Mapping[str, float | list[float]]
    area: float
    residuals: Residuals


@dataclass(frozen=True)
class Comparison:
    """Lengths in the unit of the model.

    Attributes
    ----------
    found : where every point lies with respect to the model.
    step : length that the search was made with: the spacing, or less on a sparse cloud.
    spacing, noise : of the cloud; NaN where it has too few points to tell.
    limit : deviation that the shares ``explained`` refer to: the tolerance if one was
        given, else 3 sigma of the noise; NaN if neither is known.
    tolerance : None if none was given.
    whole : of all points.
    faces : in exploration order.
    bin_edges, counts : histogram of the signed deviations, shape ``(b + 1,)`` and ``(b,)``.
        The outer bins hold what lies beyond them too.
    warnings : sentences.
    """

    found: Deviations
    step: float
    spacing: float
    noise: float
    limit: float
    tolerance: float | None
    whole: Residuals
    faces: tuple[ComparedFace, ...]
    bin_edges: Array
    counts: NDArray[np.int64]
    warnings: tuple[str, ...]

    @property
    def worst_face(self) -> int | None:
        """The face with the largest p95 among those with 20 points or more; None if none."""
        judged = [i for i, f in enumerate(self.faces) if f.residuals.n_points >= MIN_POINTS]
        return max(judged, key=lambda i: self.faces[i].residuals.p95, default=None)

    @property
    def is_within(self) -> bool | None:
        """Whether 95 % of the points of every face lie within the tolerance, if there is one.

        Faces with fewer than 20 points are not judged; if all are such, all points together are.
        """
        if self.tolerance is None:
            return None
        worst = self.worst_face
        p95 = self.whole.p95 if worst is None else self.faces[worst].residuals.p95
        return p95 <= self.tolerance

    @property
    def verdict(self) -> str:
        """What was found, in words."""
        parts = [f"p95 {self.whole.p95:.4g}, largest {self.whole.max:.4g}"]
        if np.isfinite(self.limit):
            what = "the tolerance" if self.tolerance is not None else f"{N_SIGMAS:g} sigma"
            parts.insert(
                0, f"{100.0 * self.whole.explained:.1f} % of the points lie within {what} "
                f"({self.limit:.4g})"
            )  # fmt: skip
        if self.worst_face is not None:
            face = self.faces[self.worst_face]
            name = f"face {self.worst_face} ({face.kind})"
            parts.append(f"worst {name}: p95 {face.residuals.p95:.4g}")
        return "; ".join(parts)


def compare(shape: Any, points: Array, tolerance: float | None = None) -> Comparison:
    """Measure a cloud against a model.

    Parameters
    ----------
    shape : any ``TopoDS_Shape`` with faces.
    points : the cloud in the unit and the frame of the model, shape ``(n, 3)``. All points
        count, outliers too.
    tolerance : deviation that is allowed, in that unit.

    Raises
    ------
    InputError
        The model has no face, or a surface that cannot be measured.
    """
    size = diagonal(shape)
    spacing, noise = cloud_scale(points)
    step = min(spacing, _FINEST * size) if np.isfinite(spacing) else _FINEST * size
    found = deviations(shape, points, step)
    limit = tolerance if tolerance is not None else N_SIGMAS * noise
    numbers = face_residuals(found, len(occt.subshapes(shape, occt.FACE)), limit)
    whole = residuals(found.distance, limit)
    if not np.isfinite(limit):
        whole = replace(whole, explained=np.nan)
        numbers = tuple(replace(face, explained=np.nan) for face in numbers)
    edges, counts = _histogram(found.distance)
    kinds = carriers(occt.subshapes(shape, occt.FACE)).described()
    faces = tuple(
        ComparedFace(kind, parameters, float(area), face)
        for (kind, parameters), area, face in zip(kinds, face_areas(shape), numbers, strict=True)
    )
    return Comparison(
        found,
        step,
        spacing,
        noise,
        limit,
        tolerance,
        whole,
        faces,
        edges,
        counts,
        _warnings(found.distance, size),
    )


def _histogram(distance: Array) -> tuple[Array, NDArray[np.int64]]:
    size = np.abs(distance)
    reach = float(np.quantile(size, _SHOWN)) or float(size.max()) or 1.0
    edges = np.linspace(-reach, reach, _N_BINS + 1)
    return edges, np.histogram(np.clip(distance, -reach, reach), edges)[0].astype(np.int64)


def _warnings(distance: Array, size: float) -> tuple[str, ...]:
    middle = float(np.median(np.abs(distance)))
    if middle <= _STRANGER * size:
        return ()
    return (
        f"half of the points lie farther than {middle:.4g} from the model, which is "
        f"{size:.4g} across: the cloud may be in another unit (see --units) or another frame",
    )
