"""Torus through noisy points."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from crispline.fit.frame import frame_about, radial, tilted
from crispline.fit.robust import DistanceModel, coarse, fit_distances
from crispline.fit.starts import axis_of_revolution, extent, local_quadric
from crispline.surface import Torus
from crispline.surface.base import Array

MIN_POINTS = 8
MAX_RADIUS = 3.0
"""In extents of the data; a larger radius belongs to a cylinder or a plane."""

_N_TILTS = 6


def fit_torus(
    points: Array,
    normals: Array,
    sigma: float,
    start: Torus | None = None,
    is_draft: bool = False,
) -> Torus | None:
    """Robust orthogonal-distance torus.

    Parameters
    ----------
    points : shape ``(n, 3)``, spacings.
    normals : unit normals, shape ``(n, 3)``; used for start values only.
    sigma : noise along the normal, spacings.
    start : start value; by default the best of several.
    is_draft : see :func:`crispline.fit.robust.fit_distances`.

    Returns
    -------
    The torus; None for fewer than eight points, a radius beyond 3 extents, or
    a tube that crosses its own axis.
    """
    if len(points) < MIN_POINTS:
        return None
    kept = coarse(len(points))
    starts = _starts(points[kept], normals[kept]) if start is None else iter([start])
    torus = fit_distances(MODEL, starts, points, sigma, is_draft)
    if torus is None:
        return None
    is_ring = 0.0 < torus.minor_radius < torus.major_radius
    return torus if is_ring and torus.major_radius < MAX_RADIUS * extent(points) else None


def _starts(points: Array, normals: Array) -> Iterator[Torus]:
    """The line that the normals meet; then what the principal curvatures leave open."""
    origin, axis = axis_of_revolution(points, normals)
    yield _about_axis(points, origin, axis)
    quadric = local_quadric(points, normals)
    # By Meusnier's theorem the axis meets the normal line at the centre of curvature of
    # the parallel circle; its direction in the meridian plane is not determined there.
    for tube, parallel in ((1, 0), (0, 1)):
        on_axis = quadric.origin + quadric.normal / quadric.curvatures[parallel]
        for angle in np.arange(_N_TILTS) * (np.pi / _N_TILTS):
            axis = np.cos(angle) * quadric.directions[tube] + np.sin(angle) * quadric.normal
            yield _about_axis(points, on_axis, axis)


def _about_axis(points: Array, origin: Array, axis: Array) -> Torus:
    """Algebraic circle of the points in the meridian half plane of a known axis."""
    offset = points - origin
    height = offset @ axis
    rho = np.linalg.norm(offset - height[:, None] * axis, axis=1)
    middle = np.array([rho.mean(), height.mean()])
    plane = np.column_stack([rho, height]) - middle
    a, b, c = np.linalg.lstsq(
        np.column_stack([2.0 * plane, np.ones(len(plane))]),
        np.sum(plane**2, axis=1),
        rcond=None,
    )[0]
    return Torus(
        origin + (middle[1] + b) * axis,
        axis,
        float(middle[0] + a),
        float(np.sqrt(max(c + a * a + b * b, 1e-12))),
    )


def linearise(torus: Torus, points: Array) -> tuple[Array, Array]:
    """Signed distances and derivatives by shifts, tilts, major, minor radius ``(n, 7)``."""
    local = (points - torus.centre) @ frame_about(torus.axis).T
    rho, inward = radial(local, 2)
    section = np.column_stack([rho - torus.major_radius, local[:, 2]])
    length, inward_section = radial(section, 2)
    jacobian = np.empty((len(points), 7))
    jacobian[:, :2] = -inward_section[:, :1] * inward
    jacobian[:, 2] = inward_section[:, 1]
    # A tilt lifts the spine below the point; the tube's own turn does not count.
    jacobian[:, 3:5] = torus.major_radius * inward_section[:, 1:] * inward
    jacobian[:, 5] = inward_section[:, 0]
    jacobian[:, 6] = -1.0
    return length - torus.minor_radius, jacobian


def move(torus: Torus, step: Array) -> Torus:
    """Shift and tilt about the centre, change both radii."""
    frame = frame_about(torus.axis)
    return Torus(
        torus.centre + step[:3] @ frame,
        tilted(frame, step[3], step[4]),
        torus.major_radius + float(step[5]),
        torus.minor_radius + float(step[6]),
    )


MODEL = DistanceModel(linearise, move)
