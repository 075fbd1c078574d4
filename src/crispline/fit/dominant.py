"""The plane under a region whose rim holds strips of its neighbours.

While borders still run beside the true ones, a narrow face comes in pieces, each with some
points of what is beside it. Curved surfaces explain such mixtures halfway; the plane
that all but the rim lies on explains the face, and lets the borders move to where they belong.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crispline.fit.plane import fit_plane
from crispline.fit.residual import faces_alike
from crispline.surface import Plane, Surface
from crispline.surface.base import Array

MIN_SHARE = 0.75
"""Share of a region's points that must lie on the plane."""

_CORE_SHARE = 0.3
_MIN_CORE = 20
_ITERATIONS = 4
_CUT = 2.5
_SPREAD = 0.955  # standard deviation of a unit normal distribution cut off there
_EXCESS = 1.15
_MIN_LEAN = np.radians(20.0)
_NEARLY_ALL = 0.9
_FOREIGN = 4.0  # standard deviations
_MIN_TO_TELL = 150  # points; on fewer a plane and a gentle curve are hardly told apart


def dominant_plane(points: Array, normals: Array, clearance: Array, sigma: float) -> Plane | None:
    """The plane that the points well inside a region, and most others, lie on.

    Parameters
    ----------
    points, normals : shape ``(n, 3)``, spacings; normals outward.
    clearance : distance of each point from the region's border, shape ``(n,)``, spacings.
    sigma : noise along the normal, spacings.

    Returns
    -------
    The plane; None unless it dominates the points, see :func:`dominates`.
    """
    if len(points) < _MIN_CORE:
        return None
    n_core = max(round(_CORE_SHARE * len(points)), _MIN_CORE)
    kept = np.zeros(len(points), dtype=bool)
    kept[np.argsort(-clearance, kind="stable")[:n_core]] = True
    plane = _settled_plane(points, normals, kept, sigma)
    is_found = plane is not None and dominates(plane, points, normals, clearance, sigma)
    return plane if is_found else None


def dominates(plane: Plane, points: Array, normals: Array, clearance: Array, sigma: float) -> bool:
    """Whether a plane explains a region but for strips along its border.

    Three quarters of the points lie within 2.5 sigma and scatter there as noise does; the
    others lie nearer to the border and face elsewhere, by 20 degrees and more: a face that
    curves away from the plane gently is another surface, not a plane and its neighbours.
    """
    kept = _lies_on(plane, points, sigma)
    if kept.mean() < MIN_SHARE or not faces_alike(normals, plane.normal[None]):
        return False
    if not _scatters_as_noise(plane, points[kept], sigma):
        return False
    if kept.all():
        return True
    is_outside = np.median(clearance[~kept]) < np.median(clearance[kept])
    cosines = np.abs(normals[~kept] @ plane.normal)
    return bool(is_outside and np.median(cosines) < np.cos(_MIN_LEAN))


def plane_of_most(points: Array, normals: Array, curved: Surface, sigma: float) -> Plane | None:
    """The plane that explains most of a region as well as a curved surface explains all of it.

    Where a plane runs on into a round, a wide cone or cylinder explains the plane and the first
    of the round. But on what lies on the plane it gains nothing, as it does all over a face
    that is truly curved.

    Parameters
    ----------
    points, normals : shape ``(n, 3)``, spacings; normals outward.
    curved : that explains the points.
    sigma : noise along the normal, spacings.
    """
    if len(points) < _MIN_TO_TELL:
        return None
    plane = _settled_plane(points, normals, np.ones(len(points), dtype=bool), sigma)
    if plane is None or not faces_alike(normals, plane.normal[None]):
        return None
    kept = _lies_on(plane, points, sigma)
    misfits = [np.square(s.signed_distance(points[kept]) / sigma).sum() for s in (plane, curved)]
    spared = curved.n_parameters - plane.n_parameters
    return plane if misfits[0] - misfits[1] < 2.0 * spared * np.log(len(points)) else None


def plane_beside_few(points: Array, normals: Array, free: Surface, sigma: float) -> Plane | None:
    """The plane that explains a region but for a few points, if a free form is no cheaper.

    A small face that has half a dozen points of another one needs no control points for them:
    each counts no more than one that lies four standard deviations off.

    Parameters
    ----------
    points, normals : shape ``(n, 3)``, spacings; normals outward.
    free : a free form that explains the points.
    sigma : noise along the normal, spacings.
    """
    plane = _settled_plane(points, normals, np.ones(len(points), dtype=bool), sigma)
    if plane is None or not faces_alike(normals, plane.normal[None]):
        return None
    kept = _lies_on(plane, points, sigma)
    if kept.mean() < _NEARLY_ALL or not _scatters_as_noise(plane, points[kept], sigma):
        return None
    residuals = np.stack([surface.signed_distance(points) for surface in (plane, free)])
    misfits = np.minimum(np.square(residuals / sigma), _FOREIGN**2).sum(axis=1)
    spared = free.n_parameters - plane.n_parameters
    return plane if misfits[0] - misfits[1] < 2.0 * spared * np.log(len(points)) else None


def _scatters_as_noise(plane: Plane, points: Array, sigma: float) -> bool:
    """Whether the residuals of points that lie on a plane are as large as noise makes them."""
    residuals = plane.signed_distance(points)
    limit = _SPREAD * (_EXCESS + 1.0 / np.sqrt(len(residuals))) * sigma
    return bool(np.sqrt(np.mean(residuals**2)) <= limit)


def _settled_plane(
    points: Array, normals: Array, kept: NDArray[np.bool_], sigma: float
) -> Plane | None:
    """The plane fitted to what lies on it, from those kept; None if too few of the points do."""
    plane: Plane | None = None
    for _ in range(_ITERATIONS):
        plane = fit_plane(points[kept], normals[kept], sigma)
        if plane is None:
            return None
        kept = _lies_on(plane, points, sigma)
        if kept.mean() < MIN_SHARE:
            return None
    return plane


def _lies_on(plane: Plane, points: Array, sigma: float) -> NDArray[np.bool_]:
    return np.asarray(np.abs(plane.signed_distance(points)) < _CUT * sigma)
